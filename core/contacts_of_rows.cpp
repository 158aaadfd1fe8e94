#include "core/contacts_of_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/added_coordinates.h"
#include "core/answer/contact_lcp.h"
#include "core/islands.h"

namespace lcpbench {
namespace {

constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// The power of two below a positive number; 1 of others.
double power_below(double x) { return x > 0 && std::isfinite(x) ? std::ldexp(1.0, std::ilogb(x)) : 1.0; }

/// The power of two next to a positive number: within a factor sqrt(2).
double power_next_to(double x) { return power_below(x * std::numbers::sqrt2); }

/// G* times sparse columns, in double, block by block. Inverses of blocks are made when they are first needed.
class Responses {
 public:
  explicit Responses(const Inertia& inertia) : inertia_(inertia) {
    if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
      for (std::size_t k = 0; k < bodies->blocks.size(); ++k) {
        begins_.push_back(block_of_.size());
        block_of_.resize(block_of_.size() + static_cast<std::size_t>(bodies->blocks[k].rows()), k);
      }
    } else {
      begins_.push_back(0);
      block_of_.resize(static_cast<std::size_t>(dimension(inertia)), 0);
    }
    inverses_.resize(begins_.size());
    begins_.push_back(block_of_.size());
  }

  /// to += factor G* J_i
  void add(const Jacobian& J, Index column, double factor, Vector& to) {
    for_each_entry(J, column, [&](Index i, double entry) {
      const std::size_t block = block_of_[static_cast<std::size_t>(i)];
      const Matrix& inverse = inverse_of(block);
      const auto begin = static_cast<Index>(begins_[block]);
      to.segment(begin, inverse.rows()) += (factor * entry) * inverse.col(i - begin);
    });
  }

  /// Zeros where add() wrote a column with an entry for this coordinate.
  void clear(Index coordinate, Vector& to) const {
    const std::size_t block = block_of(coordinate);
    to.segment(static_cast<Index>(begins_[block]), static_cast<Index>(begins_[block + 1] - begins_[block])).setZero();
  }
  /// J_i'G*J_i
  double energy(const Jacobian& J, Index column) {
    double sum = 0;
    for_each_entry(J, column, [&](Index i, double left) {
      const std::size_t block = block_of_[static_cast<std::size_t>(i)];
      const Matrix& inverse = inverse_of(block);
      const auto begin = static_cast<Index>(begins_[block]);
      for_each_entry(J, column, [&](Index j, double right) {
        if (block_of_[static_cast<std::size_t>(j)] == block) sum += left * inverse(i - begin, j - begin) * right;
      });
    });
    return std::max(sum, 0.0);
  }
  std::size_t block_of(Index coordinate) const { return block_of_[static_cast<std::size_t>(coordinate)]; }
  std::size_t blocks() const { return inverses_.size(); }

 private:
  const Matrix& inverse_of(std::size_t block) {
    Matrix& inverse = inverses_[block];
    if (inverse.rows() > 0) return inverse;
    const auto* bodies = std::get_if<BlockInertia>(&inertia_);
    inverse = inverse_inertia(bodies == nullptr ? inertia_ : DenseInertia{bodies->blocks[block]});
    return inverse;
  }

  const Inertia& inertia_;
  std::vector<std::size_t> block_of_, begins_;
  std::vector<Matrix> inverses_;
};

double median(std::vector<double>& numbers) {
  const auto half = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), half, numbers.end());
  if (numbers.size() % 2 == 1) return *half;
  return (*half + *std::max_element(numbers.begin(), half)) / 2;
}

}  // namespace

/// What the units of rows are chosen by, in double: see ContactLcp::lever() and ContactScale.
class ContactsOfRows::RowSizes {
 public:
  explicit RowSizes(const ContactProblem& problem) : problem_(problem), responses_(problem.inertia) {
    islands_.find(problem);
    const BoundedRows& rows = problem.rows;
    own_.resize(static_cast<std::size_t>(rows.size()));
    for (Index i = 0; i < rows.size(); ++i) own_[static_cast<std::size_t>(i)] = responses_.energy(rows.R, i);
    find_levers();
    find_scales();
  }

  /// M_ii without compliance.
  double diagonal(Index row) const { return own_[static_cast<std::size_t>(row)]; }
  double lever(Index row) const { return levers_[static_cast<std::size_t>(row)]; }
  /// Of the row's island [m/s].
  double scale(Index row) const {
    const Index island = islands_.of_row[static_cast<std::size_t>(row)];
    return island < 0 ? ContactScale<double>::kLeast : scales_[static_cast<std::size_t>(island)].value();
  }
  double scale_of_contact(Index contact) const {
    const Index island = islands_.of_contact[static_cast<std::size_t>(contact)];
    return island < 0 ? kNoBound : scales_[static_cast<std::size_t>(island)].value();
  }
  Responses& responses() { return responses_; }

 private:
  void find_levers() {
    const BoundedRows& rows = problem_.rows;
    levers_.assign(static_cast<std::size_t>(rows.size()), 1);
    if (std::none_of(rows.is_angle.begin(), rows.is_angle.end(), [](char angle) { return angle != 0; })) return;
    std::vector<std::vector<double>> of_contacts(static_cast<std::size_t>(islands_.count)), of_rows = of_contacts;
    std::vector<double> contacts(static_cast<std::size_t>(problem_.nc()));
    std::vector<std::vector<Index>> contacts_of_block(responses_.blocks());
    for (Index c = 0; c < problem_.nc(); ++c) {
      const double own = contacts[static_cast<std::size_t>(c)] = responses_.energy(problem_.N, c);
      const Index island = islands_.of_contact[static_cast<std::size_t>(c)];
      if (own > 0 && island >= 0) of_contacts[static_cast<std::size_t>(island)].push_back(own);
      for_each_entry(problem_.N, c, [&](Index i, double) {
        std::vector<Index>& list = contacts_of_block[responses_.block_of(i)];
        if (list.empty() || list.back() != c) list.push_back(c);
      });
    }
    for (Index i = 0; i < rows.size(); ++i) {
      const Index island = islands_.of_row[static_cast<std::size_t>(i)];
      if (rows.is_angle[static_cast<std::size_t>(i)] == 0 && diagonal(i) > 0 && island >= 0) {
        of_rows[static_cast<std::size_t>(island)].push_back(diagonal(i));
      }
    }
    Vector response = Vector::Zero(problem_.ngc());
    for (Index i = 0; i < rows.size(); ++i) {
      if (rows.is_angle[static_cast<std::size_t>(i)] == 0 || !(diagonal(i) > 0)) continue;
      responses_.add(rows.R, i, 1, response);
      std::vector<Index> near;
      for_each_entry(rows.R, i, [&](Index j, double) {
        const std::vector<Index>& list = contacts_of_block[responses_.block_of(j)];
        near.insert(near.end(), list.begin(), list.end());
      });
      std::sort(near.begin(), near.end());
      near.erase(std::unique(near.begin(), near.end()), near.end());
      std::vector<double> moved;
      for (const Index c : near) {
        const double own = contacts[static_cast<std::size_t>(c)];
        const double coupling = std::abs(dot_column(problem_.N, c, response));
        if (coupling > ContactLcp::kLeastCoupling * std::sqrt(own * diagonal(i))) moved.push_back(own);
      }
      const auto island = static_cast<std::size_t>(islands_.of_row[static_cast<std::size_t>(i)]);
      std::vector<double>& others = !moved.empty() ? moved : !of_contacts[island].empty() ? of_contacts[island] : of_rows[island];
      if (!others.empty()) levers_[static_cast<std::size_t>(i)] = std::sqrt(median(others) / diagonal(i));
      for_each_entry(rows.R, i, [&](Index j, double) {  // zero again where it was written
        responses_.clear(j, response);
      });
    }
  }

  void find_scales() {
    const BoundedRows& rows = problem_.rows;
    scales_.assign(static_cast<std::size_t>(islands_.count), {});
    for (Index c = 0; c < problem_.nc(); ++c) {
      const Index island = islands_.of_contact[static_cast<std::size_t>(c)];
      if (island < 0) continue;
      const double speed = dot_column(problem_.N, c, problem_.v);
      scales_[static_cast<std::size_t>(island)].add_row(speed, 0, 0);
      scales_[static_cast<std::size_t>(island)].add_approach(speed + problem_.offset(c));
    }
    for (Index i = 0; i < rows.size(); ++i) {
      const Index island = islands_.of_row[static_cast<std::size_t>(i)];
      if (island < 0) continue;
      const double speed = dot_column(rows.R, i, problem_.v), w = speed + rows.offset(i);
      const double bound = w > 0 ? -rows.bounds.lower(i) : rows.bounds.upper(i);
      const bool grows = rows.bounds.friction_of[static_cast<std::size_t>(i)] >= 0;
      const double most = grows ? 0 : bound < kNoBound ? (diagonal(i) + rows.yields(i)) * bound : kNoBound;
      scales_[static_cast<std::size_t>(island)].add_row(lever(i) * speed, 0, 0);
      scales_[static_cast<std::size_t>(island)].add_approach(-lever(i) * std::min(std::abs(w), most));
    }
  }

  const ContactProblem& problem_;
  Responses responses_;
  IslandNumbers islands_;
  std::vector<double> own_, levers_;
  std::vector<ContactScale<double>> scales_;
};

bool ContactsOfRows::can_express(const BoundedRows& rows) {
  std::vector<char> is_load(static_cast<std::size_t>(rows.size()), 0);
  for (const int of : rows.bounds.friction_of) {
    if (of < 0) continue;
    if (is_load[static_cast<std::size_t>(of)]++ != 0 || rows.bounds.upper(of) < kNoBound) return false;
  }
  return true;
}

ContactsOfRows::ContactsOfRows(const ContactProblem& problem) : bounds_(problem.rows.bounds), from_(contact_layout(problem)) {
  const BoundedRows& rows = problem.rows;
  const Index count = rows.size(), nc = problem.nc();
  RowSizes sizes(problem);
  AddedCoordinates added(problem);
  AddedCoordinates::Entries normal, friction;
  contacts_.edges = problem.edges;
  std::vector<double> mu(problem.mu.begin(), problem.mu.end()), b, yields_n, yields_t, offset_t;
  for (Index c = 0; c < nc; ++c) {
    b.push_back(problem.offset(c));
    yields_n.push_back(problem.normal_compliance(c));
    yields_t.push_back(problem.tangential_compliance(c));
    for (const int tangent : {0, 1}) offset_t.push_back(problem.tangential_offset(c, tangent));
  }
  const auto add_contact = [&](double offset, double yields) {
    contacts_.edges.push_back(0);
    mu.push_back(0);
    b.push_back(offset);
    yields_n.push_back(yields);
    yields_t.push_back(0);
    offset_t.insert(offset_t.end(), 2, 0.0);
    return static_cast<Index>(contacts_.edges.size()) - 1;
  };
  const auto add_column = [&](Index row, double factor, Index column, AddedCoordinates::Entries& to) {
    for_each_entry(rows.R, row, [&](Index i, double entry) { to.emplace_back(i, column, factor * entry); });
  };
  Index columns = cols(problem.D);
  const auto add_friction = [&](Index row, double unit, double offset, double coefficient, Index contact) {
    const auto c = static_cast<std::size_t>(contact);
    contacts_.edges[c] = 2;
    mu[c] = coefficient;
    yields_t[c] = unit * unit * rows.yields(row);
    offset_t[2 * c] = unit * offset;
  };
  contacts_.v = problem.v;
  rows_.resize(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) {
    Row& row = rows_[static_cast<std::size_t>(i)];
    row.unit = power_next_to(sizes.lever(i));
    row.diagonal = sizes.diagonal(i) + rows.yields(i);
    row.weight = sizes.lever(i) / sizes.scale(i);
    const double lower = bounds_.lower(i), upper = bounds_.upper(i), unit = row.unit;
    const double yields = unit * unit * rows.yields(i);
    if (bounds_.friction_of[static_cast<std::size_t>(i)] >= 0) {
      row.kind = Row::Kind::kFrictionOf;  // below, where its load has a contact
      continue;
    }
    if (lower == -kNoBound && upper == kNoBound) {
      row.kind = Row::Kind::kEquality;
      row.contact = add_contact(unit * rows.offset(i), yields);
      add_contact(-unit * rows.offset(i), yields);
      add_column(i, unit, row.contact, normal);
      add_column(i, -unit, row.contact + 1, normal);
      continue;
    }
    const bool is_box = lower > -kNoBound && upper < kNoBound;
    row.middle = is_box ? (lower + upper) / 2 : lower > -kNoBound ? lower : upper;
    const double offset = rows.offset(i) + rows.yields(i) * row.middle;
    if (row.middle != 0) sizes.responses().add(rows.R, i, row.middle, contacts_.v);
    if (!is_box) {
      row.kind = Row::Kind::kLimit;
      if (upper < kNoBound) row.unit = -unit;  // it presses the other way
      row.contact = add_contact(row.unit * offset, yields);
      add_column(i, row.unit, row.contact, normal);
      continue;
    }
    row.kind = Row::Kind::kBox;
    row.contact = add_contact(0, 0);
    add_friction(i, unit, offset, 1, row.contact);
    // The coordinate has the inertia 1 / yielding and the speed -yielding limit: it stops by the impulse `limit`.
    const double limit = (upper - lower) / 2 / unit, scale = sizes.scale(i);
    const double own = unit * unit * sizes.diagonal(i) + yields;
    row.is_large = own * limit > scale;
    const double yielding = power_below(row.is_large ? scale / limit : own);
    normal.emplace_back(added.add(1 / yielding, -yielding * limit), row.contact, 1.0);
  }
  for (Index i = 0; i < count; ++i) {
    Row& row = rows_[static_cast<std::size_t>(i)];
    if (row.kind != Row::Kind::kFrictionOf) continue;
    const Row& load = rows_[static_cast<std::size_t>(bounds_.friction_of[static_cast<std::size_t>(i)])];
    row.contact = load.contact;
    add_friction(i, row.unit, rows.offset(i), bounds_.mu(i) * std::abs(load.unit) / row.unit, load.contact);
  }
  // The columns of D stand in the order of their contacts.
  std::vector<Index> row_of_contact(contacts_.edges.size(), -1);
  for (Index i = 0; i < count; ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    const bool slides = row.kind == Row::Kind::kBox || row.kind == Row::Kind::kFrictionOf;
    if (slides) row_of_contact[static_cast<std::size_t>(row.contact)] = i;
  }
  for (std::size_t c = static_cast<std::size_t>(nc); c < contacts_.edges.size(); ++c) {
    const Index i = row_of_contact[c];
    if (i < 0) continue;
    for (const double sign : {1.0, -1.0}) {
      add_column(i, sign * rows_[static_cast<std::size_t>(i)].unit, columns++, friction);
    }
  }
  const auto vector = [](const std::vector<double>& numbers) {
    return Vector(Eigen::Map<const Vector>(numbers.data(), static_cast<Index>(numbers.size())));
  };
  const auto unless_zero = [&](const std::vector<double>& numbers) {
    const Vector all = vector(numbers);
    return all.isZero(0) ? Vector() : all;
  };
  contacts_.v = added.velocity(contacts_.v);
  contacts_.N = added.jacobian(problem.N, static_cast<Index>(contacts_.edges.size()), std::move(normal));
  contacts_.D = added.jacobian(problem.D, columns, std::move(friction));
  contacts_.mu = vector(mu);
  contacts_.inertia = added.inertia(problem.inertia);
  contacts_.b = unless_zero(b);
  contacts_.compliance_n = unless_zero(yields_n);
  contacts_.compliance_t = unless_zero(yields_t);
  contacts_.offset_t = unless_zero(offset_t);
  to_ = contact_layout(contacts_);
  enlarges_scale_ = enlarges_scale(sizes);
}

/// Whether the contacts' residuals of an island are relative to more than those of the rows. What a claim
/// leaves below the verdict's bound is no more than this share.
bool ContactsOfRows::enlarges_scale(const RowSizes& sizes) const {
  constexpr double kMore = 1.0005;
  const auto is_larger = [&](Index contact, double scale) {
    const double q = dot_column(contacts_.N, contact, contacts_.v) + contacts_.offset(contact);
    return -q > kMore * scale;
  };
  for (Index c = 0; c < from_.nc; ++c) {
    if (is_larger(c, sizes.scale_of_contact(c))) return true;
  }
  for (Index i = 0; i < from_.rows; ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    const Index last = row.kind == Row::Kind::kEquality ? row.contact + 1 : row.contact;
    for (Index c = row.contact; c <= last; ++c) {
      if (is_larger(c, sizes.scale(i))) return true;
    }
  }
  return false;
}

/// f' of the row, from the impulses of its contacts.
double ContactsOfRows::impulse(const Row& row, const Vector& x) const {
  if (row.kind == Row::Kind::kLimit) return x(row.contact);
  if (row.kind == Row::Kind::kEquality) return x(row.contact) - x(row.contact + 1);
  const Index first = to_.friction_offset() + to_.friction_begin[static_cast<std::size_t>(row.contact)];
  return x(first) - x(first + 1);
}

Vector ContactsOfRows::restore(const Vector& x) const {
  Vector z(from_.size());
  z.head(from_.nc) = x.head(from_.nc);
  z.segment(from_.friction_offset(), from_.friction) = x.segment(to_.friction_offset(), from_.friction);
  z.segment(from_.lambda_offset(), from_.cones) = x.segment(to_.lambda_offset(), from_.cones);
  for (Index i = 0; i < from_.rows; ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    const double f = row.unit * impulse(row, x) + row.middle;
    z(from_.row_offset() + i) = f < bounds_.lower(i) ? bounds_.lower(i) : f > bounds_.upper(i) ? bounds_.upper(i) : f;
  }
  return z;
}

Vector ContactsOfRows::start(const Vector& z) const {
  Vector x = Vector::Zero(to_.size());
  x.head(from_.nc) = z.head(from_.nc);
  x.segment(to_.friction_offset(), from_.friction) = z.segment(from_.friction_offset(), from_.friction);
  x.segment(to_.lambda_offset(), from_.cones) = z.segment(from_.lambda_offset(), from_.cones);
  for (Index i = 0; i < from_.rows; ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    const double f = (z(from_.row_offset() + i) - row.middle) / row.unit;
    if (row.kind == Row::Kind::kLimit || row.kind == Row::Kind::kEquality) {
      x(row.contact) = std::max(f, 0.0);
      if (row.kind == Row::Kind::kEquality) x(row.contact + 1) = std::max(-f, 0.0);
      continue;
    }
    const Index first = to_.friction_offset() + to_.friction_begin[static_cast<std::size_t>(row.contact)];
    x(first) = std::max(f, 0.0);
    x(first + 1) = std::max(-f, 0.0);
    if (row.kind == Row::Kind::kBox) x(row.contact) = (bounds_.upper(i) - bounds_.lower(i)) / 2 / row.unit;
  }
  return x;
}

Vector ContactsOfRows::proof(const Vector& u) const {
  Vector all = Vector::Zero(from_.nc + from_.rows);
  all.head(from_.nc) = u.head(from_.nc);
  for (Index i = 0; i < from_.rows; ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    if (row.kind == Row::Kind::kLimit) all(from_.nc + i) = row.unit * u(row.contact);
    if (row.kind == Row::Kind::kEquality) all(from_.nc + i) = row.unit * (u(row.contact) - u(row.contact + 1));
  }
  return all;
}

bool ContactsOfRows::is_in_doubt(const ContactProblem& problem, const Vector& x, const Vector& z,
                                 const Vector& velocity) const {
  constexpr double kNearBound = 0.999, kSurelyPasses = 0.5e-4, kHardlyCut = 1e-5;
  if (enlarges_scale_) return true;
  const BoundedRows& rows = problem.rows;
  for (Index i = 0; i < rows.size(); ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i)];
    const double f = z(from_.row_offset() + i), w = dot_column(rows.R, i, velocity) + rows.offset(i) + rows.yields(i) * f;
    double lower = bounds_.lower(i), upper = bounds_.upper(i);
    if (row.is_large && (f <= kNearBound * lower || f >= kNearBound * upper)) return true;
    if (const int of = bounds_.friction_of[static_cast<std::size_t>(i)]; of >= 0) {
      upper = std::abs(bounds_.mu(i) * z(from_.row_offset() + of));
      lower = -upper;
    }
    const double cut = std::abs(row.unit * impulse(row, x) + row.middle - f);
    if (!(cut * row.diagonal * row.weight <= kHardlyCut)) return true;
    double residual = w;
    if (lower > -kNoBound) residual = std::min(residual, row.diagonal * (f - lower));
    if (upper < kNoBound) residual = std::max(residual, row.diagonal * (f - upper));
    if (!(std::abs(residual) * row.weight <= kSurelyPasses)) return true;
  }
  return false;
}

}  // namespace lcpbench
