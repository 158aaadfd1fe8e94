#include "core/io/problem_checks.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/entries.h"
#include "core/settings.h"
#include "core/utf8.h"

namespace lcpbench {
namespace {

/// Six digits: what single-precision engines keep of a unit vector.
constexpr double kDirectionTolerance = 1e-6;

/// Two digits.
std::string short_real(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

/// Row of the first entry where column `partner` is not exactly the negative of `column`; -1 when there is none.
Index first_unpaired_row(const Matrix& D, Index column, Index partner) {
  for (Index row = 0; row < D.rows(); ++row) {
    if (!(D(row, partner) == -D(row, column))) return row;
  }
  return -1;
}

Index first_unpaired_row(const SparseMatrix& D, Index column, Index partner) {
  const SparseMatrix sum = D.col(column) + D.col(partner);
  Index first = -1;
  for_each_entry(sum, 0, [&](Index row, double) { first = first < 0 ? row : first; });
  return first;
}

/// Checks of data, whose errors name the file and the field.
class Checker {
 public:
  explicit Checker(const std::string& origin) : origin_(origin) {}

  void lcp(const Lcp& lcp) const {
    shape(lcp.M.rows(), lcp.M.cols(), lcp.size(), lcp.size(), "M");
    finite(lcp.M, "M");
    finite(lcp.q, "q");
    if (!lcp.is_mixed()) return;
    sizes(lcp.bounds, lcp.size(), "");
    for (Index i = 0; i < lcp.size(); ++i) bounds(lcp.bounds, i, "");
  }

  void contacts(const ContactProblem& problem) const {
    for (std::size_t i = 0; i < problem.edges.size(); ++i) {
      const int edges = problem.edges[i];
      if (edges < 0 || edges % 2 != 0) wrong(entry_name("edges", i), std::to_string(edges), "an even number >= 0");
    }
    size(problem.mu, problem.nc(), "mu");
    for (std::size_t i = 0; i < problem.edges.size(); ++i) {
      friction_coefficient(problem.mu(static_cast<Index>(i)), problem.edges[i], entry_name("mu", i));
    }
    finite(problem.v, "v");
    if (problem.has_offset()) size(problem.b, problem.nc(), "b");
    finite(problem.b, "b");
    softness(problem);
    jacobian(problem.N, problem.ngc(), problem.nc(), "N");
    jacobian(problem.D, problem.ngc(), contact_layout(problem).friction, "D");
    pairs(problem);
    bounded_rows(problem.rows, problem.ngc());
    inertia(problem.inertia, problem.ngc());
  }

  void scene(const RigidScene& scene) const {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) body(scene.bodies[i], entry_name("bodies", i));
    for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
      rigid_contact(scene, scene.contacts[i], entry_name("contacts", i));
    }
  }

  /// At most kMaxNameBytes of UTF-8 without control characters.
  void text(std::string_view value, const std::string& field) const {
    if (value.size() > kMaxNameBytes) {
      fail(field + ": " + std::to_string(value.size()) + " bytes long, at most " + std::to_string(kMaxNameBytes) +
           " are allowed");
    }
    if (!is_utf8(value)) fail(field + ": not UTF-8");
    if (printable(value) != visible(value)) fail(field + ": has a control character");
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { throw input_error(origin_, message); }
  [[noreturn]] void wrong(const std::string& field, const std::string& found, const std::string& expected) const {
    fail(field + " is " + found + ", expected " + expected);
  }

  void finite(double value, const std::string& field) const {
    if (!std::isfinite(value)) wrong(field, format_real(value), "a finite number");
  }
  // The name of an entry is made only if the entry fails.
  void finite(const Vector& values, const std::string& field) const {
    for (Index i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values(i))) finite(values(i), entry_name(field, static_cast<std::size_t>(i)));
    }
  }
  template <class AnyMatrix>
  void finite(const AnyMatrix& matrix, const std::string& field) const {
    for (Index column = 0; column < matrix.cols(); ++column) {
      for_each_entry(matrix, column, [&](Index row, double value) {
        if (!std::isfinite(value)) finite(value, field + ": " + entry(row, column));
      });
    }
  }
  static std::string entry(Index row, Index column) {
    return "entry (" + std::to_string(row) + ", " + std::to_string(column) + ")";
  }

  void shape(Index rows, Index cols, Index expected_rows, Index expected_cols, const std::string& field) const {
    if (rows == expected_rows && cols == expected_cols) return;
    fail(field + ": " + std::to_string(rows) + " x " + std::to_string(cols) + ", expected " +
         std::to_string(expected_rows) + " x " + std::to_string(expected_cols));
  }
  template <class Values>
  void size(const Values& values, Index expected, const std::string& field) const {
    const auto found = static_cast<Index>(values.size());
    if (found != expected) fail(field + ": " + count_of(found, "entry") + ", expected " + std::to_string(expected));
  }

  /// @param path  stands before the fields' names
  void sizes(const LcpBounds& bounds, Index expected, const std::string& path) const {
    size(bounds.lower, expected, path + "lower");
    size(bounds.upper, expected, path + "upper");
    size(bounds.mu, expected, path + "mu");
    size(bounds.friction_of, expected, path + "friction_of");
  }

  /// Of row i. Its friction cannot be limited by an unknown that may be negative, or is limited itself.
  void bounds(const LcpBounds& bounds, Index i, const std::string& path) const {
    const auto at = static_cast<std::size_t>(i);
    const auto name = [&](const char* field) { return entry_name(path + field, at); };
    const int of = bounds.friction_of[at];
    const double lower = bounds.lower(i);
    const double upper = bounds.upper(i);
    if (of < -1) wrong(name("friction_of"), std::to_string(of), "the index of another row, or null");
    if (of < 0) {
      constexpr double kNone = std::numeric_limits<double>::infinity();
      if (lower != -kNone) finite(lower, name("lower"));
      if (upper != kNone) finite(upper, name("upper"));
      if (lower > upper) wrong(name("lower"), format_real(lower), "at most upper, " + format_real(upper));
      return;
    }
    if (of >= bounds.lower.size() || of == i) {
      wrong(name("friction_of"), std::to_string(of), "the index of another row");
    }
    if (bounds.friction_of[static_cast<std::size_t>(of)] >= 0 || !(bounds.lower(of) >= 0)) {
      fail(name("friction_of") + ": row " + std::to_string(of) + " needs a lower bound >= 0 of its own");
    }
    if (std::isfinite(lower) || std::isfinite(upper)) {
      fail(name(std::isfinite(lower) ? "lower" : "upper") + ": given, but friction_of bounds this row");
    }
    friction_coefficient(bounds.mu(i), 2, name("mu"));
  }

  void bounded_rows(const BoundedRows& rows, Index ngc) const {
    const Index count = rows.size();
    if (count == 0 && cols(rows.R) == 0) return;
    jacobian(rows.R, ngc, count, "rows.R");
    sizes(rows.bounds, count, "rows.");
    if (rows.b.size() > 0) size(rows.b, count, "rows.b");
    finite(rows.b, "rows.b");
    if (rows.compliance.size() > 0) size(rows.compliance, count, "rows.compliance");
    size(rows.is_angle, count, "rows.unit");
    if (!rows.names.empty()) size(rows.names, count, "rows.names");
    for (std::size_t i = 0; i < rows.names.size(); ++i) text(rows.names[i], entry_name("rows.names", i));
    for (Index i = 0; i < count; ++i) {
      if (rows.bounds.friction_of[static_cast<std::size_t>(i)] < 0) zero_is_allowed(rows, i);
      bounds(rows.bounds, i, "rows.");
      compliance(rows.yields(i), entry_name("rows.compliance", static_cast<std::size_t>(i)));
    }
  }

  /// Its impulse may be zero, and something else.
  void zero_is_allowed(const BoundedRows& rows, Index i) const {
    const double lower = rows.bounds.lower(i), upper = rows.bounds.upper(i);
    if (lower <= 0 && upper >= 0 && lower < upper) return;
    const auto at = static_cast<std::size_t>(i);
    const bool named = at < rows.names.size() && !rows.names[at].empty();
    const std::string name = named ? " (" + rows.names[at] + ")" : "";
    if (!(lower <= 0)) wrong(entry_name("rows.lower", at) + name, format_real(lower), "at most 0");
    if (!(upper >= 0)) wrong(entry_name("rows.upper", at) + name, format_real(upper), "at least 0");
    fail(entry_name("rows.lower", at) + name + " and the upper bound are 0: the row has no effect, leave it out");
  }

  /// Square, of finite numbers, and symmetric.
  void symmetric(const Matrix& matrix, Index order, const std::string& field) const {
    shape(matrix.rows(), matrix.cols(), order, order, field);
    finite(matrix, field);
    for (Index column = 0; column < order; ++column) {
      for (Index row = column + 1; row < order; ++row) {
        const double below = matrix(row, column);
        const double above = matrix(column, row);
        if (below == above) continue;
        fail(field + ": not symmetric: " + entry(row, column) + " is " + format_real(below) + ", " +
             entry(column, row) + " is " + format_real(above));
      }
    }
  }

  /// Symmetric, and Cholesky's pivots, tested one by one: Eigen's own test lets NaN pass.
  void positive_definite(const Matrix& matrix, Index order, const std::string& field) const {
    symmetric(matrix, order, field);
    if (order == 0) return;
    const Eigen::LLT<Matrix> cholesky(matrix);
    const Vector pivots = cholesky.matrixLLT().diagonal();
    const bool positive =
        std::all_of(pivots.begin(), pivots.end(), [](double pivot) { return std::isfinite(pivot) && pivot > 0; });
    if (cholesky.info() == Eigen::Success && positive) return;
    fail(field + ": not positive definite (Cholesky factorization fails)");
  }

  /// Elimination with the largest diagonal entry next. What is left of a semidefinite matrix where no entry is positive
  /// may be other than zero by the rounding of n operations on its largest entry.
  void positive_semidefinite(const Matrix& given, const std::string& field) const {
    Matrix matrix = given;
    const Index n = matrix.rows();
    if (n == 0) return;
    const double largest = matrix.diagonal().cwiseAbs().maxCoeff();
    const double rounding = 8.0 * static_cast<double>(n) * std::numeric_limits<double>::epsilon() * largest;
    bool passes = matrix.diagonal().minCoeff() >= 0;
    for (Index step = 0; step < n && passes; ++step) {
      Index pivot = 0;
      if (!(matrix.diagonal().maxCoeff(&pivot) > rounding)) break;
      const Vector column = matrix.col(pivot);
      matrix.noalias() -= column * (column / column(pivot)).transpose();
      matrix.col(pivot).setZero();
      matrix.row(pivot).setZero();
      passes = matrix.diagonal().minCoeff() >= -rounding;
    }
    if (!passes || !(matrix.cwiseAbs().maxCoeff() <= rounding)) fail(field + ": not positive semidefinite" + remedy(given));
  }

  /// Of a matrix that lost its last digits.
  static std::string remedy(const Matrix& matrix) {
    constexpr double kLostDigits = 1e-5;
    constexpr Index kLargest = 1000;
    if (matrix.rows() > kLargest) return "";
    const Vector values = Eigen::SelfAdjointEigenSolver<Matrix>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
    const double least = values.minCoeff(), largest = values.maxCoeff();
    if (!(least < 0) || !(-least <= kLostDigits * largest)) return "";
    return ": its least eigenvalue is " + short_real(least) + ", its largest " + short_real(largest) +
           "; if its entries are rounded to few digits, add " + short_real(-1.1 * least) + " to each on its diagonal";
  }

  void inertia(const Inertia& inertia, Index ngc) const {
    if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
      positive_definite(dense->G, ngc, "G");
    } else if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
      shape(dimension(inertia), dimension(inertia), ngc, ngc, "G_blocks");
      for (std::size_t i = 0; i < bodies->blocks.size(); ++i) {
        positive_definite(bodies->blocks[i], bodies->blocks[i].rows(), entry_name("G_blocks", i));
      }
    } else if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
      shape(factors->X.rows(), factors->X.cols(), ngc, factors->alpha.size(), "G_factors.X");
      finite(factors->X, "G_factors.X");
      finite(factors->alpha, "G_factors.alpha");
      for (Index i = 0; i < factors->alpha.size(); ++i) {
        const double alpha = factors->alpha(i);
        if (!(alpha > 0)) wrong(entry_name("G_factors.alpha", static_cast<std::size_t>(i)), format_real(alpha), "> 0");
      }
    } else {
      const Matrix& Ginv = std::get<InverseInertia>(inertia).Ginv;
      symmetric(Ginv, ngc, "Ginv");
      positive_semidefinite(Ginv, "Ginv");
    }
  }

  void jacobian(const Jacobian& J, Index expected_rows, Index expected_cols, const std::string& field) const {
    shape(rows(J), cols(J), expected_rows, expected_cols, field);
    std::visit([&](const auto& matrix) { finite(matrix, field); }, J);
  }

  void pairs(const ContactProblem& problem) const {
    Index first = 0;
    for (std::size_t contact = 0; contact < problem.edges.size(); ++contact) {
      const Index half = problem.edges[contact] / 2;
      for (Index column = first; column < first + half; ++column) {
        const Index row =
            std::visit([&](const auto& D) { return first_unpaired_row(D, column, column + half); }, problem.D);
        if (row < 0) continue;
        fail("D: contact " + std::to_string(contact) + ": column " + std::to_string(column + half) +
             " is not the negative of column " + std::to_string(column) + " (row " + std::to_string(row) + ")");
      }
      first += 2 * half;
    }
  }

  void friction_coefficient(double mu, int edges, const std::string& field) const {
    finite(mu, field);
    if (!(mu >= 0)) wrong(field, format_real(mu), ">= 0");
    if (edges > 0 || mu == 0) return;
    fail(field + " is " + format_real(mu) + " but the contact has no edges: its friction would be ignored");
  }

  void compliance(double r, const std::string& field) const {
    if (!(r >= 0 && std::isfinite(r))) wrong(field, format_real(r), "a number >= 0");
  }
  [[noreturn]] void fail_without_edges(const std::string& field) const {
    fail(field + " is not 0, but the contact has no edges");
  }

  /// Compliance and tangential offsets. A contact without edges may have normal compliance only.
  void softness(const ContactProblem& problem) const {
    if (problem.compliance_n.size() > 0) size(problem.compliance_n, problem.nc(), "compliance_n");
    if (problem.compliance_t.size() > 0) size(problem.compliance_t, problem.nc(), "compliance_t");
    if (problem.offset_t.size() > 0) size(problem.offset_t, 2 * problem.nc(), "offset_t");
    finite(problem.offset_t, "offset_t");
    for (std::size_t i = 0; problem.is_soft() && i < problem.edges.size(); ++i) {
      const auto contact = static_cast<Index>(i);
      compliance(problem.normal_compliance(contact), entry_name("compliance_n", i));
      compliance(problem.tangential_compliance(contact), entry_name("compliance_t", i));
      if (problem.edges[i] > 0) continue;
      if (problem.tangential_compliance(contact) != 0) fail_without_edges(entry_name("compliance_t", i));
      for (const int k : {0, 1}) {
        if (problem.tangential_offset(contact, k) != 0) {
          fail_without_edges(entry_name("offset_t", 2 * i + static_cast<std::size_t>(k)));
        }
      }
    }
  }

  void body(const RigidBody& body, const std::string& path) const {
    finite(body.mass, path + ".mass");
    if (!(body.mass > 0)) wrong(path + ".mass", format_real(body.mass), "> 0");
    if (!std::isfinite(1 / body.mass)) fail(path + ".mass is " + format_real(body.mass) + "; its inverse overflows");
    positive_definite(body.inertia, 3, path + ".inertia");
    finite(Vector(body.position), path + ".position");
    finite(Vector(body.linear_velocity), path + ".linear_velocity");
    finite(Vector(body.angular_velocity), path + ".angular_velocity");
  }

  void rigid_contact(const RigidScene& scene, const RigidContact& contact, const std::string& path) const {
    const auto count = static_cast<int>(scene.bodies.size());
    const std::string bodies = "one of the " + std::to_string(count) + " bodies, counted from 0";
    if (contact.body_a == RigidContact::kWorld && contact.body_b != RigidContact::kWorld) {
      fail(path + ".body_a is -1, the world, which has to be body_b: swap the bodies and turn the normal");
    }
    if (contact.body_a < 0 || contact.body_a >= count) wrong(path + ".body_a", std::to_string(contact.body_a), bodies);
    if (contact.body_b < RigidContact::kWorld || contact.body_b >= count) {
      wrong(path + ".body_b", std::to_string(contact.body_b), "-1 (world) or " + bodies);
    }
    if (contact.body_a == contact.body_b) fail(path + ".body_b is body_a: a contact needs two bodies");
    if (contact.edges != 0 && contact.edges != 4) wrong(path + ".edges", std::to_string(contact.edges), "0 or 4");
    finite(Vector(contact.point), path + ".point");
    direction(contact.normal, path + ".normal");
    if (contact.edges > 0) {
      direction(contact.tangent, path + ".tangent");
      const double cosine = contact.normal.dot(contact.tangent);
      if (!(std::abs(cosine) <= kDirectionTolerance)) {
        fail(path + ".tangent is not orthogonal to the normal: their scalar product is " + format_real(cosine));
      }
    }
    friction_coefficient(contact.mu, contact.edges, path + ".mu");
    finite(contact.b, path + ".b");
    compliance(contact.compliance_n, path + ".compliance_n");
    compliance(contact.compliance_t, path + ".compliance_t");
    finite(Vector(contact.offset_t), path + ".offset_t");
    if (contact.edges == 0 && contact.compliance_t != 0) fail_without_edges(path + ".compliance_t");
    if (contact.edges == 0 && !contact.offset_t.isZero(0)) fail_without_edges(path + ".offset_t");
    for (const int body : {contact.body_a, contact.body_b}) {
      if (body == RigidContact::kWorld) continue;
      const Eigen::Vector3d arm = contact.point - scene.bodies[static_cast<std::size_t>(body)].position;
      // Each entry of arm x direction is a difference of two products of at most the arm's largest entry.
      if (std::isfinite(4 * arm.cwiseAbs().maxCoeff())) continue;
      fail(path + ".point: the distance to body " + std::to_string(body) + " overflows");
    }
  }

  void direction(const Eigen::Vector3d& direction, const std::string& field) const {
    finite(Vector(direction), field);
    const double length = direction.norm();
    if (std::abs(length - 1) <= kDirectionTolerance) return;
    fail(field + " has length " + format_real(length) + ", expected 1");
  }

  const std::string& origin_;
};

}  // namespace

InputError input_error(std::string_view origin, std::string_view message) {
  return InputError(std::string(origin) + ": " + std::string(message));
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  if (text.size() <= kLongest) return "'" + std::string(text) + "'";
  return "'" + std::string(text.substr(0, kLongest)) + "...'";
}

std::string entry_name(std::string_view field, std::size_t i) {
  return std::string(field) + "[" + std::to_string(i) + "]";
}

std::string count_of(Index count, const std::string& singular) {
  std::string word = singular;
  if (count != 1 && word.ends_with('y')) word.replace(word.size() - 1, 1, "ie");
  return std::to_string(count) + " " + word + (count == 1 ? "" : "s");
}

void check_name(std::string_view name, const std::string& origin) {
  if (name.empty()) throw input_error(origin, "name: empty");
  Checker(origin).text(name, "name");
}

std::string problem_name_of_file(const std::string& file) {
  std::string name = file.substr(file.rfind('/') + 1);  // npos + 1 is 0
  for (const std::string_view extension : {".M.mtx", ".q.mtx", ".dat", ".txt"}) {
    if (name.size() > extension.size() && name.ends_with(extension)) {
      name.resize(name.size() - extension.size());
      break;
    }
  }
  name.resize(std::min(name.size(), kMaxNameBytes));
  if (name.empty()) return "unnamed";
  return printable(name);
}

void check_lcp(const Lcp& lcp, const std::string& origin) { Checker(origin).lcp(lcp); }
void check_contact(const ContactProblem& problem, const std::string& origin) { Checker(origin).contacts(problem); }
void check_scene(const RigidScene& scene, const std::string& origin) { Checker(origin).scene(scene); }

}  // namespace lcpbench
