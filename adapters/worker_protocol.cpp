#include "adapters/worker_protocol.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

namespace lcpbench::worker {
namespace {

constexpr std::size_t kAlignment = 8;
constexpr std::size_t kFrameBytes = 5 * sizeof(std::uint64_t);
constexpr std::size_t kMaxNameBytes = 65536;

enum class Verb : std::uint64_t { kGreet = 1, kSolve = 2, kAnswer = 3 };
enum class MatrixStorage : std::uint64_t { kDense = 0, kSparse = 1 };

std::size_t padding_after(std::size_t bytes) { return (kAlignment - bytes % kAlignment) % kAlignment; }

/// Counts every byte and writes those that fit.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> out) : out_(out) {}

  std::size_t size() const { return size_; }

  void word(std::uint64_t value) { bytes(&value, sizeof value); }
  void integer(std::int64_t value) { bytes(&value, sizeof value); }
  void real(double value) { bytes(&value, sizeof value); }

  template <class T>
  void elements(const T* values, std::size_t count) {
    bytes(values, count * sizeof(T));
  }
  void text(std::string_view value) {
    word(value.size());
    bytes(value.data(), value.size());
  }
  void vector(const Vector& values) {
    integer(values.size());
    elements(values.data(), static_cast<std::size_t>(values.size()));
  }
  template <class Dense>
  void matrix(const Dense& values) {
    integer(values.rows());
    integer(values.cols());
    elements(values.data(), static_cast<std::size_t>(values.size()));
  }
  void overwrite_word(std::size_t at, std::uint64_t value) {
    if (at + sizeof value <= out_.size()) std::memcpy(out_.data() + at, &value, sizeof value);
  }

 private:
  void bytes(const void* source, std::size_t count) {
    static constexpr std::byte kZeros[kAlignment] = {};
    append(source, count);
    append(kZeros, padding_after(count));
  }
  void append(const void* source, std::size_t count) {
    if (count > 0 && size_ <= out_.size() && count <= out_.size() - size_) {
      std::memcpy(out_.data() + size_, source, count);
    }
    size_ += count;
  }

  std::span<std::byte> out_;
  std::size_t size_ = 0;
};

/// Reads forward; the first failure sticks, and everything read after it is zero or empty.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  bool ok() const { return error_.empty(); }
  const std::string& error() const { return error_; }
  std::size_t remaining() const { return ok() ? bytes_.size() - at_ : 0; }

  void fail(const std::string& cause) {
    if (ok()) error_ = cause;
  }
  void require(bool condition, const std::string& cause) {
    if (!condition) fail(cause);
  }

  std::uint64_t word() { return scalar<std::uint64_t>(); }
  std::int64_t integer() { return scalar<std::int64_t>(); }
  double real() { return scalar<double>(); }

  /// A count of elements that are `element_bytes` each and still to come.
  std::size_t count(std::size_t element_bytes, const char* field) {
    const std::uint64_t value = word();
    require(value <= remaining() / element_bytes, std::string(field) + ": more entries than the message holds");
    return ok() ? static_cast<std::size_t>(value) : 0;
  }
  template <class T>
  void elements(T* out, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (!ok() || count > remaining() / sizeof(T)) return fail("the message is cut short");
    if (count > 0) std::memcpy(out, bytes_.data() + at_, count * sizeof(T));
    at_ += count * sizeof(T);
    skip_padding(count * sizeof(T));
  }
  std::string text(std::size_t max_bytes, const char* field) {
    const std::size_t length = count(1, field);
    require(length <= max_bytes, std::string(field) + ": longer than " + std::to_string(max_bytes) + " bytes");
    std::string value(ok() ? length : 0, '\0');
    elements(value.data(), value.size());
    return value;
  }
  Vector vector(const char* field) {
    Vector values(static_cast<Index>(count(sizeof(double), field)));
    elements(values.data(), static_cast<std::size_t>(values.size()));
    return values;
  }
  Matrix matrix(Index rows, Index cols, const char* field) {
    require_shape(rows, cols, field);
    require(
        cols == 0 || static_cast<std::size_t>(rows) <= remaining() / sizeof(double) / static_cast<std::size_t>(cols),
        std::string(field) + ": more entries than the message holds");
    if (!ok()) return Matrix();
    Matrix values(rows, cols);
    elements(values.data(), static_cast<std::size_t>(values.size()));
    return values;
  }
  void require_shape(Index rows, Index cols, const char* field) {
    const std::int64_t found_rows = integer();
    const std::int64_t found_cols = integer();
    require(found_rows == rows && found_cols == cols, std::string(field) + ": " + std::to_string(found_rows) + " x " +
                                                          std::to_string(found_cols) + ", expected " +
                                                          std::to_string(rows) + " x " + std::to_string(cols));
  }

 private:
  template <class T>
  T scalar() {
    T value{};
    elements(&value, 1);
    return value;
  }
  void skip_padding(std::size_t count) {
    const std::size_t padding = padding_after(count);
    if (padding > remaining()) return fail("the message is cut short");
    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
    require(
        std::all_of(begin, begin + static_cast<std::ptrdiff_t>(padding), [](std::byte b) { return b == std::byte{0}; }),
        "padding is not zero");
    at_ += padding;
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  std::string error_;
};

// ---- frames -------------------------------------------------------------------------------------------------------

template <class WritePayload>
std::size_t write_frame(Verb verb, std::uint64_t sequence, std::span<std::byte> out, WritePayload&& write_payload) {
  ByteWriter writer(out);
  writer.word(kMagic);
  writer.word(kVersion);
  writer.word(static_cast<std::uint64_t>(verb));
  writer.word(sequence);
  const std::size_t size_at = writer.size();
  writer.word(0);
  write_payload(writer);
  writer.overwrite_word(size_at, writer.size() - kFrameBytes);
  return writer.size();
}

struct Frame {
  std::uint64_t sequence = 0;
  std::size_t payload_bytes = 0;
};

Frame read_frame(ByteReader& reader, Verb expected) {
  Frame frame;
  reader.require(reader.word() == kMagic, "no message: wrong magic number");
  const std::uint64_t version = reader.word();
  reader.require(version == kVersion, "protocol version " + std::to_string(version) + ", this program speaks " +
                                          std::to_string(kVersion) + ": rebuild the workers");
  reader.require(reader.word() == static_cast<std::uint64_t>(expected), "unexpected verb");
  frame.sequence = reader.word();
  frame.payload_bytes = reader.count(1, "payload");
  return frame;
}

template <class T>
Parsed<T> finish(T value, const ByteReader& reader) {
  return {std::move(value), reader.error()};
}

// ---- problems -----------------------------------------------------------------------------------------------------

void write_sparse(const SparseMatrix& J, ByteWriter& writer) {
  if (!J.isCompressed()) {
    SparseMatrix compressed = J;
    compressed.makeCompressed();
    return write_sparse(compressed, writer);
  }
  const auto nonzeros = static_cast<std::size_t>(J.nonZeros());
  writer.integer(J.rows());
  writer.integer(J.cols());
  writer.word(nonzeros);
  writer.elements(J.outerIndexPtr(), static_cast<std::size_t>(J.cols()) + 1);
  writer.elements(J.innerIndexPtr(), nonzeros);
  writer.elements(J.valuePtr(), nonzeros);
}

void write_jacobian(const Jacobian& J, ByteWriter& writer) {
  if (const auto* dense = std::get_if<Matrix>(&J)) {
    writer.word(static_cast<std::uint64_t>(MatrixStorage::kDense));
    writer.matrix(*dense);
  } else {
    writer.word(static_cast<std::uint64_t>(MatrixStorage::kSparse));
    write_sparse(std::get<SparseMatrix>(J), writer);
  }
}

bool is_column_compressed(const std::vector<int>& outer, const std::vector<int>& inner, Index rows) {
  if (outer.front() != 0 || outer.back() != static_cast<int>(inner.size())) return false;
  if (!std::is_sorted(outer.begin(), outer.end())) return false;
  for (std::size_t column = 0; column + 1 < outer.size(); ++column) {
    for (int k = outer[column]; k < outer[column + 1]; ++k) {
      const int row = inner[static_cast<std::size_t>(k)];
      if (row < 0 || row >= rows) return false;
      if (k > outer[column] && row <= inner[static_cast<std::size_t>(k) - 1]) return false;
    }
  }
  return true;
}

SparseMatrix read_sparse(Index rows, Index cols, ByteReader& reader, const char* field) {
  reader.require_shape(rows, cols, field);
  const std::size_t nonzeros = reader.count(sizeof(int) + sizeof(double), field);
  reader.require(nonzeros <= static_cast<std::size_t>(std::numeric_limits<int>::max()) &&
                     static_cast<std::size_t>(cols) < reader.remaining() / sizeof(int),
                 std::string(field) + ": more entries than the message holds");
  if (!reader.ok()) return {};
  std::vector<int> outer(static_cast<std::size_t>(cols) + 1);
  std::vector<int> inner(nonzeros);
  std::vector<double> values(nonzeros);
  reader.elements(outer.data(), outer.size());
  reader.elements(inner.data(), inner.size());
  reader.elements(values.data(), values.size());
  reader.require(reader.ok() && is_column_compressed(outer, inner, rows),
                 std::string(field) + ": not a column-compressed matrix");
  if (!reader.ok()) return {};
  return Eigen::Map<const SparseMatrix>(rows, cols, static_cast<Index>(nonzeros), outer.data(), inner.data(),
                                        values.data());
}

Jacobian read_jacobian(Index rows, Index cols, ByteReader& reader, const char* field) {
  switch (static_cast<MatrixStorage>(reader.word())) {
    case MatrixStorage::kDense: return reader.matrix(rows, cols, field);
    case MatrixStorage::kSparse: return read_sparse(rows, cols, reader, field);
  }
  reader.fail(std::string(field) + ": neither dense nor sparse");
  return {};
}

void write_inertia(const Inertia& inertia, ByteWriter& writer) {
  writer.word(inertia.index());
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    writer.matrix(dense->G);
  } else if (const auto* blocks = std::get_if<BlockInertia>(&inertia)) {
    writer.word(blocks->blocks.size());
    for (const Matrix& block : blocks->blocks) {
      writer.integer(block.rows());
      writer.matrix(block);
    }
  } else if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    writer.vector(factors->alpha);
    writer.matrix(factors->X);
  } else {
    writer.matrix(std::get<InverseInertia>(inertia).Ginv);
  }
}

BlockInertia read_blocks(Index ngc, ByteReader& reader) {
  BlockInertia inertia;
  constexpr std::size_t kSmallestBlock = 3 * sizeof(std::int64_t);
  const std::size_t count = reader.count(kSmallestBlock, "G blocks");
  Index left = ngc;
  for (std::size_t b = 0; b < count && reader.ok(); ++b) {
    const std::int64_t rows = reader.integer();
    reader.require(rows >= 0 && rows <= left, "G blocks: do not add up to ngc rows");
    if (!reader.ok()) break;
    inertia.blocks.push_back(reader.matrix(rows, rows, "G block"));
    left -= rows;
  }
  reader.require(left == 0, "G blocks: do not add up to ngc rows");
  return inertia;
}

Inertia read_inertia(Index ngc, ByteReader& reader) {
  switch (reader.word()) {
    case 0: return DenseInertia{reader.matrix(ngc, ngc, "G")};
    case 1: return read_blocks(ngc, reader);
    case 2: {
      FactoredInertia factors;
      factors.alpha = reader.vector("alpha");
      factors.X = reader.matrix(ngc, factors.alpha.size(), "X");
      return factors;
    }
    case 3: return InverseInertia{reader.matrix(ngc, ngc, "Ginv")};
    default: reader.fail("inertia: unknown kind"); return {};
  }
}

void write_contact(const ContactProblem& contact, ByteWriter& writer) {
  writer.vector(contact.v);
  writer.vector(contact.mu);
  writer.word(contact.edges.size());
  writer.elements(contact.edges.data(), contact.edges.size());
  write_jacobian(contact.N, writer);
  write_jacobian(contact.D, writer);
  write_inertia(contact.inertia, writer);
}

ContactProblem read_contact(ByteReader& reader) {
  ContactProblem contact;
  contact.v = reader.vector("v");
  contact.mu = reader.vector("mu");
  contact.edges.resize(reader.count(sizeof(int), "edges"));
  reader.elements(contact.edges.data(), contact.edges.size());
  reader.require(contact.mu.size() == contact.nc(), "mu: not one entry per contact");
  Index friction = 0;
  for (const int edges : contact.edges) {
    reader.require(edges >= 0 && edges % 2 == 0, "edges: an entry is odd or negative");
    friction += edges;
  }
  if (!reader.ok()) return {};
  contact.N = read_jacobian(contact.ngc(), contact.nc(), reader, "N");
  contact.D = read_jacobian(contact.ngc(), friction, reader, "D");
  contact.inertia = read_inertia(contact.ngc(), reader);
  return contact;
}

constexpr std::size_t kBodyBytes = 19 * sizeof(double);
constexpr std::size_t kContactBytes = 3 * sizeof(std::int64_t) + 10 * sizeof(double);

void write_scene(const RigidScene& scene, ByteWriter& writer) {
  writer.word(scene.bodies.size());
  for (const RigidBody& body : scene.bodies) {
    writer.real(body.mass);
    writer.elements(body.inertia.data(), 9);
    for (const auto* field : {&body.position, &body.linear_velocity, &body.angular_velocity}) {
      writer.elements(field->data(), 3);
    }
  }
  writer.word(scene.contacts.size());
  for (const RigidContact& contact : scene.contacts) {
    for (const int field : {contact.body_a, contact.body_b, contact.edges}) writer.integer(field);
    writer.real(contact.mu);
    for (const auto* field : {&contact.point, &contact.normal, &contact.tangent}) writer.elements(field->data(), 3);
  }
}

RigidScene read_scene(ByteReader& reader) {
  RigidScene scene;
  scene.bodies.resize(reader.count(kBodyBytes, "bodies"));
  for (RigidBody& body : scene.bodies) {
    body.mass = reader.real();
    reader.elements(body.inertia.data(), 9);
    for (auto* field : {&body.position, &body.linear_velocity, &body.angular_velocity}) {
      reader.elements(field->data(), 3);
    }
  }
  scene.contacts.resize(reader.count(kContactBytes, "contacts"));
  const auto bodies = static_cast<std::int64_t>(scene.bodies.size());
  for (RigidContact& contact : scene.contacts) {
    for (int* field : {&contact.body_a, &contact.body_b}) {
      const std::int64_t body = reader.integer();
      reader.require(body >= RigidContact::kWorld && body < bodies, "contacts: no such body");
      *field = reader.ok() ? static_cast<int>(body) : 0;
    }
    const std::int64_t edges = reader.integer();
    reader.require(edges == 0 || edges == 4, "contacts: edges is neither 0 nor 4");
    contact.edges = edges == 4 ? 4 : 0;
    contact.mu = reader.real();
    for (auto* field : {&contact.point, &contact.normal, &contact.tangent}) reader.elements(field->data(), 3);
  }
  return reader.ok() ? scene : RigidScene{};
}

void write_problem(const Problem& problem, ByteWriter& writer) {
  writer.text(problem.name());
  writer.word(static_cast<std::uint64_t>(problem.kind()));
  switch (problem.kind()) {
    case ProblemKind::kLcp:
      writer.vector(problem.lcp().q);
      writer.matrix(problem.lcp().M);
      break;
    case ProblemKind::kContact: write_contact(*problem.contact(), writer); break;
    case ProblemKind::kScene: write_scene(*problem.scene(), writer); break;
  }
}

Problem read_problem(ByteReader& reader) {
  std::string name = reader.text(kMaxNameBytes, "problem name");
  const std::uint64_t kind = reader.word();
  reader.require(kind <= static_cast<std::uint64_t>(ProblemKind::kScene), "unknown kind of problem");
  if (!reader.ok()) return {};
  switch (static_cast<ProblemKind>(kind)) {
    case ProblemKind::kLcp: {
      Lcp lcp;
      lcp.q = reader.vector("q");
      lcp.M = reader.matrix(lcp.size(), lcp.size(), "M");
      return {std::move(name), std::move(lcp)};
    }
    case ProblemKind::kContact: return {std::move(name), read_contact(reader)};
    case ProblemKind::kScene: return {std::move(name), read_scene(reader)};
  }
  return {};
}

// ---- answers ------------------------------------------------------------------------------------------------------

constexpr int kClaims = static_cast<int>(Claim::kCrashed) + 1;

Claim read_claim(ByteReader& reader) {
  const std::uint64_t claim = reader.word();
  reader.require(claim < kClaims, "claim: unknown");
  return reader.ok() ? static_cast<Claim>(claim) : Claim::kCrashed;
}

void write_times(const SolveTimes& times, ByteWriter& writer) {
  for (const double seconds : {times.setup_wall_s, times.setup_cpu_s, times.solve_wall_s, times.solve_cpu_s}) {
    writer.real(seconds);
  }
  writer.integer(times.repeats);
}

double read_seconds(ByteReader& reader) {
  const double seconds = reader.real();
  reader.require(std::isfinite(seconds) && seconds >= 0, "a time is negative or not finite");
  return seconds;
}

SolveTimes read_times(ByteReader& reader) {
  SolveTimes times;
  for (double* seconds : {&times.setup_wall_s, &times.setup_cpu_s, &times.solve_wall_s, &times.solve_cpu_s}) {
    *seconds = read_seconds(reader);
  }
  const std::int64_t repeats = reader.integer();
  reader.require(repeats >= 1 && repeats <= std::numeric_limits<int>::max(), "repeats: out of range");
  times.repeats = reader.ok() ? static_cast<int>(repeats) : 1;
  return times;
}

std::int64_t read_counter(ByteReader& reader) {
  const std::int64_t counter = reader.integer();
  reader.require(counter >= -1, "a counter is below -1");
  return counter;
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
  return {problem.size(), contact->ngc(), contact->nc()};
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

std::size_t write_request(const Request& request, std::span<std::byte> out) {
  return write_frame(Verb::kSolve, request.sequence, out, [&](ByteWriter& writer) {
    writer.text(request.solver);
    writer.real(request.timing.time_limit_s);
    writer.real(request.timing.repeat_until_s);
    writer.integer(request.timing.max_repeats);
    write_problem(request.problem, writer);
  });
}

Parsed<Request> parse_request(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  Request request;
  const Frame frame = read_frame(reader, Verb::kSolve);
  reader.require(frame.payload_bytes == reader.remaining(), "payload: not the size of the message");
  request.sequence = frame.sequence;
  request.solver = reader.text(kMaxNameBytes, "solver");
  request.timing.time_limit_s = reader.real();
  request.timing.repeat_until_s = reader.real();
  const std::int64_t max_repeats = reader.integer();
  reader.require(max_repeats >= 1 && max_repeats <= std::numeric_limits<int>::max(), "max_repeats: out of range");
  if (!reader.ok()) return finish(Request{}, reader);
  request.timing.max_repeats = static_cast<int>(max_repeats);
  request.problem = read_problem(reader);
  reader.require(reader.remaining() == 0, "the message holds more than the problem");
  return finish(std::move(request), reader);
}

std::size_t response_capacity(const AnswerSizes& sizes) {
  Response largest;
  largest.result.answer.detail.assign(kMaxDetailBytes, ' ');
  const Index entries = sizes.z + sizes.velocity + sizes.farkas;
  return write_response(largest, {}) + static_cast<std::size_t>(entries) * sizeof(double);
}

std::size_t write_response(const Response& response, std::span<std::byte> out) {
  return write_frame(Verb::kAnswer, response.sequence, out, [&](ByteWriter& writer) {
    const Answer& answer = response.result.answer;
    writer.word(static_cast<std::uint64_t>(answer.claim));
    writer.integer(answer.counters.iterations);
    writer.integer(answer.counters.pivots);
    writer.integer(answer.counters.factorizations);
    write_times(response.result.times, writer);
    writer.real(response.busy_s);
    writer.word(response.retiring ? 1 : 0);
    writer.vector(answer.z);
    writer.vector(answer.velocity);
    writer.vector(answer.farkas);
    writer.text(std::string_view(answer.detail).substr(0, kMaxDetailBytes));
  });
}

Parsed<Response> parse_response(std::span<const std::byte> bytes, std::uint64_t sequence, const AnswerSizes& sizes) {
  ByteReader frame_reader(bytes);
  const Frame frame = read_frame(frame_reader, Verb::kAnswer);
  frame_reader.require(frame.sequence == sequence,
                       "sequence number " + std::to_string(frame.sequence) + ", expected " + std::to_string(sequence));
  if (!frame_reader.ok()) return finish(Response{}, frame_reader);

  ByteReader reader(bytes.subspan(kFrameBytes, frame.payload_bytes));
  Response response;
  response.sequence = sequence;
  Answer& answer = response.result.answer;
  answer.claim = read_claim(reader);
  answer.counters.iterations = read_counter(reader);
  answer.counters.pivots = read_counter(reader);
  answer.counters.factorizations = read_counter(reader);
  response.result.times = read_times(reader);
  response.busy_s = read_seconds(reader);
  const std::uint64_t retiring = reader.word();
  reader.require(retiring <= 1, "retiring: neither 0 nor 1");
  response.retiring = retiring == 1;
  answer.z = reader.vector("z");
  answer.velocity = reader.vector("velocity");
  answer.farkas = reader.vector("farkas");
  answer.detail = printable(reader.text(kMaxDetailBytes, "detail"), kMaxDetailBytes);
  reader.require(reader.remaining() == 0, "the message holds more than the answer");
  const std::string lengths = wrong_lengths(answer, sizes);
  reader.require(lengths.empty(), lengths);
  if (!reader.ok()) return finish(Response{}, reader);
  return finish(std::move(response), reader);
}

std::size_t write_greeting(const Greeting& greeting, std::span<std::byte> out) {
  return write_frame(Verb::kGreet, 0, out, [&](ByteWriter& writer) {
    writer.word(greeting.solvers.size());
    for (const std::string& solver : greeting.solvers) writer.text(solver);
    writer.text(std::string_view(greeting.failure).substr(0, kMaxDetailBytes));
  });
}

Parsed<Greeting> parse_greeting(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  const Frame frame = read_frame(reader, Verb::kGreet);
  reader.require(frame.sequence == 0, "a greeting has no sequence number");
  reader.require(frame.payload_bytes == reader.remaining(), "payload: not the size of the message");
  Greeting greeting;
  const std::size_t count = reader.count(sizeof(std::uint64_t), "solvers");
  for (std::size_t i = 0; i < count && reader.ok(); ++i) {
    greeting.solvers.push_back(reader.text(kMaxGreetingBytes, "solver name"));
  }
  greeting.failure = printable(reader.text(kMaxDetailBytes, "failure"), kMaxDetailBytes);
  reader.require(reader.remaining() == 0, "the message holds more than a greeting");
  return finish(std::move(greeting), reader);
}

}  // namespace lcpbench::worker
