#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "core/settings.h"
#include "core/io/json_document.h"
#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"

namespace lcpbench {
namespace {

constexpr const char* kFormat = "lcpbench-problem";
constexpr double kVersion = 1;

constexpr std::array<Field, 2> kFactorFields{{{"X", FieldType::kRows}, {"alpha", FieldType::kNumbers}}};

constexpr std::array<Field, 5> kBodyFields{{{"mass", FieldType::kNumber},
                                            {"inertia", FieldType::kRows},
                                            {"position", FieldType::kNumbers},
                                            {"linear_velocity", FieldType::kNumbers},
                                            {"angular_velocity", FieldType::kNumbers}}};

constexpr std::array<Field, 8> kRigidContactFields{{{"body_a", FieldType::kNumber},
                                                    {"body_b", FieldType::kNumber},
                                                    {"point", FieldType::kNumbers},
                                                    {"normal", FieldType::kNumbers},
                                                    {"tangent", FieldType::kNumbers},
                                                    {"mu", FieldType::kNumber},
                                                    {"edges", FieldType::kNumber},
                                                    {"b", FieldType::kNumber}}};

constexpr std::array<Field, 17> kProblemFields{{{"format", FieldType::kText},
                                                {"version", FieldType::kNumber},
                                                {"name", FieldType::kText},
                                                {"kind", FieldType::kText},
                                                {"M", FieldType::kRows},
                                                {"q", FieldType::kNumbers},
                                                {"v", FieldType::kNumbers},
                                                {"N", FieldType::kRows},
                                                {"D", FieldType::kRows},
                                                {"edges", FieldType::kNumbers},
                                                {"mu", FieldType::kNumbers},
                                                {"b", FieldType::kNumbers},
                                                {"G", FieldType::kRows},
                                                {"G_factors", FieldType::kObject, kFactorFields},
                                                {"Ginv", FieldType::kRows},
                                                {"bodies", FieldType::kObjects, kBodyFields},
                                                {"contacts", FieldType::kObjects, kRigidContactFields}}};

/// Reads typed values out of one record; `path` ("contacts[2].") and the file go into every error.
class RecordReader {
 public:
  RecordReader(const Record& record, const std::string& origin, std::string path = "")
      : record_(record), origin_(origin), path_(std::move(path)) {}

  bool given(std::string_view field) const { return record_.given(field); }

  [[noreturn]] void fail(std::string_view field, const std::string& message) const {
    throw input_error(origin_, path_ + std::string(field) + message);
  }

  const std::string& text(std::string_view field) const { return required(field).text; }

  double number(std::string_view field) const { return required(field).table.numbers.front(); }

  int integer(std::string_view field) const { return to_integer(number(field), std::string(field)); }

  Vector vector(std::string_view field) const {
    const std::vector<double>& numbers = required(field).table.numbers;
    return Eigen::Map<const Vector>(numbers.data(), static_cast<Index>(numbers.size()));
  }

  std::vector<int> integers(std::string_view field) const {
    const std::vector<double>& numbers = required(field).table.numbers;
    std::vector<int> result(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      result[i] = to_integer(numbers[i], std::string(field) + "[" + std::to_string(i) + "]");
    }
    return result;
  }

  /// Columns of the first row; nullopt when there is no row to tell.
  std::optional<Index> columns(std::string_view field) const {
    const NumberTable& table = required(field).table;
    if (table.row_ends.empty()) return std::nullopt;
    return static_cast<Index>(table.row_length(0));
  }

  Matrix matrix(std::string_view field, Index rows, Index cols) const {
    const NumberTable& table = required(field).table;
    if (static_cast<Index>(table.row_ends.size()) != rows) {
      fail(field,
           ": " + count_of(static_cast<Index>(table.row_ends.size()), "row") + ", expected " + std::to_string(rows));
    }
    for (std::size_t row = 0; row < table.row_ends.size(); ++row) {
      if (static_cast<Index>(table.row_length(row)) == cols) continue;
      fail(field, ": row " + std::to_string(row) + " has " +
                      count_of(static_cast<Index>(table.row_length(row)), "entry") + ", expected " +
                      std::to_string(cols));
    }
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const RowMajor>(table.numbers.data(), rows, cols);
  }

  Eigen::Vector3d vector3(std::string_view field) const {
    const Vector numbers = vector(field);
    if (numbers.size() != 3) fail(field, ": " + count_of(numbers.size(), "entry") + ", expected 3");
    return numbers;
  }

 private:
  const Record::Value& required(std::string_view field) const {
    const Record::Value& value = record_.value(field);
    if (!value.given) fail(field, ": missing");
    return value;
  }

  int to_integer(double number, const std::string& field) const {
    const bool fits = number >= std::numeric_limits<int>::min() && number <= std::numeric_limits<int>::max();
    if (!fits || number != std::floor(number)) fail(field, " is " + format_real(number) + ", expected an integer");
    return static_cast<int>(number);
  }

  const Record& record_;
  const std::string& origin_;
  std::string path_;
};

RigidBody read_body(const RecordReader& reader) {
  RigidBody body;
  body.mass = reader.number("mass");
  body.inertia = reader.matrix("inertia", 3, 3);
  body.position = reader.vector3("position");
  body.linear_velocity = reader.vector3("linear_velocity");
  body.angular_velocity = reader.vector3("angular_velocity");
  return body;
}

/// With edges 0 or without them the contact is frictionless: a tangent would have no meaning, mu may only say 0.
RigidContact read_rigid_contact(const RecordReader& reader) {
  RigidContact contact;
  contact.body_a = reader.integer("body_a");
  contact.body_b = reader.integer("body_b");
  contact.point = reader.vector3("point");
  contact.normal = reader.vector3("normal");
  if (reader.given("edges")) contact.edges = reader.integer("edges");
  if (reader.given("mu")) contact.mu = reader.number("mu");
  if (reader.given("b")) contact.b = reader.number("b");
  if (contact.edges != 0) {
    contact.mu = reader.number("mu");
    contact.tangent = reader.vector3("tangent");
  } else if (reader.given("tangent")) {
    reader.fail("tangent", ": given, but the contact has no edges");
  }
  return contact;
}

Inertia read_inertia(const RecordReader& reader, const Record& record, const std::string& origin, Index ngc) {
  if (reader.given("G") && reader.given("G_factors")) reader.fail("G", " and G_factors: only one may be given");
  if (reader.given("Ginv")) {
    if (reader.given("G") || reader.given("G_factors")) {
      reader.fail("Ginv", ": given beside G or G_factors; it may only replace them");
    }
    return InverseInertia{reader.matrix("Ginv", ngc, ngc)};
  }
  if (reader.given("G_factors")) {
    const RecordReader factors(record.value("G_factors").object.front(), origin, "G_factors.");
    Vector alpha = factors.vector("alpha");
    Matrix X = factors.matrix("X", ngc, alpha.size());
    return FactoredInertia{std::move(X), std::move(alpha)};
  }
  if (!reader.given("G")) reader.fail("G", ": missing (or G_factors, or Ginv)");
  return DenseInertia{reader.matrix("G", ngc, ngc)};
}

void check_all_or_none(const RecordReader& reader, std::span<const std::string_view> fields) {
  const auto given = [&](std::string_view field) { return reader.given(field); };
  const auto present = std::find_if(fields.begin(), fields.end(), given);
  const auto absent = std::find_if_not(fields.begin(), fields.end(), given);
  if (present == fields.end() || absent == fields.end()) return;
  reader.fail(*absent, ": missing; it belongs to " + std::string(*present));
}

void read_friction(const RecordReader& reader, ContactProblem& problem) {
  problem.edges = reader.integers("edges");
  problem.mu = reader.vector("mu");
  Index columns = 0;
  for (std::size_t i = 0; i < problem.edges.size(); ++i) {
    const int edges = problem.edges[i];
    // Before the sum becomes the expected width of D: a negative number there would only confuse.
    if (edges < 0 || edges % 2 != 0) {
      reader.fail("edges",
                  "[" + std::to_string(i) + "] is " + std::to_string(edges) + ", expected an even number >= 0");
    }
    columns += edges;
  }
  problem.D = reader.matrix("D", problem.ngc(), columns);
}

ContactProblem read_contact(const Record& record, const std::string& origin) {
  const RecordReader reader(record, origin);
  constexpr std::array<std::string_view, 3> kFriction{"D", "edges", "mu"};
  check_all_or_none(reader, kFriction);
  ContactProblem problem;
  problem.v = reader.vector("v");
  if (reader.given("D")) {
    read_friction(reader, problem);
    problem.N = reader.matrix("N", problem.ngc(), problem.nc());
  } else {
    const Index nc = reader.columns("N").value_or(0);
    problem.N = reader.matrix("N", problem.ngc(), nc);
    problem.D = Matrix(problem.ngc(), 0);
    problem.edges.assign(static_cast<std::size_t>(nc), 0);
    problem.mu = Vector::Zero(nc);
  }
  problem.inertia = read_inertia(reader, record, origin, problem.ngc());
  if (reader.given("b")) problem.b = reader.vector("b");
  check_contact(problem, origin);
  if (problem.b.isZero(0)) problem.b.resize(0);
  return problem;
}

Lcp read_lcp(const Record& record, const std::string& origin) {
  const RecordReader reader(record, origin);
  Lcp lcp;
  lcp.q = reader.vector("q");
  lcp.M = reader.matrix("M", lcp.size(), lcp.size());
  check_lcp(lcp, origin);
  return lcp;
}

void check_header(std::string_view field, const Record::Value& value, const std::string& origin) {
  if (field == "format" && value.text != kFormat) {
    throw input_error(origin, "format: " + in_quotes(value.text) + ", expected '" + kFormat + "'");
  }
  if (field == "version" && value.table.numbers.front() != kVersion) {
    throw input_error(
        origin, "version: " + format_real(value.table.numbers.front()) + " is not known; this program reads version 1");
  }
}

void check_only(const Record& record, std::span<const std::string_view> allowed, const std::string& kind,
                const std::string& origin) {
  constexpr std::array<std::string_view, 4> kHeader{"format", "version", "name", "kind"};
  const auto listed = [](std::span<const std::string_view> names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const Field& field : record.fields()) {
    if (!record.given(field.name) || listed(kHeader, field.name) || listed(allowed, field.name)) continue;
    throw input_error(origin, std::string(field.name) + ": not a field of kind '" + kind + "'");
  }
}

}  // namespace

Problem parse_problem_json(std::string_view text, const std::string& origin) {
  RigidScene scene;
  DocumentEvents events;
  events.scalar = [&](std::string_view field, const Record::Value& value) { check_header(field, value, origin); };
  events.item = [&](std::string_view list, std::size_t index, const Record& item) {
    const RecordReader reader(item, origin, std::string(list) + "[" + std::to_string(index) + "].");
    if (list == "bodies") {
      scene.bodies.push_back(read_body(reader));
    } else {
      scene.contacts.push_back(read_rigid_contact(reader));
    }
  };
  const Record record = parse_json_document(text, origin, kProblemFields, events);

  const RecordReader reader(record, origin);
  reader.text("format");
  reader.number("version");
  const std::string& name = reader.text("name");
  const std::string& kind = reader.text("kind");
  check_name(name, origin);
  if (kind == "lcp") {
    constexpr std::array<std::string_view, 2> kAllowed{"M", "q"};
    check_only(record, kAllowed, kind, origin);
    return Problem(name, read_lcp(record, origin));
  }
  if (kind == "contact") {
    constexpr std::array<std::string_view, 9> kAllowed{"v", "N", "D", "edges", "mu", "b", "G", "G_factors", "Ginv"};
    check_only(record, kAllowed, kind, origin);
    return Problem(name, read_contact(record, origin));
  }
  if (kind == "scene") {
    constexpr std::array<std::string_view, 2> kAllowed{"bodies", "contacts"};
    check_only(record, kAllowed, kind, origin);
    for (const std::string_view list : kAllowed) {
      if (!record.given(list)) reader.fail(list, ": missing");
    }
    check_scene(scene, origin);
    return Problem(name, std::move(scene));
  }
  throw input_error(origin, "kind: " + in_quotes(kind) + ", expected 'lcp', 'contact' or 'scene'");
}

}  // namespace lcpbench
