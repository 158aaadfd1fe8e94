#include "adapters/external_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/error.h"

namespace lcpbench::external {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;
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

void add_contact(const ContactProblem& contact, Json& json) {
  json["v"] = list(contact.v);
  json["N"] = rows_of(to_dense(contact.N));
  if (contact.frictional() || (contact.ngc() == 0 && contact.nc() > 0)) {
    json["D"] = rows_of(to_dense(contact.D));
    json["edges"] = contact.edges;
    json["mu"] = list(contact.mu);
  }
  std::visit(AddInertia{json}, contact.inertia);
}

Json body_json(const RigidBody& body) {
  return {{"mass", body.mass},
          {"inertia", rows_of(body.inertia)},
          {"position", list(body.position)},
          {"linear_velocity", list(body.linear_velocity)},
          {"angular_velocity", list(body.angular_velocity)}};
}

Json contact_json(const RigidContact& contact) {
  Json json = {{"body_a", contact.body_a},
               {"body_b", contact.body_b},
               {"point", list(contact.point)},
               {"normal", list(contact.normal)}};
  if (contact.edges != 0) {
    json["tangent"] = list(contact.tangent);
    json["mu"] = contact.mu;
    json["edges"] = contact.edges;
  }
  return json;
}

void add_scene(const RigidScene& scene, Json& json) {
  json["bodies"] = Json::array();
  for (const RigidBody& body : scene.bodies) json["bodies"].push_back(body_json(body));
  json["contacts"] = Json::array();
  for (const RigidContact& contact : scene.contacts) json["contacts"].push_back(contact_json(contact));
}

Json parse_object(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
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

/// What a program may claim: that it crashed is for others to say.
Claim parse_program_claim(const Json& json) {
  const std::string text = parse_text(json, "claim");
  try {
    const Claim claim = parse_claim(text);
    if (claim != Claim::kCrashed) return claim;
  } catch (const InputError&) {
    // said below, for both
  }
  throw BadAnswer("claim: unknown: " + text.substr(0, 40));
}

}  // namespace

std::string start_message() {
  return Json{{"verb", "start"}, {"format", "lcpbench-external"}, {"version", kVersion}}.dump();
}

std::string problem_message(const Problem& problem, ProblemKind kind, const Lcp& lcp) {
  Json json = {{"format", "lcpbench-problem"}, {"version", 1}, {"name", problem.name()}, {"kind", to_string(kind)}};
  switch (kind) {
    case ProblemKind::kLcp:
      json["M"] = rows_of(lcp.M);
      json["q"] = list(lcp.q);
      break;
    case ProblemKind::kContact: add_contact(*problem.contact(), json); break;
    case ProblemKind::kScene: add_scene(*problem.scene(), json); break;
  }
  return Json{{"verb", "problem"}, {"problem", std::move(json)}}.dump(-1, ' ', true, Json::error_handler_t::replace);
}

std::string setup_message() { return Json{{"verb", "setup"}}.dump(); }

std::string solve_message(double time_limit_s) {
  return Json{{"verb", "solve"}, {"time_limit_s", time_limit_s}}.dump();
}

void parse_acknowledgement(const std::string& text) {
  if (!parse_object(text).empty()) throw BadAnswer("expected {}, found " + text.substr(0, 60));
}

Answer parse_answer(const std::string& text, const worker::AnswerSizes& sizes) {
  const Json json = parse_object(text);
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
    } else {
      throw BadAnswer("unknown field: " + field.substr(0, 40));
    }
  }
  if (!claimed) throw BadAnswer("claim is missing");
  if (answer.claim == Claim::kSolved && answer.z.size() != sizes.z) throw BadAnswer("solved, but z is missing");
  return answer;
}

std::size_t longest_answer(const worker::AnswerSizes& sizes) {
  return static_cast<std::size_t>(sizes.z + sizes.velocity + sizes.farkas) * kBytesPerNumber + kBytesBesides;
}

}  // namespace lcpbench::external
