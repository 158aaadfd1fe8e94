#include "native/answer_test/contact_solvability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/compliance.h"
#include "core/timed_solve.h"
#include "native/contacts/contact_edges.h"
#include "native/answer_test/contact_program.h"
#include "native/answer_test/scaled_numbers.h"

namespace lcpbench {
namespace {

/// Of the least value in 113 bits, relative to its terms: what is rounding where no pivot is small, what it may be at
/// most to be told from data, and how much more a share of it is that counts.
constexpr Quad kRounding = 0x1p-100;
constexpr Quad kLargestRounding = 0x1p-75;
constexpr Quad kNoNoise = 0x1p10;

/// Of the search for a velocity at which all edges separate: before the linear program in double, and, for each
/// coordinate more, before that in 113 bits, of which one step takes as long as a hundred of these sweeps.
constexpr Index kFirstSweeps = 400;
constexpr Index kSweepsPerCoordinate = 20;

/// Null where G is given by its entries.
const Matrix* reach_of(const Inertia& inertia) {
  if (const auto* factored = std::get_if<FactoredInertia>(&inertia)) return &factored->X;
  const auto* inverse = std::get_if<InverseInertia>(&inertia);
  return inverse != nullptr ? &inverse->Ginv : nullptr;
}

Index factors_of(const ContactProblem& contact) {
  const Matrix* reach = reach_of(contact.inertia);
  return reach != nullptr ? reach->cols() : contact.ngc();
}

/// J with one row more.
Jacobian with_row(const Jacobian& J, const Eigen::RowVectorXd& last) {
  const Index ngc = rows(J);
  if (const auto* dense = std::get_if<Matrix>(&J)) {
    Matrix longer(ngc + 1, dense->cols());
    longer.topRows(ngc) = *dense;
    longer.row(ngc) = last;
    return longer;
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (Index j = 0; j < cols(J); ++j) {
    const auto add = [&](Index i, double entry) {
      entries.emplace_back(static_cast<int>(i), static_cast<int>(j), entry);
    };
    for_each_entry(J, j, add);
    if (last(j) != 0) add(ngc, last(j));
  }
  SparseMatrix longer(ngc + 1, cols(J));
  longer.setFromTriplets(entries.begin(), entries.end());
  return longer;
}

}  // namespace

bool ContactSolvability::is_asked(const ContactProblem& contact) {
  if (every_contact_yields(contact)) return false;
  return std::holds_alternative<FactoredInertia>(contact.inertia) ||
         std::holds_alternative<InverseInertia>(contact.inertia) || !(contact.b.array() >= 0).all();
}

void ContactSolvability::reserve(const ContactProblem& contact) {
  const Index ngc = contact.ngc() + (contact.has_offset() ? 1 : 0);
  const auto rows = static_cast<std::size_t>(factors_of(contact)) + 1;
  const auto edges = static_cast<std::size_t>(contact.nc() + cols(contact.D));
  edges_.reserve(edges);
  column_exponent_.reserve(edges);
  costs_.reserve(edges);
  cost_terms_.reserve(edges);
  row_exponent_.reserve(rows);
  row_scale_.reserve(rows);
  basis_.reserve(rows);
  unit_.reserve(static_cast<std::size_t>(ngc));
  unreached_v_.reserve(static_cast<std::size_t>(ngc));
  pivot_rows_.reserve(rows);
  range_.reserve(static_cast<std::size_t>(ngc) * (rows - 1));
  if (proof_.size() < contact.nc()) proof_.resize(contact.nc());
  support_.reserve(rows);
  farkas_support_.reserve(ngc, factors_of(contact), contact.nc());
  if (basis_columns_.rows() < static_cast<Index>(rows)) {
    basis_columns_.resize(static_cast<Index>(rows), static_cast<Index>(rows));
    basis_terms_.resize(static_cast<Index>(rows), static_cast<Index>(rows));
    basis_costs_.resize(static_cast<Index>(rows));
    basis_cost_terms_.resize(static_cast<Index>(rows));
  }
  if (lift_.size() < ngc) lift_.resize(ngc);
  if (lift_terms_.size() < ngc) lift_terms_.resize(ngc);
  if (contact.has_offset() && edge_norms_.size() < static_cast<Index>(edges)) {
    edge_norms_.resize(static_cast<Index>(edges));
    edge_shares_.resize(static_cast<Index>(edges));
  }
  if (coordinate_size_.size() < ngc) coordinate_size_.resize(ngc);
  const std::size_t room = (rows + 1) * (rows + edges + 1);
  if (room <= room_) return;
  room_ = room;
  double_ = std::make_unique_for_overwrite<double[]>(room);
  quad_ = std::make_unique_for_overwrite<Quad[]>(room);
}

void ContactSolvability::load(const ContactProblem& contact) {
  reserve(contact);
  contact_ = &contact;
  X_ = reach_of(contact.inertia);
  reaches_all_velocities_ = contact.has_offset() && X_ == nullptr;
  is_reach_formed_ = true;
  if (contact.has_offset()) add_coordinate(contact);
  always_solvable_ = false;
  has_range_ = false;
}

void ContactSolvability::add_coordinate(const ContactProblem& contact) {
  const Index ngc = contact.ngc();
  with_offset_.N = with_row(contact.N, contact.b.transpose());
  with_offset_.D = with_row(contact.D, Eigen::RowVectorXd::Zero(cols(contact.D)));
  with_offset_.edges = contact.edges;
  with_offset_.mu = contact.mu;
  v_with_offset_.resize(ngc + 1);
  is_reach_formed_ = !reaches_all_velocities_;
  X_with_offset_.resize(ngc + 1, factors_of(contact));  // touches no memory
  if (X_ != nullptr) X_with_offset_ << *X_, Eigen::RowVectorXd::Zero(X_->cols());
  contact_ = &with_offset_;
  X_ = &X_with_offset_;
}

/// Powers of two for the columns, so that the largest term of each has about the size of one.
/// find_exponents() for columns in double: what over- or underflows is left to 113 bits.
void ContactSolvability::find_column_exponents() {
  for (const Edge& edge : edges_) {
    double largest = 0;
    double speed = 0;
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
      const double weight = std::fabs(entry * factor);
      largest = std::max(largest, weight * coordinate_size_(i));
      speed = std::max(speed, weight * std::fabs(v_[i]));
    });
    const int exponent = largest > 0 ? -exponent_of(largest) : speed > 0 ? -exponent_of(speed) : 0;
    column_exponent_.push_back(exponent);
    if (speed > 0) cost_exponent_ = std::max(cost_exponent_, exponent_of(speed) + exponent);
  }
  cost_exponent_ = cost_exponent_ == kNoExponent ? 0 : -cost_exponent_;
}

template <class Scalar>
void ContactSolvability::find_exponents() {
  const Index size = reach_size(Scalar());
  row_exponent_.resize(static_cast<std::size_t>(size));
  for (Index k = 0; k < size; ++k) {
    double largest = 0;
    for (Index i = 0; i < X_->rows(); ++i) {
      largest = std::max(largest, std::fabs(static_cast<double>(reach(i, k, Scalar()))));
    }
    row_exponent_[static_cast<std::size_t>(k)] = largest > 0 ? -exponent_of(largest) : 0;
  }
  row_scale_.clear();
  for (const int exponent : row_exponent_) row_scale_.push_back(std::ldexp(1.0, exponent));
  column_exponent_.clear();
  cost_exponent_ = kNoExponent;
  if constexpr (sizeof(Scalar) == sizeof(double)) {
    for (Index i = 0; i < X_->rows(); ++i) {
      double largest_of_row = 0;
      for (Index k = 0; k < size; ++k) {
        largest_of_row = std::max(largest_of_row, std::fabs((*X_)(i, k)) * row_scale_[static_cast<std::size_t>(k)]);
      }
      coordinate_size_(i) = largest_of_row;
    }
    return find_column_exponents();
  }
  for (const Edge& edge : edges_) {
    int largest = kNoExponent;
    int speed = kNoExponent;
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
      const int own = exponent_of(entry) + exponent_of(factor);
      for (Index k = 0; k < size; ++k) {
        const int of_X = exponent_of(static_cast<double>(reach(i, k, Scalar())));
        if (of_X != kNoExponent) largest = std::max(largest, own + of_X + row_exponent_[static_cast<std::size_t>(k)]);
      }
      const int of_v = exponent_of(static_cast<double>(this->speed(i, Scalar())));
      if (of_v != kNoExponent) speed = std::max(speed, own + of_v);
    });
    const int exponent = largest != kNoExponent ? -largest : speed != kNoExponent ? -speed : 0;
    column_exponent_.push_back(exponent);
    if (speed != kNoExponent) cost_exponent_ = std::max(cost_exponent_, speed + exponent);
  }
  cost_exponent_ = cost_exponent_ == kNoExponent ? 0 : -cost_exponent_;
}

template <class Scalar>
void ContactSolvability::fill(Program<Scalar>& program) {
  const Index size = reach_size(Scalar());
  program.rows = size + 1;
  program.edges = static_cast<Index>(edges_.size());
  program.first_phase = true;
  std::fill(program.entries, program.entries + (program.rows + 1) * program.width(), Scalar(0));
  for (Index j = 0; j < program.edges; ++j) {
    const Edge& edge = edges_[static_cast<std::size_t>(j)];
    const int exponent = column_exponent_[static_cast<std::size_t>(j)];
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
      const Scalar weight = scaled(static_cast<Scalar>(entry) * static_cast<Scalar>(factor), exponent);
      for (Index k = 0; k < size; ++k) {
        const Scalar entry_of_X = reach(i, k, Scalar());
        if (entry_of_X == 0) continue;
        program.row(k)[j] += weight * entry_of_X * static_cast<Scalar>(row_scale_[static_cast<std::size_t>(k)]);
      }
    });
    program.row(size)[j] = 1;
  }
  basis_.clear();
  for (Index r = 0; r < program.rows; ++r) {
    program.row(r)[program.edges + r] = 1;
    basis_.push_back(program.edges + r);
  }
  program.row(program.rows - 1)[program.right()] = 1;
  for (Index j = 0; j < program.width(); ++j) {
    if (j >= program.edges && j < program.right()) continue;  // the artificial variables are basic
    for (Index r = 0; r < program.rows; ++r) program.costs()[j] -= program.row(r)[j];
  }
}

/// The reduced costs of v'K u.
template <class Scalar>
void ContactSolvability::write_costs(Program<Scalar>& program) {
  Scalar* const costs = program.costs();
  std::fill(costs, costs + program.width(), Scalar(0));
  program.first_phase = false;
  costs_.clear();
  cost_terms_.clear();
  for (Index j = 0; j < program.edges; ++j) {
    const Edge& edge = edges_[static_cast<std::size_t>(j)];
    const int exponent = column_exponent_[static_cast<std::size_t>(j)] + cost_exponent_;
    Quad terms = 0;
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
      const Scalar term =
          scaled(static_cast<Scalar>(entry) * static_cast<Scalar>(factor), exponent) * speed(i, Scalar());
      costs[j] += term;
      if constexpr (sizeof(Scalar) > sizeof(double)) terms += magnitude(term);
    });
    costs_.push_back(static_cast<Quad>(costs[j]));
    cost_terms_.push_back(terms);
  }
  for (Index r = 0; r < program.rows; ++r) {
    const Index basic = basis_[static_cast<std::size_t>(r)];
    if (basic >= program.edges || costs[basic] == 0) continue;
    const Scalar factor = costs[basic];
    for (Index j = 0; j < program.width(); ++j) costs[j] -= factor * program.row(r)[j];
    costs[basic] = 0;
  }
}

/// What counts as rounding of a reduced cost. In 113 bits it is relative to what that adds up: edges at rest to all but
/// rounding have costs of their own size, and a miss among them counts.
template <class Scalar>
Scalar ContactSolvability::noise_of_cost(const Program<Scalar>& program, Index j) const {
  if (sizeof(Scalar) == sizeof(double) || program.first_phase) return kNoise<Scalar>;
  Quad terms = cost_terms_[static_cast<std::size_t>(j)];
  for (Index r = 0; r < program.rows; ++r) {
    const Index basic = basis_[static_cast<std::size_t>(r)];
    if (basic >= program.edges) continue;
    terms += cost_terms_[static_cast<std::size_t>(basic)] * magnitude(static_cast<Quad>(program.row(r)[j]));
  }
  return kNoise<Scalar> * static_cast<Scalar>(terms);
}

/// All vertices but few are degenerate: the largest pivot is taken while that ends, and then the lowest numbers, which
/// cannot go round. @returns whether it came to an end
template <class Scalar>
bool ContactSolvability::pivot_to_end(Program<Scalar>& program, double deadline_s) {
  const Index usual = 4 * (program.rows + program.edges);
  for (Index pivots = 0; pivots < 8 * usual; ++pivots) {
    if (pivots % 16 == 15 && !(wall_clock_s() < deadline_s)) return false;
    const bool by_number = pivots >= usual;
    const Scalar* const costs = program.costs();
    Index entering = -1;
    for (Index j = 0; j < program.edges; ++j) {
      if (costs[j] >= 0) continue;
      const Scalar noise = noise_of_cost(program, j);
      if (costs[j] >= -noise) continue;
      if (!(costs[j] < -noise)) return false;
      if (entering < 0 || (!by_number && costs[j] < costs[entering])) entering = j;
    }
    if (entering < 0) return true;
    Index leaving = -1;
    Scalar least = 0;
    for (Index r = 0; r < program.rows; ++r) {
      const Scalar pivot = program.row(r)[entering];
      if (!(pivot > kNoise<Scalar>)) continue;
      const Scalar right = std::max(program.row(r)[program.right()], Scalar(0));
      const Scalar ratio = right <= kNoise<Scalar> ? Scalar(0) : right / pivot;
      const bool better = leaving < 0 || ratio < least ||
                          (ratio == least &&
                           (by_number ? basis_[static_cast<std::size_t>(r)] < basis_[static_cast<std::size_t>(leaving)]
                                      : pivot > program.row(leaving)[entering]));
      if (!better) continue;
      leaving = r;
      least = ratio;
    }
    if (leaving < 0) return false;  // but for rounding, sum u = 1 bounds all
    note_pivot(program, leaving, entering);
    program.exchange(leaving, entering);
    basis_[static_cast<std::size_t>(leaving)] = entering;
  }
  return false;
}

/// Keeps the least pivot, relative to its column.
template <class Scalar>
void ContactSolvability::note_pivot(const Program<Scalar>& program, Index row, Index column) {
  Scalar largest = 0;
  for (Index r = 0; r < program.rows; ++r) largest = std::max(largest, magnitude(program.row(r)[column]));
  least_pivot_ = std::min(least_pivot_, static_cast<Quad>(magnitude(program.row(row)[column]) / largest));
}

/// Artificial variables that are zero leave the basis where their row is not zero as well.
template <class Scalar>
void ContactSolvability::drop_artificial(Program<Scalar>& program) {
  for (Index r = 0; r < program.rows; ++r) {
    if (basis_[static_cast<std::size_t>(r)] < program.edges) continue;
    const Scalar* const row = program.row(r);
    Index largest = 0;
    for (Index j = 1; j < program.edges; ++j) {
      if (magnitude(row[j]) > magnitude(row[largest])) largest = j;
    }
    if (!(magnitude(row[largest]) > kClear<Scalar>)) continue;
    program.row(r)[program.right()] = 0;
    note_pivot(program, r, largest);
    program.exchange(r, largest);
    basis_[static_cast<std::size_t>(r)] = largest;
  }
}

/// The magnitudes of what the value of the basis adds up.
template <class Scalar>
Scalar ContactSolvability::terms_of_least(const Program<Scalar>& program) const {
  Scalar terms = 0;
  for (Index r = 0; r < program.rows; ++r) {
    const Index j = basis_[static_cast<std::size_t>(r)];
    const Scalar share = program.row(r)[program.right()];
    if (j >= program.edges || !(share > 0)) continue;
    const Edge& edge = edges_[static_cast<std::size_t>(j)];
    const int exponent = column_exponent_[static_cast<std::size_t>(j)] + cost_exponent_;
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
      const Scalar weight = scaled(static_cast<Scalar>(entry) * static_cast<Scalar>(factor), exponent);
      terms += share * magnitude(weight * speed(i, Scalar()));
    });
  }
  return terms;
}

/// The value of the basis from the costs as given, without the rounding that the reduced costs have gathered: where all
/// edges of the basis are at rest, that would be all there is. Shares up to `noise` are none.
Quad ContactSolvability::value_in_data(const Program<Quad>& program, Quad noise) const {
  Quad value = 0;
  for (Index r = 0; r < program.rows; ++r) {
    const Index j = basis_[static_cast<std::size_t>(r)];
    const Quad share = program.row(r)[program.right()];
    if (j < program.edges && share > noise) value += share * costs_[static_cast<std::size_t>(j)];
  }
  return value;
}

template <class Scalar>
ContactSolvability::Sign ContactSolvability::sign_of_least(Scalar* storage, double deadline_s) {
  constexpr bool kInDouble = sizeof(Scalar) == sizeof(double);
  Program<Scalar> program{storage};
  least_pivot_ = kInDouble ? Quad{1} : least_range_pivot_;
  find_exponents<Scalar>();
  fill(program);
  if (!pivot_to_end(program, deadline_s)) return Sign::kUnknown;
  if (program.value() > kClear<Scalar>) {
    bool lifts = false;
    if constexpr (kInDouble) {
      lifts = lifts_all(program, false);
    } else {
      lifts = lifts_all(program, kRounding / least_range_pivot_);
    }
    return lifts ? Sign::kAlwaysPositive : Sign::kUnknown;
  }
  if (!(program.value() <= kNoise<Scalar> * Scalar(4))) return Sign::kUnknown;
  drop_artificial(program);
  write_costs(program);
  if (!pivot_to_end(program, deadline_s)) return Sign::kUnknown;
  if constexpr (kInDouble) {
    if (program.value() > kClear<double> && lifts_all(program, true)) return Sign::kPositive;
    if (!(program.value() < -kClear<double>)) return Sign::kUnknown;
    if (!of_normals_ || !proves_unsolvable(program)) return Sign::kNegativeInDouble;
    take_proof(program);
    return Sign::kNegative;
  } else {
    const Quad rounding = kRounding / least_pivot_;
    const Quad value = value_in_data(program, kNoNoise * rounding);
    const Quad least = -rounding * terms_of_least(program);
    if (of_normals_ && value < least && proves_unsolvable(program, kNoNoise * rounding)) return Sign::kNegative;
    if (!(rounding <= kLargestRounding && value >= least)) return Sign::kUnknown;
    return holds_to_rounding(program, rounding) ? Sign::kZero : Sign::kUnknown;
  }
}

ContactSolvability::Sign ContactSolvability::sign_in_quad(double deadline_s) {
  if (!(wall_clock_s() < deadline_s)) return Sign::kUnknown;
  find_range();
  if (rank_ == X_->rows()) return Sign::kAlwaysPositive;
  find_unreached_velocity();
  const bool dropped = drop_satisfied_edges();
  if (edges_.empty()) return Sign::kPositive;
  const Sign sign = sign_of_least(quad_.get(), deadline_s);
  return dropped && sign == Sign::kAlwaysPositive ? Sign::kPositive : sign;
}

/// Where the program in double tells nothing: of edges that separate at some velocity no least value is negative.
ContactSolvability::Sign ContactSolvability::sign_beyond_double(double deadline_s) {
  const Index sweeps = kFirstSweeps + kSweepsPerCoordinate * X_->rows();
  return finds_separation(deadline_s, sweeps) ? Sign::kPositive : sign_in_quad(deadline_s);
}

/// Without friction.
ContactSolvability::Sign ContactSolvability::sign_of_normals(double deadline_s) {
  find_normals();
  Sign sign = sign_of_least(double_.get(), deadline_s);
  if (sign == Sign::kNegativeInDouble) {
    keep_basic_edges();
    sign = sign_in_quad(deadline_s);
    if (sign == Sign::kNegative) return sign;  // all else tells nothing of the other normals
    find_normals();
    return sign_in_quad(deadline_s);
  }
  return sign == Sign::kUnknown ? sign_beyond_double(deadline_s) : sign;
}

ContactSolvability::Finding ContactSolvability::decide(const double* v, double deadline_s, Expected expected) {
  if (always_solvable_) return Finding::kSolvable;
  if (deadline_s < std::numeric_limits<double>::infinity() && !(wall_clock_s() < deadline_s)) return Finding::kUnknown;
  v_ = v;
  if (contact_ == &with_offset_) {
    v_with_offset_ << Eigen::Map<const Vector>(v, X_->rows() - 1), 1.0;
    v_ = v_with_offset_.data();
  }
  find_edges();
  if (edges_.empty()) return Finding::kSolvable;
  if (expected == Expected::kSolvable && finds_separation(deadline_s, kFirstSweeps)) return Finding::kSolvable;
  if (!is_reach_formed_) X_with_offset_.setIdentity();
  is_reach_formed_ = true;
  if (!has_friction_) return finding_of_normals(deadline_s);
  const bool cones_first = expected == Expected::kSolvable;
  // Of the cones' least value, zero to rounding is no proof: friction may be so large that normals which miss a
  // solution are rounding beside it.
  const Sign cones = cones_first ? sign_of_cones(deadline_s) : Sign::kUnknown;
  if (is_solvable(cones) && cones != Sign::kZero) return Finding::kSolvable;
  if (sign_of_normals(deadline_s) == Sign::kNegative) return Finding::kUnsolvable;
  if (cones_first) return is_solvable(cones) ? Finding::kSolvable : Finding::kUnknown;
  find_edges();
  return is_solvable(sign_of_cones(deadline_s)) ? Finding::kSolvable : Finding::kUnknown;
}

bool ContactSolvability::is_solvable(Sign sign) {
  return sign == Sign::kAlwaysPositive || sign == Sign::kPositive || sign == Sign::kZero;
}

ContactSolvability::Finding ContactSolvability::finding_of_normals(double deadline_s) {
  const Sign sign = sign_of_normals(deadline_s);
  always_solvable_ = sign == Sign::kAlwaysPositive;
  if (sign == Sign::kNegative) return Finding::kUnsolvable;
  return is_solvable(sign) ? Finding::kSolvable : Finding::kUnknown;
}

/// Of the edges of all cones. @pre has_friction_
ContactSolvability::Sign ContactSolvability::sign_of_cones(double deadline_s) {
  Sign sign = sign_of_least(double_.get(), deadline_s);
  if (sign == Sign::kUnknown) sign = sign_beyond_double(deadline_s);
  always_solvable_ = sign == Sign::kAlwaysPositive;
  return sign;
}

}  // namespace lcpbench
