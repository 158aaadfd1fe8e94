#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <span>

#include "core/io/json_document.h"
#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"
#include "core/io/problem_record.h"
#include "core/io/record_reader.h"
#include "core/settings.h"

namespace lcpbench {
namespace {

constexpr const char* kFormat = "lcpbench-problem";
constexpr double kVersion = 1;

constexpr std::array<Field, 3> kSparseFields{
    {{"starts", FieldType::kNumbers}, {"rows", FieldType::kNumbers}, {"values", FieldType::kNumbers}}};

constexpr std::array<Field, 2> kFactorFields{{{"X", FieldType::kRows}, {"alpha", FieldType::kNumbers}}};

constexpr std::array<Field, 5> kBodyFields{{{"mass", FieldType::kNumber},
                                            {"inertia", FieldType::kRows},
                                            {"position", FieldType::kNumbers},
                                            {"linear_velocity", FieldType::kNumbers},
                                            {"angular_velocity", FieldType::kNumbers}}};

constexpr std::array<Field, 11> kRigidContactFields{{{"body_a", FieldType::kNumber},
                                                    {"body_b", FieldType::kNumber},
                                                    {"point", FieldType::kNumbers},
                                                    {"normal", FieldType::kNumbers},
                                                    {"tangent", FieldType::kNumbers},
                                                    {"mu", FieldType::kNumber},
                                                    {"edges", FieldType::kNumber},
                                                    {"b", FieldType::kNumber},
                                                    {"compliance_n", FieldType::kNumber},
                                                    {"compliance_t", FieldType::kNumber},
                                                    {"offset_t", FieldType::kNumbers}}};

constexpr std::array<Field, 21> kProblemFields{{{"format", FieldType::kText},
                                                {"version", FieldType::kNumber},
                                                {"name", FieldType::kText},
                                                {"kind", FieldType::kText},
                                                {"M", FieldType::kRows},
                                                {"q", FieldType::kNumbers},
                                                {"v", FieldType::kNumbers},
                                                {"N", FieldType::kRows, kSparseFields},
                                                {"D", FieldType::kRows, kSparseFields},
                                                {"edges", FieldType::kNumbers},
                                                {"mu", FieldType::kNumbers},
                                                {"b", FieldType::kNumbers},
                                                {"compliance_n", FieldType::kNumbers},
                                                {"compliance_t", FieldType::kNumbers},
                                                {"offset_t", FieldType::kNumbers},
                                                {"G", FieldType::kRows},
                                                {"G_blocks", FieldType::kBlocks},
                                                {"G_factors", FieldType::kObject, kFactorFields},
                                                {"Ginv", FieldType::kRows},
                                                {"bodies", FieldType::kObjects, kBodyFields},
                                                {"contacts", FieldType::kObjects, kRigidContactFields}}};

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
  if (reader.given("compliance_n")) contact.compliance_n = reader.number("compliance_n");
  if (reader.given("compliance_t")) contact.compliance_t = reader.number("compliance_t");
  if (reader.given("offset_t")) contact.offset_t = reader.vector2("offset_t");
  if (contact.edges != 0) {
    contact.mu = reader.number("mu");
    contact.tangent = reader.vector3("tangent");
  } else if (reader.given("tangent")) {
    reader.fail("tangent", ": given, but the contact has no edges");
  }
  return contact;
}

/// Columns of N or D one after the other: column i has the entries starts[i] to starts[i + 1] of rows and values.
SparseMatrix read_sparse(const RecordReader& reader, Index rows, Index cols) {
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
      const std::string entry = "[" + std::to_string(k) + "] is " + std::to_string(row[k]);
      if (row[k] < 0 || row[k] >= rows) {
        reader.fail("rows", entry + ", expected 0 to " + std::to_string(rows - 1));
      }
      Index& last = column_of_row[static_cast<std::size_t>(row[k])];
      if (last == column) reader.fail("rows", entry + " for the second time in column " + std::to_string(column));
      last = column;
      entries.emplace_back(row[k], column, values(static_cast<Index>(k)));
    }
  }
  SparseMatrix matrix(rows, cols);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// The columns of N or D; nullopt where there is no row to tell.
std::optional<Index> jacobian_columns(const RecordReader& reader, std::string_view field) {
  if (!reader.has_object(field)) return reader.columns(field);
  return static_cast<Index>(std::max<std::size_t>(reader.inside(field).integers("starts").size(), 1)) - 1;
}

Jacobian read_jacobian(const RecordReader& reader, std::string_view field, Index rows, Index cols) {
  if (!reader.has_object(field)) return reader.matrix(field, rows, cols);
  return read_sparse(reader.inside(field), rows, cols);
}

BlockInertia read_blocks(const RecordReader& reader) {
  const NumberTable& table = reader.table("G_blocks");
  BlockInertia inertia;
  std::size_t row = 0;
  for (const std::size_t end : table.block_ends) {
    const std::size_t order = end - row;
    const std::string block = "[" + std::to_string(inertia.blocks.size()) + "]";
    if (order == 0) reader.fail("G_blocks", block + ": empty");
    Matrix G(static_cast<Index>(order), static_cast<Index>(order));
    for (std::size_t i = 0; i < order; ++i, ++row) {
      if (table.row_length(row) != order) {
        reader.fail("G_blocks", block + ": row " + std::to_string(i) + " has " +
                                    count_of(static_cast<Index>(table.row_length(row)), "entry") + ", expected " +
                                    std::to_string(order));
      }
      const double* numbers = table.numbers.data() + (table.row_ends[row] - order);
      G.row(static_cast<Index>(i)) = Eigen::Map<const Eigen::RowVectorXd>(numbers, static_cast<Index>(order));
    }
    inertia.blocks.push_back(std::move(G));
  }
  return inertia;
}

Inertia read_inertia(const RecordReader& reader, Index ngc) {
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
  if (form == "G_blocks") return read_blocks(reader);
  if (form == "G") return DenseInertia{reader.matrix("G", ngc, ngc)};
  const RecordReader factors = reader.inside("G_factors");
  Vector alpha = factors.vector("alpha");
  Matrix X = factors.matrix("X", ngc, alpha.size());
  return FactoredInertia{std::move(X), std::move(alpha)};
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
    // Checked before the sum of edges becomes the expected width of D, so that the message names the wrong number.
    if (edges < 0 || edges % 2 != 0) {
      reader.fail("edges",
                  "[" + std::to_string(i) + "] is " + std::to_string(edges) + ", expected an even number >= 0");
    }
    columns += edges;
  }
  problem.D = read_jacobian(reader, "D", problem.ngc(), columns);
}

/// Where at least `enough` matrices are given by rows and agree, a vector of another length is the mistake.
void check_length(const RecordReader& reader, std::string_view vector, Index length,
                  std::initializer_list<std::string_view> matrices, int enough) {
  std::optional<Index> rows;
  std::string witnesses;
  int count = 0;
  for (const std::string_view field : matrices) {
    if (!reader.given(field) || (reader.has_object(field) && field != "G_factors")) continue;
    const bool factors = field == "G_factors";
    if (factors && !reader.inside(field).given("X")) continue;
    const NumberTable& table = factors ? reader.inside(field).table("X") : reader.table(field);
    const auto own = static_cast<Index>(table.row_ends.size());
    if (rows.value_or(own) != own) return;
    rows = own;
    ++count;
    witnesses += (witnesses.empty() ? "" : ", ") + std::string(factors ? "G_factors.X" : field);
  }
  if (count < enough || *rows == length) return;
  reader.fail(vector, ": " + count_of(length, "entry") + ", expected " + std::to_string(*rows) + ", the rows of " +
                          witnesses);
}

std::array<std::pair<const char*, Vector*>, 4> optional_vectors(ContactProblem& problem) {
  return {{{"b", &problem.b},
           {"compliance_n", &problem.compliance_n},
           {"compliance_t", &problem.compliance_t},
           {"offset_t", &problem.offset_t}}};
}

ContactProblem read_contact(const Record& record, const std::string& origin) {
  const RecordReader reader(record, origin);
  constexpr std::array<std::string_view, 3> kFriction{"D", "edges", "mu"};
  check_all_or_none(reader, kFriction);
  ContactProblem problem;
  problem.v = reader.vector("v");
  check_length(reader, "v", problem.ngc(), {"N", "D", "G", "G_blocks", "G_factors", "Ginv"}, 2);
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
  check_contact(problem, origin);
  for (const auto& [field, values] : optional_vectors(problem)) {
    if (values->isZero(0)) values->resize(0);
  }
  return problem;
}

Lcp read_lcp(const Record& record, const std::string& origin) {
  const RecordReader reader(record, origin);
  Lcp lcp;
  lcp.q = reader.vector("q");
  if (reader.given("M") && reader.columns("M") == static_cast<Index>(reader.table("M").row_ends.size())) {
    check_length(reader, "q", lcp.size(), {"M"}, 1);  // M is square
  }
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

std::span<const Field> problem_fields() { return kProblemFields; }

void ProblemParts::add(std::string_view list, const std::string& path, const Record& item, const std::string& origin) {
  const RecordReader reader(item, origin, path);
  if (list == "bodies") {
    scene_.bodies.push_back(read_body(reader));
  } else {
    scene_.contacts.push_back(read_rigid_contact(reader));
  }
}

Problem ProblemParts::finish(const Record& record, const std::string& origin) {
  const RecordReader reader(record, origin);
  if (!record.given("format")) {
    reader.fail("format", ": missing; a problem file has format, version, name and kind, and the fields of its kind");
  }
  reader.text("format");
  reader.number("version");
  for (const std::string_view field : {"format", "version"}) check_header(field, record.value(field), origin);
  const std::string& name = reader.text("name");
  const std::string& kind = reader.text("kind");
  check_name(name, origin);
  if (kind == "lcp") {
    constexpr std::array<std::string_view, 2> kAllowed{"M", "q"};
    check_only(record, kAllowed, kind, origin);
    return Problem(name, read_lcp(record, origin));
  }
  if (kind == "contact") {
    constexpr std::array<std::string_view, 13> kAllowed{"v",  "N", "D",        "edges",     "mu",
                                                        "b",  "G", "G_blocks", "G_factors", "Ginv",
                                                        "compliance_n", "compliance_t", "offset_t"};
    check_only(record, kAllowed, kind, origin);
    return Problem(name, read_contact(record, origin));
  }
  if (kind == "scene") {
    constexpr std::array<std::string_view, 2> kAllowed{"bodies", "contacts"};
    check_only(record, kAllowed, kind, origin);
    for (const std::string_view list : kAllowed) {
      if (!record.given(list)) reader.fail(list, ": missing");
    }
    check_scene(scene_, origin);
    return Problem(name, std::move(scene_));
  }
  throw input_error(origin, "kind: " + in_quotes(kind) + ", expected 'lcp', 'contact' or 'scene'");
}

Problem parse_problem_json(std::string_view text, const std::string& origin) {
  ProblemParts parts;
  DocumentEvents events;
  events.scalar = [&](std::string_view field, const Record::Value& value) { check_header(field, value, origin); };
  events.item = [&](std::string_view list, const std::string& path, const Record& item) {
    parts.add(list, path, item, origin);
  };
  const Record record = parse_json_document(text, origin, kProblemFields, events);
  return parts.finish(record, origin);
}

}  // namespace lcpbench
