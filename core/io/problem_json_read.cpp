#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "core/io/json_document.h"
#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"

namespace lcpbench {
namespace {

RigidBody read_body(const JsonObject& reader) {
  reader.only({"mass", "inertia", "position", "linear_velocity", "angular_velocity"});
  RigidBody body;
  body.mass = reader.number("mass");
  body.inertia = reader.matrix("inertia", 3, 3);
  body.position = reader.vector("position", 3);
  body.linear_velocity = reader.vector("linear_velocity", 3);
  body.angular_velocity = reader.vector("angular_velocity", 3);
  return body;
}

/// A contact without `edges`, or with 0, is frictionless: a tangent is refused here, mu > 0 by check_scene(). With
/// edges, both are required.
RigidContact read_rigid_contact(const JsonObject& reader) {
  reader.only({"body_a", "body_b", "point", "normal", "tangent", "mu", "edges", "b", "compliance_n", "compliance_t",
               "offset_t"});
  RigidContact contact;
  contact.body_a = reader.integer("body_a");
  contact.body_b = reader.integer("body_b");
  contact.point = reader.vector("point", 3);
  contact.normal = reader.vector("normal", 3);
  if (reader.given("edges")) contact.edges = reader.integer("edges");
  if (reader.given("mu")) contact.mu = reader.number("mu");
  if (reader.given("b")) contact.b = reader.number("b");
  if (reader.given("compliance_n")) contact.compliance_n = reader.number("compliance_n");
  if (reader.given("compliance_t")) contact.compliance_t = reader.number("compliance_t");
  if (reader.given("offset_t")) contact.offset_t = reader.vector("offset_t", 2);
  if (contact.edges != 0) {
    contact.mu = reader.number("mu");
    contact.tangent = reader.vector("tangent", 3);
  } else if (reader.given("tangent")) {
    reader.fail("tangent", ": given, but the contact has no edges");
  }
  return contact;
}

/// N or D by compressed columns: entries starts[i] to starts[i + 1] - 1 of `rows` and `values` are those of column i,
/// in any order, each row at most once.
SparseMatrix read_sparse(const JsonObject& reader, Index rows, Index cols) {
  reader.only({"starts", "rows", "values"});
  const std::vector<int> starts = reader.integers("starts");
  const std::vector<int> row = reader.integers("rows");
  const Vector values = reader.vector("values");
  if (static_cast<Index>(starts.size()) != cols + 1) {
    reader.fail("starts",
                ": " + count_of(static_cast<Index>(starts.size()), "entry") + ", expected " + std::to_string(cols + 1));
  }
  if (static_cast<Index>(row.size()) != values.size()) {
    reader.fail("values", ": " + count_of(values.size(), "entry") + ", expected " + std::to_string(row.size()));
  }
  if (starts.front() != 0) reader.fail("starts", "[0] is " + std::to_string(starts.front()) + ", expected 0");
  if (starts.back() != static_cast<int>(row.size())) {
    reader.fail("starts", ": ends with " + std::to_string(starts.back()) + ", expected " + std::to_string(row.size()) +
                              ", the number of entries");
  }
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(row.size());
  std::vector<Index> column_of_row(static_cast<std::size_t>(rows), -1);
  for (Index column = 0; column < cols; ++column) {
    const auto begin = static_cast<std::size_t>(starts[static_cast<std::size_t>(column)]);
    const auto end = static_cast<std::size_t>(starts[static_cast<std::size_t>(column) + 1]);
    if (end < begin || end > row.size()) {
      reader.fail("starts", "[" + std::to_string(column + 1) + "]: the entries do not ascend");
    }
    for (std::size_t k = begin; k < end; ++k) {
      const auto entry = [&] { return "[" + std::to_string(k) + "] is " + std::to_string(row[k]); };
      if (row[k] < 0 || row[k] >= rows) {
        reader.fail("rows", entry() + ", expected 0 to " + std::to_string(rows - 1));
      }
      Index& last = column_of_row[static_cast<std::size_t>(row[k])];
      if (last == column) reader.fail("rows", entry() + " for the second time in column " + std::to_string(column));
      last = column;
      entries.emplace_back(row[k], column, values(static_cast<Index>(k)));
    }
  }
  SparseMatrix matrix(rows, cols);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// The number of columns of a matrix whose width no other field gives; nullopt if it is dense and has no rows.
std::optional<Index> jacobian_columns(const JsonObject& reader, std::string_view field) {
  if (!reader.is_object(field)) return reader.columns(field);
  return static_cast<Index>(std::max<std::size_t>(reader.inside(field).integers("starts").size(), 1)) - 1;
}

Jacobian read_jacobian(const JsonObject& reader, std::string_view field, Index rows, Index cols) {
  if (!reader.is_object(field)) return reader.matrix(field, rows, cols);
  return read_sparse(reader.inside(field), rows, cols);
}

Inertia read_inertia(const JsonObject& reader, Index ngc) {
  constexpr std::array<std::string_view, 3> kForms{"G", "G_blocks", "G_factors"};
  std::string_view form;
  for (const std::string_view field : kForms) {
    if (!reader.given(field)) continue;
    if (reader.given("Ginv")) reader.fail("Ginv", ": given beside " + std::string(field) + "; it may only replace it");
    if (!form.empty()) reader.fail(form, " and " + std::string(field) + ": only one may be given");
    form = field;
  }
  if (reader.given("Ginv")) return InverseInertia{reader.matrix("Ginv", ngc, ngc)};
  if (form.empty()) reader.fail("G", ": missing (or G_blocks, G_factors or Ginv)");
  if (form == "G_blocks") return BlockInertia{reader.square_matrices("G_blocks")};
  if (form == "G") return DenseInertia{reader.matrix("G", ngc, ngc)};
  const JsonObject factors = reader.inside("G_factors");
  factors.only({"X", "alpha"});
  Vector alpha = factors.vector("alpha");
  Matrix X = factors.matrix("X", ngc, alpha.size());
  return FactoredInertia{std::move(X), std::move(alpha)};
}

void check_all_or_none(const JsonObject& reader, const std::array<std::string_view, 3>& fields) {
  const auto given = [&](std::string_view field) { return reader.given(field); };
  const auto present = std::find_if(fields.begin(), fields.end(), given);
  const auto absent = std::find_if_not(fields.begin(), fields.end(), given);
  if (present == fields.end() || absent == fields.end()) return;
  reader.fail(*absent, ": missing; it belongs to " + std::string(*present));
}

void read_friction(const JsonObject& reader, ContactProblem& problem) {
  problem.edges = reader.integers("edges");
  problem.mu = reader.vector("mu");
  Index columns = 0;
  for (std::size_t i = 0; i < problem.edges.size(); ++i) {
    const int edges = problem.edges[i];
    // check_contact() tests this as well, but the sum gives the width of D: reading D would fail first, with a message
    // that does not name the wrong entry.
    if (edges < 0 || edges % 2 != 0) {
      reader.fail(entry_name("edges", i), " is " + std::to_string(edges) + ", expected an even number >= 0");
    }
    columns += edges;
  }
  if (columns > static_cast<Index>(kMaxNumbers)) {  // if D has no rows, its data do not limit its width
    reader.fail("edges", ": more than " + std::to_string(kMaxNumbers) + " friction directions");
  }
  problem.D = read_jacobian(reader, "D", problem.ngc(), columns);
}

std::array<std::pair<const char*, Vector*>, 4> optional_vectors(ContactProblem& problem) {
  return {{{"b", &problem.b},
           {"compliance_n", &problem.compliance_n},
           {"compliance_t", &problem.compliance_t},
           {"offset_t", &problem.offset_t}}};
}

/// Rows of friction have the bounds of friction alone; of others a lower bound that is not given is 0.
LcpBounds read_bounds(const JsonObject& reader, Index n) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  LcpBounds bounds = LcpBounds::nonnegative(n);
  if (reader.given("friction_of")) {
    bounds.friction_of = reader.integers("friction_of", reader.vector_with_nulls("friction_of", n, -1));
    const Vector mu = reader.vector_with_nulls("mu", n, -1);
    for (Index i = 0; i < n; ++i) {
      const bool friction = bounds.friction_of[static_cast<std::size_t>(i)] >= 0;
      if (friction) bounds.mu(i) = mu(i);
      if (friction) bounds.lower(i) = -kNone;
    }
  } else if (reader.given("mu")) {
    reader.fail("friction_of", ": missing; it belongs to mu");
  }
  for (const auto& [field, values, none] :
       {std::tuple{"lower", &bounds.lower, -kNone}, std::tuple{"upper", &bounds.upper, kNone}}) {
    if (reader.given(field)) *values = reader.vector_with_nulls(field, n, none);
  }
  return bounds;
}

/// For each row whether it is "rad"; of the rows that have no unit none is.
std::vector<char> read_units(const JsonObject& reader, Index count) {
  std::vector<char> is_angle(static_cast<std::size_t>(count), 0);
  if (!reader.given("unit")) return is_angle;
  is_angle.clear();
  for (const std::string& unit : reader.texts("unit")) {
    if (unit != "m" && unit != "rad") {
      reader.fail(entry_name("unit", is_angle.size()), ": " + in_quotes(unit) + ", expected 'm' or 'rad'");
    }
    is_angle.push_back(unit == "rad" ? 1 : 0);
  }
  return is_angle;
}

BoundedRows read_rows(const JsonObject& reader, Index ngc) {
  reader.only({"R", "b", "compliance", "lower", "upper", "friction_of", "mu", "unit", "names"});
  for (const char* field : {"R", "lower", "upper"}) reader.value(field);
  BoundedRows rows;
  const Index of_lower = static_cast<Index>(reader.value("lower").size());
  const Index count = jacobian_columns(reader, "R").value_or(of_lower);
  rows.R = read_jacobian(reader, "R", ngc, count);
  rows.bounds = read_bounds(reader, count);
  rows.bounds.drop_huge();
  if (reader.given("b")) rows.b = reader.vector("b");
  if (reader.given("compliance")) rows.compliance = reader.vector("compliance");
  rows.is_angle = read_units(reader, count);
  if (reader.given("names")) rows.names = reader.texts("names");
  return rows;
}

ContactProblem read_contact(const JsonObject& reader, const std::string& origin) {
  check_all_or_none(reader, {"D", "edges", "mu"});
  ContactProblem problem;
  problem.v = reader.vector("v");
  if (reader.given("D")) {
    read_friction(reader, problem);
    problem.N = read_jacobian(reader, "N", problem.ngc(), problem.nc());
  } else {
    const Index nc = jacobian_columns(reader, "N").value_or(0);
    problem.N = read_jacobian(reader, "N", problem.ngc(), nc);
    problem.D = Matrix(problem.ngc(), 0);
    problem.edges.assign(static_cast<std::size_t>(nc), 0);
    problem.mu = Vector::Zero(nc);
  }
  problem.inertia = read_inertia(reader, problem.ngc());
  for (const auto& [field, values] : optional_vectors(problem)) {
    if (reader.given(field)) *values = reader.vector(field);
  }
  if (reader.given("rows")) problem.rows = read_rows(reader.inside("rows"), problem.ngc());
  check_contact(problem, origin);
  // Vectors of zeros have no effect; without them has_offset() and is_soft() are false.
  for (const auto& [field, values] : optional_vectors(problem)) {
    if (values->isZero(0)) values->resize(0);
  }
  for (Vector* values : {&problem.rows.b, &problem.rows.compliance}) {
    if (values->isZero(0)) values->resize(0);
  }
  return problem;
}

Lcp read_lcp(const JsonObject& reader, const std::string& origin) {
  Lcp lcp;
  lcp.q = reader.vector("q");
  lcp.M = reader.matrix("M", lcp.size(), lcp.size());
  const auto given = [&](const char* field) { return reader.given(field); };
  constexpr std::array kBounds{"lower", "upper", "friction_of", "mu"};
  if (std::any_of(kBounds.begin(), kBounds.end(), given)) lcp.bounds = read_bounds(reader, lcp.size());
  lcp.dropped_bounds = lcp.bounds.drop_huge();
  check_lcp(lcp, origin);
  lcp.bounds.simplify();
  return lcp;
}

RigidScene read_scene(const JsonObject& reader, const std::string& origin) {
  RigidScene scene;
  for (const JsonObject& body : reader.objects("bodies")) scene.bodies.push_back(read_body(body));
  for (const JsonObject& contact : reader.objects("contacts")) scene.contacts.push_back(read_rigid_contact(contact));
  check_scene(scene, origin);
  return scene;
}

}  // namespace

Problem problem_of_json(const Json& json, const std::string& origin) {
  const JsonObject reader(json, origin);
  if (!reader.given("format")) {
    reader.fail("format", ": missing; a problem file has format, version, name and kind, and the fields of its kind");
  }
  reader.check_format("lcpbench-problem");
  const std::string& name = reader.text("name");
  const std::string& kind = reader.text("kind");
  check_name(name, origin);
  const std::string of = " of kind '" + kind + "'";
  if (kind == "lcp") {
    reader.only({"format", "version", "name", "kind", "M", "q", "lower", "upper", "friction_of", "mu"}, of);
    return Problem(name, read_lcp(reader, origin));
  }
  if (kind == "contact") {
    reader.only({"format", "version", "name", "kind", "v", "N", "D", "edges", "mu", "b", "G", "G_blocks", "G_factors",
                 "Ginv", "compliance_n", "compliance_t", "offset_t", "rows"},
                of);
    return Problem(name, read_contact(reader, origin));
  }
  if (kind == "scene") {
    reader.only({"format", "version", "name", "kind", "bodies", "contacts"}, of);
    return Problem(name, read_scene(reader, origin));
  }
  reader.fail("kind", ": " + in_quotes(kind) + ", expected 'lcp', 'contact' or 'scene'");
}

Problem parse_problem_json(std::string_view text, const std::string& origin) {
  return problem_of_json(parse_json_document(text, origin), origin);
}

}  // namespace lcpbench
