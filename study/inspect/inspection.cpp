#include "study/inspect/inspection.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "study/inspect/contact_facts.h"
#include "study/inspect/matrix_facts.h"

namespace lcpbench {
namespace {

std::vector<Index> all_rows(Index n) {
  std::vector<Index> rows(static_cast<std::size_t>(n));
  std::iota(rows.begin(), rows.end(), Index{0});
  return rows;
}

Vector approach_velocities(const ContactProblem& problem) {
  Vector velocities = std::visit([&](const auto& N) { return Vector(N.transpose() * problem.v); }, problem.N);
  if (problem.has_offset()) velocities += problem.b;
  return velocities;
}

/// What theory says of a contact problem's M, rather than what its rounding says. [Anitescu, Potra 1997]
void use_theory(const ContactFacts& contact, MatrixFacts& matrix) {
  if (contact.inertia_rank < 0) return;
  matrix.copositive = Tri::kYes;
  matrix.not_copositive_at.reset();
}

void inspect_contact(const ContactProblem& contact, const Problem& problem, Inspection& inspection) {
  inspection.ngc = contact.ngc();
  inspection.nc = contact.nc();
  inspection.edges = contact.edges;
  inspection.friction_columns = cols(contact.D);
  inspection.contact = contact_facts(contact, problem.scene());
  Matrix M;
  if (inspection.contact->inertia_rank >= 0) {
    const Lcp& lcp = problem.lcp();
    inspection.matrix = matrix_facts(lcp, independent_rows(contact));
    use_theory(*inspection.contact, inspection.matrix);
    M = lcp.M.topRows(contact.nc());
  }
  inspection.velocity = velocity_facts(approach_velocities(contact), contact.nc(), M);
}

}  // namespace

void Range::add(double magnitude) {
  if (!(magnitude > 0)) return;
  low = std::isnan(low) ? magnitude : std::min(low, magnitude);
  high = std::isnan(high) ? magnitude : std::max(high, magnitude);
}

const char* to_string(Concern concern) { return concern == Concern::kData ? "data" : "difficulty"; }

Inspection inspect(const Problem& problem) {
  Inspection inspection;
  inspection.name = problem.name();
  inspection.kind = problem.kind();
  inspection.n = problem.size();
  if (const ContactProblem* contact = problem.contact()) {
    inspect_contact(*contact, problem, inspection);
  } else {
    const Lcp& lcp = problem.lcp();
    if (lcp.size() <= kLargestDense) inspection.matrix = matrix_facts(lcp, all_rows(lcp.size()));
    inspection.velocity = velocity_facts(lcp.q, lcp.size(), inspection.matrix.dense ? lcp.M : Matrix());
  }
  inspection.warnings = warnings_of(inspection);
  return inspection;
}

}  // namespace lcpbench
