#include "core/io/problem_checks.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/settings.h"
#include "core/utf8.h"

namespace lcpbench {
namespace {

/// Six digits: what single-precision engines keep of a unit vector.
constexpr double kDirectionTolerance = 1e-6;

std::string at(std::string_view field, Index i) { return std::string(field) + "[" + std::to_string(i) + "]"; }

std::string entry(Index row, Index column) {
  return "entry (" + std::to_string(row) + ", " + std::to_string(column) + ")";
}

std::string not_finite(double value) { return format_real(value) + ", expected a finite number"; }

void check_finite(const Vector& values, std::string_view field, const std::string& origin) {
  for (Index i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values(i))) throw input_error(origin, at(field, i) + " is " + not_finite(values(i)));
  }
}

void check_finite(const Matrix& matrix, std::string_view field, const std::string& origin) {
  for (Index column = 0; column < matrix.cols(); ++column) {
    for (Index row = 0; row < matrix.rows(); ++row) {
      if (std::isfinite(matrix(row, column))) continue;
      throw input_error(origin,
                        std::string(field) + ": " + entry(row, column) + " is " + not_finite(matrix(row, column)));
    }
  }
}

void check_finite(const SparseMatrix& matrix, std::string_view field, const std::string& origin) {
  for (Index column = 0; column < matrix.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator it(matrix, column); it; ++it) {
      if (std::isfinite(it.value())) continue;
      throw input_error(origin, std::string(field) + ": " + entry(it.row(), column) + " is " + not_finite(it.value()));
    }
  }
}

void check_shape(Index rows, Index cols, Index expected_rows, Index expected_cols, std::string_view field,
                 const std::string& origin) {
  if (rows == expected_rows && cols == expected_cols) return;
  throw input_error(origin, std::string(field) + ": " + std::to_string(rows) + " x " + std::to_string(cols) +
                                ", expected " + std::to_string(expected_rows) + " x " + std::to_string(expected_cols));
}

void check_size(Index size, Index expected, std::string_view field, const std::string& origin) {
  if (size == expected) return;
  throw input_error(origin,
                    std::string(field) + ": " + count_of(size, "entry") + ", expected " + std::to_string(expected));
}

void check_symmetric(const Matrix& matrix, std::string_view field, const std::string& origin) {
  for (Index column = 0; column < matrix.cols(); ++column) {
    for (Index row = column + 1; row < matrix.rows(); ++row) {
      const double below = matrix(row, column);
      const double above = matrix(column, row);
      if (below == above) continue;
      throw input_error(origin, std::string(field) + ": not symmetric: " + entry(row, column) + " is " +
                                    format_real(below) + ", " + entry(column, row) + " is " + format_real(above));
    }
  }
}

/// Cholesky's pivots, tested one by one: Eigen's own test lets NaN pass.
void check_positive_definite(const Matrix& matrix, std::string_view field, const std::string& origin) {
  if (matrix.rows() == 0) return;
  const Eigen::LLT<Matrix> cholesky(matrix);
  const Vector pivots = cholesky.matrixLLT().diagonal();
  const bool positive =
      std::all_of(pivots.begin(), pivots.end(), [](double pivot) { return std::isfinite(pivot) && pivot > 0; });
  if (cholesky.info() == Eigen::Success && positive) return;
  throw input_error(origin, std::string(field) + ": not positive definite (Cholesky factorization fails)");
}

/// Elimination with the largest diagonal entry next. What is left of a semidefinite matrix where no entry is positive may
/// be other than zero by the rounding of n operations on its largest entry.
void check_positive_semidefinite(Matrix matrix, std::string_view field, const std::string& origin) {
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
  if (passes && matrix.cwiseAbs().maxCoeff() <= rounding) return;
  throw input_error(origin, std::string(field) + ": not positive semidefinite");
}

struct InertiaChecker {
  Index ngc;
  const std::string& origin;

  void operator()(const DenseInertia& inertia) const {
    check_shape(inertia.G.rows(), inertia.G.cols(), ngc, ngc, "G", origin);
    check_finite(inertia.G, "G", origin);
    check_symmetric(inertia.G, "G", origin);
    check_positive_definite(inertia.G, "G", origin);
  }
  void operator()(const BlockInertia& inertia) const {
    check_shape(dimension(inertia), dimension(inertia), ngc, ngc, "G_blocks", origin);
    for (std::size_t i = 0; i < inertia.blocks.size(); ++i) {
      const std::string field = at("G_blocks", static_cast<Index>(i));
      const Matrix& block = inertia.blocks[i];
      check_shape(block.rows(), block.cols(), block.rows(), block.rows(), field, origin);
      check_finite(block, field, origin);
      check_symmetric(block, field, origin);
      check_positive_definite(block, field, origin);
    }
  }
  void operator()(const FactoredInertia& inertia) const {
    check_shape(inertia.X.rows(), inertia.X.cols(), ngc, inertia.alpha.size(), "G_factors.X", origin);
    check_finite(inertia.X, "G_factors.X", origin);
    check_finite(inertia.alpha, "G_factors.alpha", origin);
    for (Index i = 0; i < inertia.alpha.size(); ++i) {
      if (inertia.alpha(i) > 0) continue;
      throw input_error(origin, at("G_factors.alpha", i) + " is " + format_real(inertia.alpha(i)) + ", expected > 0");
    }
  }
  void operator()(const InverseInertia& inertia) const {
    check_shape(inertia.Ginv.rows(), inertia.Ginv.cols(), ngc, ngc, "Ginv", origin);
    check_finite(inertia.Ginv, "Ginv", origin);
    check_symmetric(inertia.Ginv, "Ginv", origin);
    check_positive_semidefinite(inertia.Ginv, "Ginv", origin);
  }
};

void check_jacobian(const Jacobian& J, Index rows_expected, Index cols_expected, std::string_view field,
                    const std::string& origin) {
  check_shape(rows(J), cols(J), rows_expected, cols_expected, field, origin);
  std::visit([&](const auto& matrix) { check_finite(matrix, field, origin); }, J);
}

void check_edges(const std::vector<int>& edges, const std::string& origin) {
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i] >= 0 && edges[i] % 2 == 0) continue;
    throw input_error(origin, at("edges", static_cast<Index>(i)) + " is " + std::to_string(edges[i]) +
                                  ", expected an even number >= 0");
  }
}

void check_friction_coefficient(double mu, int edges, const std::string& field, const std::string& origin) {
  if (!std::isfinite(mu)) throw input_error(origin, field + " is " + not_finite(mu));
  if (!(mu >= 0)) throw input_error(origin, field + " is " + format_real(mu) + ", expected >= 0");
  if (edges == 0 && mu > 0) {
    throw input_error(origin, field + " is " + format_real(mu) +
                                  " but the contact has no edges: its friction would be "
                                  "ignored");
  }
}

[[noreturn]] void throw_unpaired(Index contact, Index column, Index partner, Index row, const std::string& origin) {
  throw input_error(origin, "D: contact " + std::to_string(contact) + ": column " + std::to_string(partner) +
                                " is not the negative of column " + std::to_string(column) + " (row " +
                                std::to_string(row) + ")");
}

/// Row of the first entry where column `partner` is not exactly the negative of `column`; -1 when there is none.
Index first_unpaired_row(const Matrix& D, Index column, Index partner) {
  for (Index row = 0; row < D.rows(); ++row) {
    if (!(D(row, partner) == -D(row, column))) return row;
  }
  return -1;
}

Index first_unpaired_row(const SparseMatrix& D, Index column, Index partner) {
  SparseMatrix::InnerIterator entry(D, column);
  SparseMatrix::InnerIterator opposite(D, partner);
  while (entry || opposite) {
    const Index row = !entry ? opposite.row() : !opposite ? entry.row() : std::min<Index>(entry.row(), opposite.row());
    const double value = entry && entry.row() == row ? entry.value() : 0.0;
    const double negative = opposite && opposite.row() == row ? opposite.value() : 0.0;
    if (!(negative == -value)) return row;
    if (entry && entry.row() == row) ++entry;
    if (opposite && opposite.row() == row) ++opposite;
  }
  return -1;
}

void check_pairs(const ContactProblem& problem, const std::string& origin) {
  const ContactLayout layout = contact_layout(problem);
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto i = static_cast<std::size_t>(contact);
    const Index half = problem.edges[i] / 2;
    for (Index column = layout.friction_begin[i]; column < layout.friction_begin[i] + half; ++column) {
      const Index row =
          std::visit([&](const auto& D) { return first_unpaired_row(D, column, column + half); }, problem.D);
      if (row >= 0) throw_unpaired(contact, column, column + half, row, origin);
    }
  }
}

void check_unit(const Eigen::Vector3d& direction, const std::string& field, const std::string& origin) {
  if (std::abs(direction.norm() - 1) <= kDirectionTolerance) return;
  throw input_error(origin, field + " has length " + format_real(direction.norm()) + ", expected 1");
}

void check_body_index(int body, std::size_t bodies, int lowest, const std::string& field, const std::string& origin) {
  if (body >= lowest && body < static_cast<std::int64_t>(bodies)) return;
  throw input_error(origin, field + " is " + std::to_string(body) + ", expected " +
                                (lowest < 0 ? "-1 (world) or " : "") + "one of the " + std::to_string(bodies) +
                                " bodies, counted from 0");
}

void check_body(const RigidBody& body, const std::string& path, const std::string& origin) {
  if (!std::isfinite(body.mass)) throw input_error(origin, path + ".mass is " + not_finite(body.mass));
  if (!(body.mass > 0)) throw input_error(origin, path + ".mass is " + format_real(body.mass) + ", expected > 0");
  const Matrix inertia = body.inertia;
  check_finite(inertia, path + ".inertia", origin);
  check_symmetric(inertia, path + ".inertia", origin);
  check_positive_definite(inertia, path + ".inertia", origin);
  check_finite(Vector(body.position), path + ".position", origin);
  check_finite(Vector(body.linear_velocity), path + ".linear_velocity", origin);
  check_finite(Vector(body.angular_velocity), path + ".angular_velocity", origin);
}

void check_directions(const RigidContact& contact, const std::string& path, const std::string& origin) {
  check_finite(Vector(contact.point), path + ".point", origin);
  check_finite(Vector(contact.normal), path + ".normal", origin);
  check_unit(contact.normal, path + ".normal", origin);
  if (contact.edges == 0) return;
  check_finite(Vector(contact.tangent), path + ".tangent", origin);
  check_unit(contact.tangent, path + ".tangent", origin);
  const double cosine = contact.normal.dot(contact.tangent);
  if (!(std::abs(cosine) <= kDirectionTolerance)) {
    throw input_error(
        origin, path + ".tangent is not orthogonal to the normal: their scalar product is " + format_real(cosine));
  }
}

void check_lever_arm(const RigidScene& scene, const RigidContact& contact, int body, const std::string& path,
                     const std::string& origin) {
  if (body == RigidContact::kWorld) return;
  const Eigen::Vector3d arm = contact.point - scene.bodies[static_cast<std::size_t>(body)].position;
  // Each entry of arm x direction is a difference of two products of at most the arm's largest entry.
  if (std::isfinite(4 * arm.cwiseAbs().maxCoeff())) return;
  throw input_error(origin, path + ".point: the distance to body " + std::to_string(body) + " overflows");
}

void check_compliance(double r, const std::string& field, const std::string& origin) {
  if (r >= 0 && std::isfinite(r)) return;
  throw input_error(origin, field + " is " + (std::isfinite(r) ? format_real(r) : not_finite(r)) +
                                ", expected a number >= 0");
}

InputError no_edges(const std::string& field, const std::string& origin) {
  return input_error(origin, field + " is not 0, but the contact has no edges");
}

/// @pre the sizes of edges and mu agree
void check_softness(const ContactProblem& problem, const std::string& origin) {
  const auto check_count = [&](const Vector& values, Index count, const char* field) {
    if (values.size() > 0) check_size(values.size(), count, field, origin);
  };
  check_count(problem.compliance_n, problem.nc(), "compliance_n");
  check_count(problem.compliance_t, problem.nc(), "compliance_t");
  check_count(problem.offset_t, 2 * problem.nc(), "offset_t");
  check_finite(problem.offset_t, "offset_t", origin);
  for (Index i = 0; i < problem.nc(); ++i) {
    check_compliance(problem.normal_compliance(i), at("compliance_n", i), origin);
    check_compliance(problem.tangential_compliance(i), at("compliance_t", i), origin);
    if (problem.edges[static_cast<std::size_t>(i)] > 0) continue;
    if (problem.tangential_compliance(i) != 0) throw no_edges(at("compliance_t", i), origin);
    for (const int k : {0, 1}) {
      if (problem.tangential_offset(i, k) != 0) throw no_edges(at("offset_t", 2 * i + k), origin);
    }
  }
}

void check_rigid_contact(const RigidScene& scene, const RigidContact& contact, const std::string& path,
                         const std::string& origin) {
  check_body_index(contact.body_a, scene.bodies.size(), 0, path + ".body_a", origin);
  check_body_index(contact.body_b, scene.bodies.size(), RigidContact::kWorld, path + ".body_b", origin);
  if (contact.body_a == contact.body_b) {
    throw input_error(origin, path + ".body_b is body_a: a contact needs two bodies");
  }
  if (contact.edges != 0 && contact.edges != 4) {
    throw input_error(origin, path + ".edges is " + std::to_string(contact.edges) + ", expected 0 or 4");
  }
  check_directions(contact, path, origin);
  check_friction_coefficient(contact.mu, contact.edges, path + ".mu", origin);
  if (!std::isfinite(contact.b)) throw input_error(origin, path + ".b is " + not_finite(contact.b));
  check_compliance(contact.compliance_n, path + ".compliance_n", origin);
  check_compliance(contact.compliance_t, path + ".compliance_t", origin);
  check_finite(Vector(contact.offset_t), path + ".offset_t", origin);
  if (contact.edges == 0 && contact.compliance_t != 0) throw no_edges(path + ".compliance_t", origin);
  if (contact.edges == 0 && !contact.offset_t.isZero(0)) throw no_edges(path + ".offset_t", origin);
  check_lever_arm(scene, contact, contact.body_a, path, origin);
  check_lever_arm(scene, contact, contact.body_b, path, origin);
}

bool well_formed_utf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    if (length == 0) return false;
    at += length;
  }
  return true;
}

/// C0, DEL, and the C1 controls U+0080 to U+009F (0xC2 0x80 to 0xC2 0x9F).
bool has_control_character(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 0x20 || byte == 0x7F) return true;
    if (byte == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0) return true;
  }
  return false;
}

}  // namespace

InputError input_error(std::string_view origin, std::string_view message) {
  return InputError(std::string(origin) + ": " + std::string(message));
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  if (text.size() <= kLongest) return "'" + std::string(text) + "'";
  return "'" + std::string(text.substr(0, kLongest)) + "...'";
}

std::string count_of(Index count, const std::string& singular) {
  std::string word = singular;
  if (count != 1 && word.ends_with('y')) word.replace(word.size() - 1, 1, "ie");
  return std::to_string(count) + " " + word + (count == 1 ? "" : "s");
}

void check_name(std::string_view name, const std::string& origin) {
  if (name.empty()) throw input_error(origin, "name: empty");
  if (name.size() > kMaxNameBytes) {
    throw input_error(origin, "name: " + std::to_string(name.size()) + " bytes long, at most " +
                                  std::to_string(kMaxNameBytes) + " are allowed");
  }
  if (!well_formed_utf8(name)) throw input_error(origin, "name: not UTF-8");
  if (has_control_character(name)) throw input_error(origin, "name: has a control character");
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
  if (well_formed_utf8(name) && !has_control_character(name)) return name;
  std::replace_if(
      name.begin(), name.end(),
      [](char c) { return static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F; }, '?');
  return name;
}

void check_lcp(const Lcp& lcp, const std::string& origin) {
  check_shape(lcp.M.rows(), lcp.M.cols(), lcp.size(), lcp.size(), "M", origin);
  check_finite(lcp.M, "M", origin);
  check_finite(lcp.q, "q", origin);
}

void check_contact(const ContactProblem& problem, const std::string& origin) {
  check_edges(problem.edges, origin);
  check_size(problem.mu.size(), problem.nc(), "mu", origin);
  for (Index i = 0; i < problem.nc(); ++i) {
    check_friction_coefficient(problem.mu(i), problem.edges[static_cast<std::size_t>(i)], at("mu", i), origin);
  }
  check_finite(problem.v, "v", origin);
  if (problem.b.size() > 0) check_size(problem.b.size(), problem.nc(), "b", origin);
  check_finite(problem.b, "b", origin);
  check_softness(problem, origin);
  check_jacobian(problem.N, problem.ngc(), problem.nc(), "N", origin);
  check_jacobian(problem.D, problem.ngc(), contact_layout(problem).friction, "D", origin);
  check_pairs(problem, origin);
  std::visit(InertiaChecker{problem.ngc(), origin}, problem.inertia);
}

void check_scene(const RigidScene& scene, const std::string& origin) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    check_body(scene.bodies[i], at("bodies", static_cast<Index>(i)), origin);
  }
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
    check_rigid_contact(scene, scene.contacts[i], at("contacts", static_cast<Index>(i)), origin);
  }
}

}  // namespace lcpbench
