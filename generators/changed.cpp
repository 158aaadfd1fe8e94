#include "generators/changed.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/selection.h"

namespace lcpbench {
namespace {

constexpr int kLargestExponent = 10;
constexpr double kUnit = 0x1p10;
constexpr double kNearby = 0x1p-30;

Vector powers_of_two(DrawSequence& draws, Index count) {
  Vector factors(count);
  for (double& factor : factors) {
    factor = std::ldexp(1.0, static_cast<int>(draws.integer(-kLargestExponent, kLargestExponent)));
  }
  return factors;
}

std::vector<Index> drawn_order(DrawSequence& draws, Index count) {
  std::vector<Index> order = all_indices(count);
  shuffle(order, draws);
  return order;
}

/// Moves a number a little, up or down as drawn. Zeros and denormal numbers stay, and what would become infinite.
struct Perturbation {
  DrawSequence draws;
  bool to_neighbour;  ///< else by 2^-30

  void operator()(double& x) {
    if (!std::isnormal(x)) return;
    const bool away = draws.integer(0, 1) == 1;  // from zero
    const double moved = to_neighbour ? std::nextafter(x, away ? 2 * x : 0.0) : x * (away ? 1 + kNearby : 1 - kNearby);
    if (std::isfinite(moved)) x = moved;
  }
};

template <class Entries>
void perturb(Entries& entries, Perturbation& perturbation) {
  for (Index i = 0; i < entries.size(); ++i) perturbation(entries(i));
}

void perturb_symmetric(Matrix& A, Perturbation& perturbation) {
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = j; i < A.rows(); ++i) {
      perturbation(A(i, j));
      A(j, i) = A(i, j);
    }
  }
}

void perturb_definite(Matrix& A, Perturbation& perturbation) {
  Matrix neighbour = A;
  perturb_symmetric(neighbour, perturbation);
  if (A.size() > 0 && Eigen::LLT<Matrix>(neighbour).info() == Eigen::Success) A = neighbour;
}

void perturb_inertia(Inertia& inertia, Perturbation& perturbation) {
  if (auto* dense = std::get_if<DenseInertia>(&inertia)) {
    perturb_definite(dense->G, perturbation);
  } else if (auto* blocks = std::get_if<BlockInertia>(&inertia)) {
    for (Matrix& block : blocks->blocks) perturb_definite(block, perturbation);
  } else if (auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    perturb(factors->X, perturbation);
    perturb(factors->alpha, perturbation);
  } else {
    perturb_definite(std::get<InverseInertia>(inertia).Ginv, perturbation);
  }
}

void perturb_columns(Jacobian& J, Index begin, Index count, Perturbation& perturbation) {
  for (Index j = begin; j < begin + count; ++j) {
    if (auto* dense = std::get_if<Matrix>(&J)) {
      for (double& entry : dense->col(j)) perturbation(entry);
    } else {
      for (SparseMatrix::InnerIterator entry(std::get<SparseMatrix>(J), j); entry; ++entry) {
        perturbation(entry.valueRef());
      }
    }
  }
}

/// Of the contacts from `first` on. Opposite friction columns stay opposite.
void perturb_contacts(ContactProblem& contact, Index first, Perturbation& perturbation) {
  const ContactLayout layout = contact_layout(contact);
  for (Index index = first; index < contact.nc(); ++index) {
    const Index begin = layout.friction_begin[static_cast<std::size_t>(index)];
    const Index half = contact.edges[static_cast<std::size_t>(index)] / 2;
    perturb_columns(contact.N, index, 1, perturbation);
    Perturbation again = perturbation;
    perturb_columns(contact.D, begin, half, perturbation);
    perturb_columns(contact.D, begin + half, half, again);
  }
}

/// Whether a bounded row bounds the friction of others.
bool is_load(const BoundedRows& rows, Index row) {
  return std::ranges::any_of(rows.bounds.friction_of, [&](int of) { return of == row; });
}

/// R_i by factors: the impulses become as much smaller.
void scale_rows(BoundedRows& rows, const Vector& factors) {
  std::visit([&](auto& A) { A = std::remove_cvref_t<decltype(A)>(A * factors.asDiagonal()); }, rows.R);
  if (rows.b.size() > 0) rows.b.array() *= factors.array();
  if (rows.compliance.size() > 0) rows.compliance.array() *= factors.array().square();
  rows.bounds.lower.array() /= factors.array();
  rows.bounds.upper.array() /= factors.array();
  for (Index i = 0; i < rows.size(); ++i) {
    const int of = rows.bounds.friction_of[static_cast<std::size_t>(i)];
    if (of >= 0) rows.bounds.mu(i) *= factors(of) / factors(i);
  }
}

/// The same row by its other direction.
void negate(BoundedRows& rows, Index row) {
  if (auto* dense = std::get_if<Matrix>(&rows.R)) {
    for (double& entry : dense->col(row)) entry = 0 - entry;  // no negative zeros
  } else {
    for (SparseMatrix::InnerIterator entry(std::get<SparseMatrix>(rows.R), row); entry; ++entry) {
      entry.valueRef() = 0 - entry.value();
    }
  }
  if (rows.b.size() > 0) rows.b(row) = 0 - rows.b(row);
  const double lower = rows.bounds.lower(row);
  rows.bounds.lower(row) = 0 - rows.bounds.upper(row);
  rows.bounds.upper(row) = 0 - lower;
}

/// A row that bears no friction twice, each with half of its impulse; nothing where there is none.
void duplicate_row(ContactProblem& contact, DrawSequence& draws) {
  std::vector<Index> alone;
  for (Index row = 0; row < contact.rows.size(); ++row) {
    if (!is_load(contact.rows, row)) alone.push_back(row);
  }
  if (alone.empty()) return;
  const Index first = alone[static_cast<std::size_t>(draws.integer(0, std::ssize(alone) - 1))];
  std::vector<Index> twice = all_indices(contact.rows.size());
  twice.push_back(first);
  contact = select_rows(contact, twice);
  for (const Index row : {first, contact.rows.size() - 1}) {
    for (Vector* bound : {&contact.rows.bounds.lower, &contact.rows.bounds.upper, &contact.rows.bounds.mu}) {
      (*bound)(row) /= 2;
    }
    if (contact.rows.compliance.size() > 0) contact.rows.compliance(row) *= 2;
  }
}

void scale_contacts(ContactProblem& contact, const Vector& factors) {
  std::vector<double> of_columns;
  for (std::size_t i = 0; i < contact.edges.size(); ++i) {
    of_columns.insert(of_columns.end(), static_cast<std::size_t>(contact.edges[i]), factors(static_cast<Index>(i)));
  }
  const auto scale = [](Jacobian& J, const auto& by) {
    std::visit([&](auto& A) { A = std::remove_cvref_t<decltype(A)>(A * by.asDiagonal()); }, J);
  };
  scale(contact.N, factors);
  scale(contact.D, Eigen::Map<const Vector>(of_columns.data(), static_cast<Index>(of_columns.size())));
  if (contact.has_offset()) contact.b = Vector(contact.b.cwiseProduct(factors));
  for (Vector* r : {&contact.compliance_n, &contact.compliance_t}) {
    if (r->size() > 0) r->array() *= factors.array().square();
  }
  for (Index i = 0; i < contact.offset_t.size(); ++i) contact.offset_t(i) *= factors(i / 2);
}

void scale_inertia(Inertia& inertia, double factor) {
  if (auto* dense = std::get_if<DenseInertia>(&inertia)) {
    dense->G *= factor;
  } else if (auto* blocks = std::get_if<BlockInertia>(&inertia)) {
    for (Matrix& block : blocks->blocks) block *= factor;
  } else if (auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    factors->alpha *= factor;
  } else {
    std::get<InverseInertia>(inertia).Ginv /= factor;
  }
}

void change_contacts(ContactProblem& contact, Change change, DrawSequence draws) {
  Perturbation perturbation{draws, change == Change::kLastDigits};
  switch (change) {
    case Change::kScaling:
      scale_contacts(contact, powers_of_two(draws, contact.nc()));
      if (contact.has_rows()) scale_rows(contact.rows, powers_of_two(draws, contact.rows.size()));
      return;
    case Change::kUnits:
      scale_inertia(contact.inertia, kUnit);
      contact.v *= kUnit;
      contact.b *= kUnit;
      contact.offset_t *= kUnit;
      contact.compliance_n /= kUnit;
      contact.compliance_t /= kUnit;
      contact.rows.b *= kUnit;
      contact.rows.compliance /= kUnit;
      contact.rows.bounds.lower *= kUnit * kUnit;
      contact.rows.bounds.upper *= kUnit * kUnit;
      return;
    case Change::kOrder: {
      const std::vector<Index> order = drawn_order(draws, contact.nc());
      std::vector<Index> directions;
      for (const int edges : contact.edges) {
        const auto shift = edges > 0 ? static_cast<int>(draws.integer(0, edges - 1)) : 0;
        const Index begin = std::ssize(directions);
        for (int t = 0; t < edges; ++t) directions.push_back(begin + (t + shift) % edges);
      }
      // Compliance and offsets of friction go by the tangents, which are the first directions.
      if (contact.compliance_t.size() + contact.offset_t.size() == 0) {
        contact.D = part_of(contact.D, all_indices(contact.ngc()), directions);
      }
      contact = select_contacts(contact, order);
      if (!contact.has_rows()) return;
      contact = select_rows(contact, drawn_order(draws, contact.rows.size()));
      for (Index row = 0; row < contact.rows.size(); ++row) {
        if (draws.integer(0, 1) == 1 && !is_load(contact.rows, row)) negate(contact.rows, row);
      }
      return;
    }
    case Change::kDuplicate:
    case Change::kNearDuplicate: {
      const bool is_near = change == Change::kNearDuplicate;
      if (contact.nc() > 0) {
        std::vector<Index> twice = all_indices(contact.nc());
        const Index first = draws.integer(0, contact.nc() - 1);
        twice.push_back(first);
        contact = select_contacts(contact, twice);
        for (Vector* r : {&contact.compliance_n, &contact.compliance_t}) {  // side by side both yield as one did
          if (r->size() > 0) (*r)(first) = r->tail<1>()(0) *= 2;
        }
        if (is_near) perturb_contacts(contact, contact.nc() - 1, perturbation);
      }
      const Index rows = contact.rows.size();
      duplicate_row(contact, draws);
      if (is_near && contact.rows.size() > rows) perturb_columns(contact.rows.R, rows, 1, perturbation);
      return;
    }
    case Change::kLastDigits:
      perturb(contact.v, perturbation);
      perturb_contacts(contact, 0, perturbation);
      perturb(contact.mu, perturbation);
      for (Vector* values : {&contact.b, &contact.compliance_n, &contact.compliance_t, &contact.offset_t}) {
        perturb(*values, perturbation);
      }
      if (contact.has_rows()) {
        BoundedRows& rows = contact.rows;
        perturb_columns(rows.R, 0, rows.size(), perturbation);
        for (Vector* values : {&rows.b, &rows.compliance, &rows.bounds.lower, &rows.bounds.upper, &rows.bounds.mu}) {
          perturb(*values, perturbation);
        }
      }
      perturb_inertia(contact.inertia, perturbation);
      return;
    case Change::kHard: contact.compliance_n = contact.compliance_t = contact.offset_t = Vector();
  }
}

void change_scene(RigidScene& scene, Change change, DrawSequence draws) {
  Perturbation perturbation{draws, change == Change::kLastDigits};
  std::vector<RigidContact>& contacts = scene.contacts;
  switch (change) {
    case Change::kScaling: return;  // a scene has no columns
    case Change::kUnits:
      for (RigidBody& body : scene.bodies) {
        body.mass *= kUnit;
        body.inertia *= kUnit * kUnit * kUnit;
        body.position *= kUnit;
        body.linear_velocity *= kUnit;
      }
      for (RigidContact& contact : contacts) {
        contact.point *= kUnit;
        contact.b *= kUnit;
        contact.offset_t *= kUnit;
        contact.compliance_n /= kUnit;
        contact.compliance_t /= kUnit;
      }
      return;
    case Change::kOrder: return shuffle(contacts, draws);
    case Change::kDuplicate:
    case Change::kNearDuplicate: {
      RigidContact& first = contacts[static_cast<std::size_t>(draws.integer(0, std::ssize(contacts) - 1))];
      first.compliance_n *= 2;
      first.compliance_t *= 2;
      contacts.push_back(RigidContact(first));
      if (change == Change::kNearDuplicate) perturb(contacts.back().point, perturbation);
      return;
    }
    case Change::kLastDigits:
      for (RigidBody& body : scene.bodies) {
        perturbation(body.mass);
        Matrix inertia = body.inertia;
        perturb_definite(inertia, perturbation);
        body.inertia = inertia;
        perturb(body.position, perturbation);
        perturb(body.linear_velocity, perturbation);
        perturb(body.angular_velocity, perturbation);
      }
      for (RigidContact& contact : contacts) {
        perturb(contact.point, perturbation);
        perturbation(contact.mu);
        perturbation(contact.b);
        perturbation(contact.compliance_n);
        perturbation(contact.compliance_t);
        perturb(contact.offset_t, perturbation);
      }
      return;
    case Change::kHard:
      for (RigidContact& contact : contacts) {
        contact.compliance_n = contact.compliance_t = 0;
        contact.offset_t.setZero();
      }
  }
}

void change_bare(Lcp& lcp, Change change, DrawSequence draws) {
  if (change == Change::kScaling) {
    const Vector columns = powers_of_two(draws, lcp.size());
    const Vector rows = powers_of_two(draws, lcp.size());
    lcp.M = Matrix(rows.asDiagonal() * lcp.M * columns.asDiagonal());
    lcp.q = Vector(rows.cwiseProduct(lcp.q));
  } else if (change == Change::kUnits) {
    for (Vector* values : {&lcp.q, &lcp.bounds.lower, &lcp.bounds.upper}) *values *= kUnit;
  } else if (change == Change::kOrder) {
    const std::vector<Index> order = drawn_order(draws, lcp.size());
    lcp.M = Matrix(lcp.M(order, order));
    lcp.q = Vector(lcp.q(order));
    lcp.bounds = lcp.bounds.of_rows(order);
  } else if (change == Change::kLastDigits) {
    Perturbation perturbation{draws, true};
    if (lcp.M == lcp.M.transpose()) {
      perturb_symmetric(lcp.M, perturbation);
    } else {
      perturb(lcp.M, perturbation);
    }
    perturb(lcp.q, perturbation);
  }
}

}  // namespace

const Choices<Change>& all_changes() {
  static const Choices<Change> choices{{{"scaling", Change::kScaling},
                                        {"units", Change::kUnits},
                                        {"order", Change::kOrder},
                                        {"duplicate", Change::kDuplicate},
                                        {"near_duplicate", Change::kNearDuplicate},
                                        {"last_digits", Change::kLastDigits},
                                        {"hard", Change::kHard}}};
  return choices;
}

const char* to_string(Change change) { return all_changes().values[static_cast<std::size_t>(change)].first; }

double data_change(Change change) {
  if (change == Change::kNearDuplicate) return kNearby;
  return change == Change::kLastDigits ? 0x1p-52 : 0;
}

bool applies(Change change, const Problem& problem) {
  if (change == Change::kDuplicate || change == Change::kNearDuplicate) {
    const ContactProblem* const contact = problem.contact();
    if (contact == nullptr) return false;
    for (Index row = 0; row < contact->rows.size(); ++row) {
      if (!is_load(contact->rows, row)) return true;
    }
    return contact->nc() > 0;
  }
  if (change == Change::kHard) return problem.contact() != nullptr && problem.contact()->is_soft();
  if (change != Change::kScaling || problem.contact() != nullptr) return true;
  if (problem.lcp().is_mixed()) return false;  // friction has the unit of what limits it
  const auto stays_normal = [](double x) { return x == 0 || (std::abs(x) > 0x1p-1000 && std::abs(x) < 0x1p1000); };
  return problem.lcp().M.unaryExpr(stays_normal).all();
}

DrawnChange::DrawnChange(Change change, const std::string& set, std::uint64_t seed, std::int64_t trial,
                         std::int64_t draw)
    : change_(change),
      draws_({stream_id(std::string("changed/") + to_string(change) + "/" + set), seed,
              static_cast<std::uint64_t>(trial)},
             Purpose::kChange, static_cast<std::uint64_t>(draw)) {}

Problem DrawnChange::apply(const Problem& problem, const std::string& name) const {
  if (problem.scene() != nullptr && change_ != Change::kScaling) {
    RigidScene scene = *problem.scene();
    if (applies(change_, problem)) change_scene(scene, change_, draws_);
    return {name, std::move(scene)};
  }
  if (problem.contact() != nullptr) {
    ContactProblem contact = *problem.contact();
    if (applies(change_, problem)) change_contacts(contact, change_, draws_);
    return {name, std::move(contact), problem.formation()};
  }
  Lcp lcp = problem.lcp();
  if (applies(change_, problem)) change_bare(lcp, change_, draws_);
  return {name, std::move(lcp)};
}

Vector DrawnChange::take_back(const Problem& original, Vector answer) const {
  const bool bare = original.contact() == nullptr;
  DrawSequence draws = draws_;
  if (change_ == Change::kUnits) {
    for (Index i = 0; i < answer.size(); ++i) {
      const bool is_turn = original.scene() != nullptr && i % 6 >= 3;
      if (!is_turn) answer(i) /= kUnit;
    }
  } else if (bare && change_ == Change::kScaling) {
    answer = Vector(answer.cwiseProduct(powers_of_two(draws, answer.size())));
  } else if (bare && change_ == Change::kOrder) {
    const Vector permuted = answer;
    const std::vector<Index> order = drawn_order(draws, answer.size());
    for (Index i = 0; i < answer.size(); ++i) answer(order[static_cast<std::size_t>(i)]) = permuted(i);
  }
  return answer;
}

}  // namespace lcpbench
