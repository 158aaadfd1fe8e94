// Drake's LCP solvers as a program for lcpbench's external solver:
//
//   lcpbench solve problem.json --solver 'external{command=./drake_solver moby}' --solver contact_lemke
//
// The argument is moby, moby_regularized, moby_fast or unrevised. docs/howto/drake.md shows how to build it.
#include <Eigen/Core>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include <drake/solvers/moby_lcp_solver.h>
#include <drake/solvers/unrevised_lemke_solver.h>
#include <nlohmann/json.hpp>

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::json;

/// Drake's word for success; z comes in empty, so that no solver takes it for a start.
using Method = std::function<bool(const MatrixXd& M, const VectorXd& q, VectorXd* z, int* pivots)>;

const std::map<std::string, Method> kMethods{
    {"moby",
     [](const MatrixXd& M, const VectorXd& q, VectorXd* z, int* pivots) {
       drake::solvers::MobyLCPSolver<double> solver;
       const bool solved = solver.SolveLcpLemke(M, q, z);
       *pivots = static_cast<int>(solver.get_num_pivots());
       return solved;
     }},
    {"moby_regularized",
     [](const MatrixXd& M, const VectorXd& q, VectorXd* z, int* pivots) {
       drake::solvers::MobyLCPSolver<double> solver;
       const bool solved = solver.SolveLcpLemkeRegularized(M, q, z);
       *pivots = static_cast<int>(solver.get_num_pivots());
       return solved;
     }},
    {"moby_fast",
     [](const MatrixXd& M, const VectorXd& q, VectorXd* z, int* pivots) {
       drake::solvers::MobyLCPSolver<double> solver;
       const bool solved = solver.SolveLcpFast(M, q, z);
       *pivots = static_cast<int>(solver.get_num_pivots());
       return solved;
     }},
    {"unrevised",
     [](const MatrixXd& M, const VectorXd& q, VectorXd* z, int* pivots) {
       return drake::solvers::UnrevisedLemkeSolver<double>().SolveLcpLemke(M, q, z, pivots);
     }},
};

struct Lcp {
  MatrixXd M;
  VectorXd q;
};

Lcp read_lcp(const json& problem) {
  const auto q = problem.at("q").get<std::vector<double>>();
  const auto n = static_cast<Eigen::Index>(q.size());
  Lcp lcp{MatrixXd(n, n), Eigen::Map<const VectorXd>(q.data(), n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto row = problem.at("M").at(static_cast<std::size_t>(i)).get<std::vector<double>>();
    lcp.M.row(i) = Eigen::Map<const VectorXd>(row.data(), n);
  }
  return lcp;
}

json solve(const Method& method, const Lcp& lcp) {
  VectorXd z;
  int pivots = 0;
  try {
    if (!method(lcp.M, lcp.q, &z, &pivots)) return {{"claim", "numerical_failure"}, {"detail", "Drake returned false"}};
  } catch (const std::exception& error) {
    return {{"claim", "numerical_failure"}, {"detail", error.what()}};
  }
  return {{"claim", "solved"}, {"z", std::vector<double>(z.data(), z.data() + z.size())}, {"pivots", pivots}};
}

}  // namespace

int main(int count, char** arguments) {
  const auto method = kMethods.find(count == 2 ? arguments[1] : "");
  if (method == kMethods.end()) {
    std::cerr << "usage: drake_solver moby|moby_regularized|moby_fast|unrevised\n";
    return 2;
  }
  Lcp lcp;
  for (std::string line; std::getline(std::cin, line);) {
    const json question = json::parse(line);
    json reply = json::object();
    if (question.at("verb") == "problem") lcp = read_lcp(question.at("problem"));
    if (question.at("verb") == "solve") reply = solve(method->second, lcp);
    reply["sequence"] = question.at("sequence");
    std::cout << reply.dump() << std::endl;
  }
}
