#include "native/lemke/lemke_loaded.h"

#include <Eigen/Core>
#include <cstddef>
#include <stdexcept>
#include <variant>
#include <vector>

#include "core/solver.h"

namespace lcpbench::lemke {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Engine* create(LemkeEngine engine, IsaLevel level) {
  const bool dense = engine == LemkeEngine::kDense;
  if (level > best_isa_level()) throw std::invalid_argument("this processor lacks the instruction-set level asked for");
#if defined(__x86_64__)
  if (level == IsaLevel::kAvx512) return dense ? avx512::create_dense_engine() : avx512::create_kernel_engine();
  if (level == IsaLevel::kAvx2) return dense ? avx2::create_dense_engine() : avx2::create_kernel_engine();
#endif
  return dense ? baseline::create_dense_engine() : baseline::create_kernel_engine();
}

void load_matrix(const Lcp& lcp, bool covers_all, Engine& engine) {
  Input input;
  input.covers_all = covers_all;
  input.n = input.dense = lcp.size();
  input.q = lcp.q.data();
  input.M = lcp.M.data();
  engine.load(input);
}

void load_contact(const ContactProblem& contact, bool covers_all, Engine& engine) {
  const ContactLayout layout = contact_layout(contact);
  const Index impulses = layout.nc + layout.friction;
  RowMajorMatrix J(contact.ngc(), impulses);
  std::visit([&](const auto& N) { J.leftCols(layout.nc) = N; }, contact.N);
  std::visit([&](const auto& D) { J.rightCols(layout.friction) = D; }, contact.D);
  Vector q = Vector::Zero(layout.size());
  q.head(impulses).noalias() = J.transpose() * contact.v;
  if (contact.has_offset()) q.head(layout.nc) += contact.b;
  const Matrix Ginv = inverse_inertia(contact.inertia);

  std::vector<std::ptrdiff_t> friction_begin;
  std::vector<std::ptrdiff_t> cone_normal;
  std::vector<double> mu;
  for (const Index normal : layout.cone_contact) {
    friction_begin.push_back(layout.friction_offset() + layout.friction_begin[static_cast<std::size_t>(normal)]);
    cone_normal.push_back(normal);
    mu.push_back(contact.mu(normal));
  }
  friction_begin.push_back(impulses);

  Input input;
  input.covers_all = covers_all;
  input.n = layout.size();
  input.dense = impulses;
  input.cones = layout.cones;
  input.q = q.data();
  input.ngc = contact.ngc();
  input.J = J.data();
  input.Ginv = Ginv.data();
  input.friction_begin = friction_begin.data();
  input.cone_normal = cone_normal.data();
  input.mu = mu.data();
  engine.load(input);
}

}  // namespace

Engine::~Engine() = default;

std::unique_ptr<Engine> make_engine(LemkeEngine engine, IsaLevel level) {
  return std::unique_ptr<Engine>(create(engine, level));
}

void load(const Problem& problem, bool covers_all, Engine& engine) {
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr) return load_matrix(problem.lcp(), covers_all, engine);
  // The factors stand for the usual matrix only.
  if (problem.formation() == MatrixFormation{}) return load_contact(*contact, covers_all, engine);
  load_matrix(make_lcp(problem), covers_all, engine);
}

}  // namespace lcpbench::lemke
