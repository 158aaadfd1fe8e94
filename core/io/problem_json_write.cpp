#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "core/io/json_document.h"
#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"
#include "core/settings.h"

namespace lcpbench {
namespace {

/// Writes a document. Each number, which has to be finite, has the shortest digits that read back to the same double.
class Printer {
 public:
  /// @param readable  fields and rows on lines of their own; else all on one line, without white space
  Printer(bool readable, std::string& out) : readable_(readable), out_(out) {}

  /// Values printed so far: numbers, texts, lists (such as rows) and objects.
  std::size_t count() const { return count_; }

  /// @param line_break  starts a line at the depth of `json`: "\n" and its indentation; empty: all stays on one line
  void print(const Json& json, const std::string& line_break = "\n") {
    ++count_;
    if (json.is_number()) return number(json.get<double>());
    if (!json.is_structured()) {
      out_ += json.dump();
      return;
    }
    // An object in a list stands on one line, with all that it holds; and so does a list of numbers.
    const bool spread =
        readable_ && !line_break.empty() && (json.is_object() || (!json.empty() && json[0].is_structured()));
    const std::string inner = spread ? line_break + "  " : "";
    const char* const comma = readable_ && !spread ? ", " : ",";
    auto start_item = [&, first = true]() mutable {
      if (!std::exchange(first, false)) out_ += comma;
      out_ += inner;
    };
    out_ += json.is_object() ? '{' : '[';
    if (json.is_object()) {
      for (const auto& [name, value] : json.items()) {
        start_item();
        out_ += Json(name).dump() + (readable_ ? ": " : ":");
        print(value, inner);
      }
    } else {
      for (const Json& item : json) {
        start_item();
        print(item, item.is_object() ? "" : inner);
      }
    }
    if (spread) out_ += line_break;
    out_ += json.is_object() ? '}' : ']';
  }

 private:
  void number(double value) {
    std::array<char, 32> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    out_.append(digits.data(), end);
    // "-0" is an integer to many JSON readers, and integers have no negative zero.
    if (value == 0 && std::signbit(value)) out_ += ".0";
  }

  bool readable_;
  std::string& out_;
  std::size_t count_ = 0;
};

template <class Numbers>
Json list(const Numbers& numbers) {
  Json result = Json::array();
  for (decltype(numbers.size()) i = 0; i < numbers.size(); ++i) result.push_back(static_cast<double>(numbers[i]));
  return result;
}

Json list_of_rows(const Matrix& matrix) {
  Json result = Json::array();
  for (Index row = 0; row < matrix.rows(); ++row) result.push_back(list(matrix.row(row)));
  return result;
}

/// @param sparse  sparse matrices and blocks as they are stored
Json jacobian(const Jacobian& J, bool sparse) {
  const auto* matrix = std::get_if<SparseMatrix>(&J);
  if (!sparse || matrix == nullptr) return list_of_rows(to_dense(J));
  std::vector<Index> starts{0};
  std::vector<Index> row;
  std::vector<double> values;
  for (Index column = 0; column < matrix->outerSize(); ++column) {
    for (SparseMatrix::InnerIterator it(*matrix, column); it; ++it) {
      row.push_back(it.row());
      values.push_back(it.value());
    }
    starts.push_back(static_cast<Index>(row.size()));
  }
  return {{"starts", list(starts)}, {"rows", list(row)}, {"values", list(values)}};
}

void add_inertia(const Inertia& inertia, bool sparse, Json& json) {
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    json["G_factors"] = {{"X", list_of_rows(factors->X)}, {"alpha", list(factors->alpha)}};
  } else if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) {
    json["Ginv"] = list_of_rows(inverse->Ginv);
  } else if (const auto* separate = std::get_if<BlockInertia>(&inertia); separate != nullptr && sparse) {
    Json& blocks = json["G_blocks"] = Json::array();
    for (const Matrix& block : separate->blocks) blocks.push_back(list_of_rows(block));
  } else {
    json["G"] = list_of_rows(dense_inertia(inertia));
  }
}

void add_optional(const char* name, const Vector& values, Json& json) {
  if (!values.isZero(0)) json[name] = list(values);
}

void add_optional(const char* name, double value, Json& json) {
  if (value != 0) json[name] = value;
}

template <class Numbers>
Json list_with_nulls(const Numbers& numbers, double none) {
  Json result = list(numbers);
  for (Json& each : result) {
    if (each == none) each = nullptr;
  }
  return result;
}

void add_bounds(const LcpBounds& bounds, Json& json) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  json["lower"] = list_with_nulls(bounds.lower, -kNone);
  json["upper"] = list_with_nulls(bounds.upper, kNone);
  if (std::all_of(bounds.friction_of.begin(), bounds.friction_of.end(), [](int of) { return of < 0; })) return;
  json["friction_of"] = list_with_nulls(bounds.friction_of, -1);
  json["mu"] = list(bounds.mu);
  for (std::size_t i = 0; i < bounds.friction_of.size(); ++i) {
    if (bounds.friction_of[i] < 0) json["mu"][i] = nullptr;
  }
}

Json bounded_rows(const BoundedRows& rows, bool sparse) {
  Json json = {{"R", jacobian(rows.R, sparse)}};
  add_bounds(rows.bounds, json);
  add_optional("b", rows.b, json);
  add_optional("compliance", rows.compliance, json);
  if (std::ranges::any_of(rows.is_angle, [](char angle) { return angle != 0; })) {
    for (const char angle : rows.is_angle) json["unit"].push_back(angle != 0 ? "rad" : "m");
  }
  if (!rows.names.empty()) json["names"] = rows.names;
  return json;
}

void add_contact(const ContactProblem& problem, bool sparse, Json& json) {
  json["v"] = list(problem.v);
  json["N"] = jacobian(problem.N, sparse);
  // Without a row in N nothing else would tell the number of contacts.
  if (problem.frictional() || (problem.ngc() == 0 && problem.nc() > 0)) {
    json["D"] = jacobian(problem.D, sparse);
    json["edges"] = list(problem.edges);
    json["mu"] = list(problem.mu);
  }
  add_optional("b", problem.b, json);
  add_optional("compliance_n", problem.compliance_n, json);
  add_optional("compliance_t", problem.compliance_t, json);
  add_optional("offset_t", problem.offset_t, json);
  add_inertia(problem.inertia, sparse, json);
  if (problem.has_rows()) json["rows"] = bounded_rows(problem.rows, sparse);
}

Json body(const RigidBody& body) {
  return {{"mass", body.mass},
          {"inertia", list_of_rows(body.inertia)},
          {"position", list(body.position)},
          {"linear_velocity", list(body.linear_velocity)},
          {"angular_velocity", list(body.angular_velocity)}};
}

Json rigid_contact(const RigidContact& contact) {
  Json json = {{"body_a", contact.body_a},
               {"body_b", contact.body_b},
               {"point", list(contact.point)},
               {"normal", list(contact.normal)}};
  if (contact.edges != 0) {
    json["tangent"] = list(contact.tangent);
    json["mu"] = contact.mu;
    json["edges"] = contact.edges;
  }
  add_optional("b", contact.b, json);
  add_optional("compliance_n", contact.compliance_n, json);
  add_optional("compliance_t", contact.compliance_t, json);
  add_optional("offset_t", Vector(contact.offset_t), json);
  return json;
}

void add_scene(const RigidScene& scene, Json& json) {
  Json& bodies = json["bodies"] = Json::array();
  for (const RigidBody& each : scene.bodies) bodies.push_back(body(each));
  Json& contacts = json["contacts"] = Json::array();
  for (const RigidContact& each : scene.contacts) contacts.push_back(rigid_contact(each));
}

/// A lower bound of the numbers and rows in the file with dense matrices. In double, in which it cannot overflow.
double numbers_if_dense(const Problem& problem) {
  const auto n = static_cast<double>(problem.size());
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr) return n * (n + 1);
  const auto* factors = std::get_if<FactoredInertia>(&contact->inertia);
  const Index of_inertia = factors != nullptr ? factors->X.cols() : contact->ngc();
  const auto columns = static_cast<double>(cols(contact->N) + cols(contact->D) + cols(contact->rows.R) + of_inertia);
  return static_cast<double>(contact->ngc()) * (columns + 3);  // v stands for the rows of a D that is left out
}

/// What the reader would refuse is not written.
void check_numbers(double numbers, const std::string& origin) {
  if (numbers <= static_cast<double>(kMaxNumbers)) return;
  throw input_error(origin, "too large for a problem file: " + format_real(numbers) + " numbers, at most " +
                                std::to_string(kMaxNumbers) + " are allowed");
}

/// A file with dense matrices is easier to read, and up to about a megabyte it does not matter that it is larger.
constexpr double kMaxReadableNumbers = 1 << 16;

enum class Sparse { kNever, kLarge, kAlways };

/// @param readable  as the file of a person; else one line
std::string text_of(const Problem& problem, Sparse form, bool readable) {
  const std::string origin = problem.name().empty() ? "unnamed problem" : problem.name();
  check_name(problem.name(), origin);
  Json json = {{"format", "lcpbench-problem"},
               {"version", 1},
               {"name", problem.name()},
               {"kind", to_string(problem.kind())}};
  if (problem.kind() == ProblemKind::kScene) {
    check_scene(*problem.scene(), origin);
    add_scene(*problem.scene(), json);
  } else if (problem.kind() == ProblemKind::kContact) {
    const ContactProblem& contact = *problem.contact();
    const double if_dense = numbers_if_dense(problem);
    const bool sparse = form == Sparse::kAlways || (form == Sparse::kLarge && if_dense > kMaxReadableNumbers);
    if (!sparse) check_numbers(if_dense, origin);
    check_contact(contact, origin);
    add_contact(contact, sparse, json);
  } else {
    check_numbers(numbers_if_dense(problem), origin);
    check_lcp(problem.lcp(), origin);
    json["M"] = list_of_rows(problem.lcp().M);
    json["q"] = list(problem.lcp().q);
    if (problem.lcp().is_mixed()) add_bounds(problem.lcp().bounds, json);
  }
  std::string text;
  Printer printer(readable, text);
  printer.print(json);
  check_numbers(static_cast<double>(printer.count()), origin);
  return text;
}

}  // namespace

std::string problem_json(const Problem& problem) { return text_of(problem, Sparse::kLarge, true) + "\n"; }

std::string problem_json_line(const Problem& problem, bool dense) {
  return text_of(problem, dense ? Sparse::kNever : Sparse::kAlways, false);
}

}  // namespace lcpbench
