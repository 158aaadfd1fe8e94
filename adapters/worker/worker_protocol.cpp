#include "adapters/worker/worker_protocol.h"

#include <array>
#include <cmath>
#include <concepts>
#include <cstring>
#include <utility>

namespace lcpbench::worker {

/// A structure that is written or, where it is not const, read.
template <class Found, class Structure>
concept Is = std::same_as<std::remove_const_t<Found>, Structure>;

void fields(auto& io, Is<LcpBounds> auto& bounds) { io(bounds.lower, bounds.upper, bounds.friction_of, bounds.mu); }
void fields(auto& io, Is<Lcp> auto& lcp) { io(lcp.q, lcp.M, lcp.bounds); }
void fields(auto& io, Is<DenseInertia> auto& inertia) { io(inertia.G); }
void fields(auto& io, Is<BlockInertia> auto& inertia) { io(inertia.blocks); }
void fields(auto& io, Is<FactoredInertia> auto& inertia) { io(inertia.alpha, inertia.X); }
void fields(auto& io, Is<InverseInertia> auto& inertia) { io(inertia.Ginv); }
void fields(auto& io, Is<BoundedRows> auto& rows) {
  io(rows.R, rows.bounds, rows.b, rows.compliance, rows.is_angle, rows.names);
}
void fields(auto& io, Is<ContactProblem> auto& contact) {
  io(contact.v, contact.mu, contact.edges, contact.N, contact.D, contact.inertia, contact.b, contact.compliance_n,
     contact.compliance_t, contact.offset_t, contact.rows);
}
void fields(auto& io, Is<MatrixFormation> auto& formation) { io(formation.plain_inverse, formation.cone_diagonal); }
void fields(auto& io, Is<RigidBody> auto& body) {
  io(body.mass, body.inertia, body.position, body.linear_velocity, body.angular_velocity);
}
void fields(auto& io, Is<RigidContact> auto& contact) {
  io(contact.body_a, contact.body_b, contact.edges, contact.mu, contact.b, contact.compliance_n, contact.compliance_t,
     contact.offset_t, contact.point, contact.normal, contact.tangent);
}
void fields(auto& io, Is<RigidScene> auto& scene) { io(scene.bodies, scene.contacts); }
void fields(auto& io, Is<TimedRequest> auto& timing) {
  io(timing.time_limit_s, timing.repeat_until_s, timing.max_repeats);
}
void fields(auto& io, Is<Counters> auto& counters) {
  io(counters.iterations, counters.pivots, counters.factorizations);
}
void fields(auto& io, Is<SolveTimes> auto& times) {
  io(times.setup_wall_s, times.setup_cpu_s, times.solve_wall_s, times.solve_cpu_s, times.repeats);
}

namespace {

constexpr std::uint64_t kMagic = 0x6c637062656e6368;

constexpr int kClaims = static_cast<int>(Claim::kCrashed) + 1;

/// A frame around what `write_payload` writes.
template <class WritePayload>
std::string write_message(std::uint64_t sequence, WritePayload&& write_payload) {
  std::string message;
  MessageWriter writer(message);
  for (const std::uint64_t word : {kMagic, kVersion, sequence, std::uint64_t{0}}) writer(word);
  write_payload(writer);
  const std::uint64_t payload = message.size() - kFrameBytes;
  std::memcpy(message.data() + kFrameBytes - sizeof payload, &payload, sizeof payload);
  return message;
}

/// The payload of a whole message.
MessageReader read_message(std::string_view bytes, std::uint64_t& sequence) {
  require(message_size(bytes) == bytes.size() && !bytes.empty(), "payload: not the size of the message");
  std::memcpy(&sequence, bytes.data() + 2 * sizeof sequence, sizeof sequence);
  return MessageReader(bytes.substr(kFrameBytes));
}

/// All of a response but its text, which follows.
void numbers(auto& io, auto& response, auto& claim) {
  auto& answer = response.result.answer;
  io(claim, answer.counters, response.result.times, response.busy_s, response.retiring, response.declined, answer.z,
     answer.velocity, answer.farkas);
}

/// As read_problem() reads a variant: its number, then what it holds.
void write_problem(const Problem& problem, MessageWriter& writer) {
  writer(problem.name(), problem.formation(), static_cast<int>(problem.kind()));
  switch (problem.kind()) {
    case ProblemKind::kLcp: return writer(problem.lcp());
    case ProblemKind::kContact: return writer(*problem.contact());
    case ProblemKind::kScene: return writer(*problem.scene());
  }
}

Problem read_problem(MessageReader& reader) {
  std::string name;
  MatrixFormation formation;
  std::variant<Lcp, ContactProblem, RigidScene> data;  // in the order of ProblemKind
  reader(name, formation, data);
  if (auto* contact = std::get_if<ContactProblem>(&data)) return {std::move(name), std::move(*contact), formation};
  if (auto* scene = std::get_if<RigidScene>(&data)) return {std::move(name), std::move(*scene)};
  return {std::move(name), std::move(std::get<Lcp>(data))};
}

std::string wrong_length(const char* field, Index found, Index expected) {
  if (found == 0 || found == expected) return {};
  return std::string(field) + " has " + std::to_string(found) + " entries, expected " +
         (expected == 0 ? "none" : std::to_string(expected) + " or none");
}

}  // namespace

AnswerSizes answer_sizes(const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr) return {problem.size(), 0, problem.size()};
  return {problem.size(), contact->ngc(), contact->nc() + contact->rows.size()};
}

std::string wrong_lengths(const Answer& answer, const AnswerSizes& sizes) {
  for (std::string error :
       {wrong_length("z", answer.z.size(), sizes.z), wrong_length("velocity", answer.velocity.size(), sizes.velocity),
        wrong_length("farkas", answer.farkas.size(), sizes.farkas)}) {
    if (!error.empty()) return error;
  }
  return {};
}

std::string printable(std::string_view text, std::size_t max_bytes) {
  std::string result(text.substr(0, max_bytes));
  for (char& c : result) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f) c = ' ';
    if (code >= 0x80) c = '?';
  }
  return result;
}

std::size_t message_size(std::string_view bytes) {
  if (bytes.size() < kFrameBytes) return 0;
  std::array<std::uint64_t, 4> frame{};
  std::memcpy(frame.data(), bytes.data(), kFrameBytes);
  const auto [magic, version, sequence, payload] = frame;
  require(magic == kMagic, "no message: wrong magic number");
  require(version == kVersion, "protocol version " + std::to_string(version) + ", this program speaks " +
                                   std::to_string(kVersion) + ": rebuild the workers");
  return payload > std::string_view::npos - kFrameBytes ? std::string_view::npos : kFrameBytes + payload;
}

std::string write_request(const Request& request) {
  return write_message(request.sequence, [&](MessageWriter& writer) {
    writer(request.timing, request.start);
    write_problem(request.problem, writer);
  });
}

Request parse_request(std::string_view bytes) {
  Request request;
  MessageReader reader = read_message(bytes, request.sequence);
  reader(request.timing, request.start);
  request.problem = read_problem(reader);
  require(reader.left().empty(), "the message holds more than the request");
  return request;
}

std::size_t response_capacity(const AnswerSizes& sizes) {
  Response largest;
  largest.result.answer.detail.assign(kMaxDetailBytes, ' ');
  const Index entries = sizes.z + sizes.velocity + sizes.farkas;
  return write_response(largest).size() + static_cast<std::size_t>(entries) * sizeof(double);
}

std::string write_response(const Response& response) {
  return write_message(response.sequence, [&](MessageWriter& writer) {
    const int claim = static_cast<int>(response.result.answer.claim);
    numbers(writer, response, claim);
    writer(response.result.answer.detail.substr(0, kMaxDetailBytes));
  });
}

Response parse_response(std::string_view bytes, std::uint64_t sequence, const AnswerSizes& sizes) {
  Response response;
  MessageReader reader = read_message(bytes, response.sequence);
  Answer& answer = response.result.answer;
  int claim = 0;
  numbers(reader, response, claim);
  reader(answer.detail);
  require(reader.left().empty(), "the message holds more than the answer");
  require(claim >= 0 && claim < kClaims, "claim: unknown");
  answer.claim = static_cast<Claim>(claim);
  for (const std::int64_t counter :
       {answer.counters.iterations, answer.counters.pivots, answer.counters.factorizations}) {
    require(counter >= -1, "a counter is below -1");
  }
  const SolveTimes& times = response.result.times;
  for (const double time :
       {times.setup_wall_s, times.setup_cpu_s, times.solve_wall_s, times.solve_cpu_s, response.busy_s}) {
    require(std::isfinite(time) && time >= 0, "a time is negative or not finite");
  }
  require(times.repeats >= 1, "repeats: out of range");
  const std::string lengths = wrong_lengths(answer, sizes);
  require(lengths.empty(), lengths);
  require(response.sequence == sequence, "sequence number " + std::to_string(response.sequence) + ", expected " +
                                             std::to_string(sequence));
  answer.detail = printable(answer.detail, kMaxDetailBytes);
  return response;
}

}  // namespace lcpbench::worker
