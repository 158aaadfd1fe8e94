#include "native/contact_lemke/contact_farkas.h"

#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "core/timed_solve.h"
#include "native/active_set/active_set.h"
#include "native/contact_lemke/engine.h"
#include "native/contacts/contact_input.h"

namespace lcpbench {
namespace {

/// The contacts along a ray of Lemke's path in 113 bits; none where the path does not end on one.
std::vector<Index> contacts_of_ray(const ContactProblem& contact, double deadline_s) {
  constexpr double kNoShare = 0x1p-80;  // of the largest: rounding
  ContactInput data;
  data.load(contact);
  const std::unique_ptr<contact_lemke::Engine> engine(contact_lemke::quad::create_engine());
  engine->load(data.input);
  contact_lemke::Rules rules;
  rules.max_pivots = 20 * (contact.nc() + contact.ngc()) + 100;
  rules.clock_s = wall_clock_s;
  rules.deadline_s = deadline_s;
  Vector u = Vector::Zero(contact.nc());
  std::vector<Index> contacts;
  if (engine->solve(rules, u.data()).ending != contact_lemke::Ending::kRay) return contacts;
  for (Index c = 0; c < contact.nc(); ++c) {
    if (u(c) > kNoShare * u.maxCoeff()) contacts.push_back(c);
  }
  return contacts;
}

/// X of G = X diag(alpha) X', or G*; nullptr: I.
const Matrix* range_of(const Inertia& inertia) {
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) return &factors->X;
  const auto* inverse = std::get_if<InverseInertia>(&inertia);
  return inverse != nullptr ? &inverse->Ginv : nullptr;
}

}  // namespace

bool ContactFarkas::proves_unsolvable(const Vector& v, double deadline_s) {
  std::vector<Index> hard;
  for (Index c = 0; c < contact_->nc(); ++c) {
    if (!(contact_->normal_compliance(c) > 0)) hard.push_back(c);
  }
  const double left_s = deadline_s - wall_clock_s();
  if (hard.empty() || !(left_s > 0)) return false;
  ContactProblem normals;
  normals.v = v;
  normals.N = Matrix(to_dense(contact_->N)(Eigen::all, hard));
  normals.D = Matrix(v.size(), 0);
  normals.edges.assign(hard.size(), 0);
  normals.mu = Vector::Zero(static_cast<Index>(hard.size()));
  normals.inertia = contact_->inertia;
  if (contact_->has_offset()) normals.b = contact_->b(hard);
  const Problem problem("", std::move(normals));
  ActiveSet solver{ActiveSetSettings{}};
  solver.load(problem);
  Answer answer;
  solver.solve({.time_limit_s = left_s}, answer);
  proof_.setZero(contact_->nc());
  if (answer.claim == Claim::kUnsolvable) {
    proof_(hard) = static_cast<const Vector&>(answer.farkas);
    return true;
  }
  if (answer.claim == Claim::kSolved) return false;
  const std::vector<Index> contacts = contacts_of_ray(*problem.contact(), deadline_s);
  if (contacts.empty()) return false;
  const Matrix* const X = range_of(contact_->inertia);
  const FarkasSupport::ConstMatrixMap range(X != nullptr ? X->data() : nullptr, v.size(), X != nullptr ? X->cols() : 0);
  FarkasSupport support;
  if (!support.proves_unsolvable(*problem.contact(), X != nullptr ? &range : nullptr, v.data(), contacts)) return false;
  Vector u(static_cast<Index>(hard.size()));
  support.write_proof(u);
  proof_(hard) = u;
  return true;
}

}  // namespace lcpbench
