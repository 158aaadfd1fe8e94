// For the test of the published JSON schema: writes one problem file of every kind into a folder; with --read, prints the
// names of the files in it that the reader takes.

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "generators/sets.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;

ContactProblem one_contact(Inertia inertia, bool friction) {
  ContactProblem problem;
  problem.v = Vector{{1, -2}};
  problem.N = Matrix{{0}, {1}};
  problem.D = friction ? Matrix{{1, -1}, {0, -0.0}} : Matrix(2, 0);
  problem.edges = {friction ? 2 : 0};
  problem.mu = Vector{{friction ? 0.5 : 0.0}};
  problem.inertia = std::move(inertia);
  return problem;
}

/// A row of every kind: with two bounds, without any, with one, and of friction.
ContactProblem with_rows(ContactProblem problem) {
  problem.rows.R = Matrix{{1, 0, 1, 0}, {0, 1, -0.5, 2}};
  problem.rows.bounds = LcpBounds::nonnegative(4);
  problem.rows.bounds.lower = Vector{{-0.25, -INFINITY, 0, -INFINITY}};
  problem.rows.bounds.upper(0) = 0.5;
  problem.rows.bounds.friction_of[3] = 2;
  problem.rows.bounds.mu(3) = 0.5;
  problem.rows.b = Vector{{0.1, 0, -1, 0}};
  problem.rows.compliance = Vector{{0, 1e-3, 0, 0}};
  problem.rows.is_angle = {0, 1, 0, 0};
  problem.rows.names = {"friction", "hinge", "", "screw"};
  return problem;
}

RigidScene two_bodies() {
  RigidScene scene;
  scene.bodies.resize(2);
  RigidContact sticky;
  sticky.edges = 4;
  sticky.mu = 0.5;
  RigidContact smooth;
  smooth.body_a = 1;
  smooth.body_b = 0;
  scene.contacts = {sticky, smooth};
  return scene;
}

/// Large enough to be written sparse.
ContactProblem sparse_contact() {
  constexpr Index kBlocks = 300;
  ContactProblem problem;
  problem.v = Vector::Constant(kBlocks, -1);
  SparseMatrix N(kBlocks, kBlocks);
  N.setIdentity();
  problem.N = N;
  problem.D = SparseMatrix(kBlocks, 0);
  problem.edges.assign(kBlocks, 0);
  problem.mu = Vector::Zero(kBlocks);
  problem.inertia = BlockInertia{std::vector<Matrix>(kBlocks, Matrix::Identity(1, 1))};
  return problem;
}

/// Plain text: a header, a step with all that it may have, and one with nothing.
void write_steps(const fs::path& file) {
  const Problem problem("step", two_bodies());
  std::ofstream lines(file);
  lines << R"({"format":"lcpbench-scenes","version":1,"scene":"s","engine":"e","engine_version":"1","loop":"engine",)"
        << R"("step_length":0.01,"gravity":[0,0,-9.81],"shapes":[{"body":0,"type":"sphere","size":[1]},)"
        << R"({"body":1,"type":"hull","size":[0,0,0,1,0,0,0,1,0,0,0,1]}]})" << '\n';
  lines << R"({"step":1,"time":0.1,"problem":)" << problem_json_line(problem)
        << R"(,"gap":[0,1],"contact_ids":["a",""],"poses":[[0,0,0,1,0,0,0],[]],)"
        << R"("engine":{"impulses":[0,0,0,0,0,0],"velocity":[0,0,0,0,0,0,0,0,0,0,0,0]}})" << '\n';
  lines << R"({"step":2,"problem":)" << problem_json_line(Problem("sparse", sparse_contact())) << "}\n";
  lines.close();
  const ScenesFile scenes(file.string());  // what the schema is shown, the reader accepts
  for (std::size_t i = 0; i < scenes.count(); ++i) scenes.read(i);
}

void write_all(const fs::path& folder) {
  const auto write = [&](const std::string& file, auto data) {
    write_problem(Problem(file, std::move(data)), folder / (file + ".json"));
  };
  const Matrix unit = Matrix::Identity(2, 2);
  write("lcp", Lcp{Matrix{{2, -0.0}, {1e-300, 2}}, Vector{{-5, 1e300}}});
  Lcp mixed{unit, Vector{{-1, 1}}, LcpBounds::nonnegative(2)};
  mixed.bounds.upper(0) = 1;
  mixed.bounds.lower(1) = -INFINITY;
  mixed.bounds.friction_of[1] = 0;
  mixed.bounds.mu(1) = 0.5;
  write("mixed", mixed);
  write("lcp-empty", Lcp{Matrix(0, 0), Vector(0)});
  write("frictional", one_contact(DenseInertia{unit}, true));
  write("frictionless", one_contact(DenseInertia{unit}, false));
  write("factored", one_contact(FactoredInertia{Matrix{{1}, {2}}, Vector{{0.5}}}, true));
  write("inverse", one_contact(InverseInertia{unit}, true));
  write("blocks", one_contact(BlockInertia{{unit}}, true));
  write("rows", with_rows(one_contact(DenseInertia{unit}, true)));
  write("scene", two_bodies());
  write("scene-empty", RigidScene{});
  write("sparse", sparse_contact());
  write_steps(folder / "steps.scenes");
  int count = 0;
  for (const SetInfo& set : list_sets()) {
    write_problem(open_set(set.name)->generate(1, 0), folder / ("set-" + std::to_string(count++) + ".json"));
  }
}

void print_readable(const fs::path& folder) {
  for (const fs::directory_entry& file : fs::directory_iterator(folder)) {
    try {
      read_problem(file.path());
      std::printf("%s\n", file.path().stem().c_str());
    } catch (const InputError&) {
      continue;
    }
  }
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc == 3 && std::string_view(argv[1]) == "--read") {
    lcpbench::print_readable(argv[2]);
  } else if (argc == 2) {
    lcpbench::write_all(argv[1]);
  } else {
    std::fprintf(stderr, "usage: write_problem_files [--read] FOLDER\n");
    return 2;
  }
  return 0;
}
