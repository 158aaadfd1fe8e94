#include "adapters/external/external_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/error.h"

namespace lcpbench::external {
namespace {

using Json = nlohmann::ordered_json;

/// By how much an answer to a multiple may differ from the multiple of the answer, relative to its largest entry: more
/// than rounding and usual tolerances make, less than any multiple.
constexpr double kSameAnswer = 1e-6;
/// A number, its separator and some white space.
constexpr std::size_t kBytesPerNumber = 64;
constexpr std::size_t kBytesBesides = 1 << 16;

template <class Numbers>
Json list(const Numbers& numbers) {
  Json array = Json::array();
  for (Index i = 0; i < numbers.size(); ++i) array.push_back(numbers(i));
  return array;
}

Json rows_of(const Matrix& matrix) {
  Json array = Json::array();
  for (Index i = 0; i < matrix.rows(); ++i) array.push_back(list(matrix.row(i)));
  return array;
}

struct AddInertia {
  Json& json;
  void operator()(const DenseInertia& inertia) const { json["G"] = rows_of(inertia.G); }
  void operator()(const BlockInertia& inertia) const { json["G"] = rows_of(dense_inertia(inertia)); }
  void operator()(const FactoredInertia& inertia) const {
    json["G_factors"] = {{"X", rows_of(inertia.X)}, {"alpha", list(inertia.alpha)}};
  }
  void operator()(const InverseInertia& inertia) const { json["Ginv"] = rows_of(inertia.Ginv); }
};

void add_contact(const ContactProblem& contact, double of_vector, Json& json) {
  json["v"] = list(of_vector * contact.v);
  json["N"] = rows_of(to_dense(contact.N));
  if (contact.frictional() || (contact.ngc() == 0 && contact.nc() > 0)) {
    json["D"] = rows_of(to_dense(contact.D));
    json["edges"] = contact.edges;
    json["mu"] = list(contact.mu);
  }
  if (!contact.b.isZero(0)) json["b"] = list(of_vector * contact.b);
  std::visit(AddInertia{json}, contact.inertia);
}

Json body_json(const RigidBody& body, double of_vector) {
  return {{"mass", body.mass},
          {"inertia", rows_of(body.inertia)},
          {"position", list(body.position)},
          {"linear_velocity", list(of_vector * body.linear_velocity)},
          {"angular_velocity", list(of_vector * body.angular_velocity)}};
}

Json contact_json(const RigidContact& contact, double of_vector) {
  Json json = {{"body_a", contact.body_a},
               {"body_b", contact.body_b},
               {"point", list(contact.point)},
               {"normal", list(contact.normal)}};
  if (contact.edges != 0) {
    json["tangent"] = list(contact.tangent);
    json["mu"] = contact.mu;
    json["edges"] = contact.edges;
  }
  if (contact.b != 0) json["b"] = of_vector * contact.b;
  return json;
}

void add_scene(const RigidScene& scene, double of_vector, Json& json) {
  json["bodies"] = Json::array();
  for (const RigidBody& body : scene.bodies) json["bodies"].push_back(body_json(body, of_vector));
  json["contacts"] = Json::array();
  for (const RigidContact& contact : scene.contacts) {
    json["contacts"].push_back(contact_json(contact, of_vector));
  }
}

Json parse_object(const std::string& text) {
  std::set<std::string> fields;
  std::string twice;
  const auto look = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (event != Json::parse_event_t::key || depth != 1) return true;
    const auto field = parsed.get<std::string>();
    if (!fields.insert(field).second && twice.empty()) twice = field;
    return true;
  };
  const Json json = Json::parse(text, look, false);
  if (!twice.empty()) throw BadAnswer(twice.substr(0, 40) + ": given twice");
  if (json.is_discarded()) throw BadAnswer("not JSON (NaN and Infinity are none)");
  if (!json.is_object()) throw BadAnswer(std::string("expected an object, found ") + json.type_name());
  return json;
}

Vector parse_vector(const Json& json, const char* field, Index expected) {
  if (!json.is_array()) throw BadAnswer(std::string(field) + ": expected a list, found " + json.type_name());
  if (static_cast<Index>(json.size()) != expected) {
    throw BadAnswer(std::string(field) + ": has " + std::to_string(json.size()) + " entries, expected " +
                    std::to_string(expected));
  }
  Vector values(expected);
  for (Index i = 0; i < expected; ++i) {
    const Json& entry = json[static_cast<std::size_t>(i)];
    const double value = entry.is_number() ? entry.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(value)) throw BadAnswer(std::string(field) + "[" + std::to_string(i) + "]: not a number");
    values(i) = value;
  }
  return values;
}

std::string parse_text(const Json& json, const char* field) {
  if (!json.is_string()) throw BadAnswer(std::string(field) + ": expected a text, found " + json.type_name());
  return json.get<std::string>();
}

std::int64_t parse_counter(const Json& json, const char* field) {
  const bool fits = json.is_number_unsigned() && json.get<std::uint64_t>() <= std::uint64_t{1} << 53;
  if (!fits) throw BadAnswer(std::string(field) + ": expected an integer in [0, 2^53]");
  return json.get<std::int64_t>();
}

/// The line may be late, or sent twice: then it answers another question. @throws BadAnswer
void check_sequence(const Json& json, const Expected& expected) {
  const auto found = json.find("sequence");
  if (found == json.end()) return;
  if (!found->is_number()) throw BadAnswer(std::string("sequence: expected a number, found ") + found->type_name());
  if (found->get<double>() == static_cast<double>(expected.sequence)) return;
  throw BadAnswer("sequence is " + found->dump() + ", but the question has " + std::to_string(expected.sequence) +
                  ": a line that came late or twice");
}

/// Apart from check_sequence(), so that an answer without a number is told first what else is wrong with it.
void require_sequence(const Json& json, const Expected& expected) {
  if (!expected.required || json.contains("sequence")) return;
  throw BadAnswer("sequence is missing: a program that repeats the number of \"start\" repeats every one");
}

bool scales_exactly(double value, double factor) {
  const double scaled = value * factor;
  return std::isfinite(scaled) && scaled / factor == value;
}

template <class Numbers>
bool all_scale_exactly(const Numbers& numbers, double factor) {
  for (Index column = 0; column < numbers.cols(); ++column) {
    for (Index row = 0; row < numbers.rows(); ++row) {
      if (!scales_exactly(numbers(row, column), factor)) return false;
    }
  }
  return true;
}

std::string vector_difference(const char* field, const Vector& first, const Vector& again, double factor) {
  if (first.size() != again.size()) return std::string(field) + " is given once and not again";
  if (first.size() == 0) return {};
  const double largest = factor * first.lpNorm<Eigen::Infinity>();
  const double off = (again - factor * first).lpNorm<Eigen::Infinity>();
  if (off <= kSameAnswer * largest) return {};
  return std::string(field) + " is not the scaled " + field + " of the first answer";
}

/// The claim of a program. A program may not claim that it crashed.
Claim parse_program_claim(const Json& json) {
  const std::string text = parse_text(json, "claim");
  try {
    const Claim claim = parse_claim(text);
    if (claim != Claim::kCrashed) return claim;
  } catch (const InputError&) {
    // the error below is the same for both cases
  }
  throw BadAnswer("claim: unknown: " + text.substr(0, 40));
}

}  // namespace

double Multiple::of_matrix() const { return std::ldexp(1.0, matrix); }
double Multiple::of_vector() const { return std::ldexp(1.0, vector); }
double Multiple::of_z() const { return std::ldexp(1.0, vector - matrix); }

// +1, -1, +2, -2, ... A contact problem has no such scaling of its matrix: N, D and mu have no unit in common, and
// other inertias would change how its rows compare, and so the work.
Multiple multiple_for(ProblemKind kind, int index) {
  const int sign = index % 2 == 0 ? 1 : -1;
  const int exponent = sign * (index / 2 + 1);
  if (kind == ProblemKind::kLcp) return {.matrix = exponent, .vector = exponent + sign};
  return {.matrix = 0, .vector = exponent};
}

bool is_exact(const Multiple& multiple, const Problem& problem, ProblemKind kind, const Lcp& lcp) {
  switch (kind) {
    case ProblemKind::kLcp:
      return all_scale_exactly(lcp.M, multiple.of_matrix()) && all_scale_exactly(lcp.q, multiple.of_vector());
    case ProblemKind::kContact:
    case ProblemKind::kScene: {
      // Where nothing moves, every multiple is the question that was asked before.
      const Vector& v = problem.contact()->v;
      const Vector& b = problem.contact()->b;
      const bool moves = (v.array() != 0).any() || (b.array() != 0).any();
      return moves && all_scale_exactly(v, multiple.of_vector()) && all_scale_exactly(b, multiple.of_vector());
    }
  }
  return false;
}

std::string difference(const Answer& first, const Answer& again, const Multiple& multiple) {
  if (again.claim != first.claim) {
    return std::string("the claim is ") + to_string(again.claim) + ", not " + to_string(first.claim);
  }
  const std::string z = vector_difference("z", first.z, again.z, multiple.of_z());
  return !z.empty() ? z : vector_difference("velocity", first.velocity, again.velocity, multiple.of_vector());
}

std::string start_message(int version) {
  return Json{{"verb", "start"}, {"format", "lcpbench-external"}, {"version", version}}.dump();
}

std::string problem_message(const Problem& problem, ProblemKind kind, const Lcp& lcp, const Multiple& multiple) {
  Json json = {{"format", "lcpbench-problem"}, {"version", 1}, {"name", problem.name()}, {"kind", to_string(kind)}};
  switch (kind) {
    case ProblemKind::kLcp:
      json["M"] = rows_of(multiple.of_matrix() * lcp.M);
      json["q"] = list(multiple.of_vector() * lcp.q);
      break;
    case ProblemKind::kContact: add_contact(*problem.contact(), multiple.of_vector(), json); break;
    case ProblemKind::kScene: add_scene(*problem.scene(), multiple.of_vector(), json); break;
  }
  return Json{{"verb", "problem"}, {"problem", std::move(json)}}.dump(-1, ' ', true, Json::error_handler_t::replace);
}

std::string setup_message() { return Json{{"verb", "setup"}}.dump(); }

std::string solve_message(double time_limit_s) {
  return Json{{"verb", "solve"}, {"time_limit_s", time_limit_s}}.dump();
}

std::string numbered(const std::string& message, std::uint64_t sequence) {
  return "{\"sequence\":" + std::to_string(sequence) + "," + message.substr(1);
}

int parse_start(const std::string& text, std::uint64_t sequence) {
  const Json json = parse_object(text);
  const Expected expected{sequence, false};
  check_sequence(json, expected);
  const int version = json.contains("sequence") ? 2 : 1;
  for (const auto& [field, value] : json.items()) {
    if (field == "version" && value == Json(version)) continue;
    if (field == "version" && value == Json(kVersion)) throw BadAnswer("version is 2, but sequence is missing");
    if (field != "sequence") throw BadAnswer("expected {}, found " + text.substr(0, 60));
  }
  return version;
}

void parse_acknowledgement(const std::string& text, const Expected& expected) {
  const Json json = parse_object(text);
  check_sequence(json, expected);
  if (json.size() > (json.contains("sequence") ? 1U : 0U)) throw BadAnswer("expected {}, found " + text.substr(0, 60));
  require_sequence(json, expected);
}

Answer parse_answer(const std::string& text, const worker::AnswerSizes& sizes, const Expected& expected) {
  const Json json = parse_object(text);
  check_sequence(json, expected);
  Answer answer;
  bool claimed = false;
  for (const auto& [field, value] : json.items()) {
    if (field == "claim") {
      answer.claim = parse_program_claim(value);
      claimed = true;
    } else if (field == "z") {
      answer.z = parse_vector(value, "z", sizes.z);
    } else if (field == "velocity") {
      answer.velocity = parse_vector(value, "velocity", sizes.velocity);
    } else if (field == "farkas") {
      answer.farkas = parse_vector(value, "farkas", sizes.farkas);
    } else if (field == "detail") {
      answer.detail = worker::printable(parse_text(value, "detail"), worker::kMaxDetailBytes);
    } else if (field == "iterations") {
      answer.counters.iterations = parse_counter(value, "iterations");
    } else if (field == "pivots") {
      answer.counters.pivots = parse_counter(value, "pivots");
    } else if (field == "factorizations") {
      answer.counters.factorizations = parse_counter(value, "factorizations");
    } else if (field != "sequence") {
      throw BadAnswer("unknown field: " + field.substr(0, 40));
    }
  }
  require_sequence(json, expected);
  if (!claimed) throw BadAnswer("claim is missing");
  if (answer.claim == Claim::kSolved && answer.z.size() != sizes.z) throw BadAnswer("solved, but z is missing");
  return answer;
}

std::size_t longest_answer(const worker::AnswerSizes& sizes) {
  return static_cast<std::size_t>(sizes.z + sizes.velocity + sizes.farkas) * kBytesPerNumber + kBytesBesides;
}

}  // namespace lcpbench::external
