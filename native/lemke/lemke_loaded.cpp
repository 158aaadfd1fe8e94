#include "native/lemke/lemke_loaded.h"

#include <Eigen/Core>
#include <cstddef>
#include <stdexcept>
#include <variant>
#include <vector>

#include "core/solver.h"
#include "native/contacts/contact_input.h"

namespace lcpbench::lemke {

namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

const Engine& engine_at(LemkeEngine engine, IsaLevel level, LemkeArithmetic arithmetic) {
  const bool dense = engine == LemkeEngine::kDense;
  if (level > best_isa_level()) throw std::invalid_argument("this processor lacks the instruction-set level asked for");
  if (arithmetic != LemkeArithmetic::kDouble) {
    if (engine != LemkeEngine::kKernel) throw std::invalid_argument("this engine knows double only");
    return quad::kKernelEngine;
  }
  if (engine == LemkeEngine::kOrdered) return ordered::kOrderedEngine;
#if defined(__x86_64__)
  if (level == IsaLevel::kAvx512) return dense ? avx512::kDenseEngine : avx512::kKernelEngine;
  if (level == IsaLevel::kAvx2) return dense ? avx2::kDenseEngine : avx2::kKernelEngine;
#endif
  return dense ? baseline::kDenseEngine : baseline::kKernelEngine;
}

}  // namespace

LoadedEngine::LoadedEngine(LemkeEngine engine, IsaLevel level, LemkeArithmetic arithmetic)
    : engine_(engine_at(engine, level, arithmetic)),
      from_data_(arithmetic == LemkeArithmetic::kQuad),
      state_(engine_.create()) {}

LoadedEngine::~LoadedEngine() { engine_.destroy(state_); }

void LoadedEngine::load(const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  // The factors stand for the usual matrix only.
  if (contact != nullptr && (from_data_ || problem.formation() == MatrixFormation{})) return load_contact(*contact);
  if (contact == nullptr) return load_matrix(problem.lcp());
  load_matrix(make_lcp(problem));
}

void LoadedEngine::load_matrix(const Lcp& lcp) {
  Input input;
  input.n = input.dense = lcp.size();
  input.q = lcp.q.data();
  input.M = lcp.M.data();
  engine_.load(state_, input);
}

void LoadedEngine::load_contact(const ContactProblem& contact) {
  const ContactLayout layout = contact_layout(contact);
  const Index impulses = layout.nc + layout.friction;
  RowMajorMatrix J(contact.ngc(), impulses);
  std::visit([&](const auto& N) { J.leftCols(layout.nc) = N; }, contact.N);
  std::visit([&](const auto& D) { J.rightCols(layout.friction) = D; }, contact.D);
  Vector q = Vector::Zero(layout.size());
  q.head(impulses).noalias() = J.transpose() * contact.v;
  if (contact.has_offset()) q.head(layout.nc) += contact.b;
  const Matrix Ginv = from_data_ ? Matrix() : inverse_inertia(contact.inertia);
  ContactInput contacts;
  if (from_data_) contacts.load(contact);

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
  input.n = layout.size();
  input.dense = impulses;
  input.cones = layout.cones;
  input.q = q.data();
  input.ngc = contact.ngc();
  input.J = J.data();
  input.Ginv = Ginv.data();
  input.contacts = from_data_ ? &contacts.input : nullptr;
  input.friction_begin = friction_begin.data();
  input.cone_normal = cone_normal.data();
  input.mu = mu.data();
  engine_.load(state_, input);
}

}  // namespace lcpbench::lemke
