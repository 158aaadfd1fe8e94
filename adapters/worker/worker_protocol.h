#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/problem.h"
#include "core/timed_solve.h"

/// What the main program and a worker process say to each other.
///
/// A request and its response lie in one shared memory region; short notices on a socket say when each is complete.
/// Every message is a frame (magic, version, verb, sequence number, payload size) and a payload of 8-byte aligned
/// fields, in the byte order of the machine, as both ends run on it. Parsing trusts nothing: each count is held against
/// the bytes that are left before memory is asked for, and each shape against the shapes it must agree with.
namespace lcpbench::worker {

inline constexpr std::uint64_t kMagic = 0x6c637062656e6368;
/// Raised with every change of the messages: a worker of another build is refused, not misread.
inline constexpr std::uint64_t kVersion = 5;
/// Descriptor of the worker's end of the socket.
inline constexpr int kSocketFd = 3;
/// Whether a worker's memory is limited: not under sanitizers, whose shadow is terabytes of address space.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kMemoryIsLimited = false;
#elif defined(__has_feature)
inline constexpr bool kMemoryIsLimited = !__has_feature(address_sanitizer) && !__has_feature(thread_sanitizer);
#else
inline constexpr bool kMemoryIsLimited = true;
#endif
/// Longest `detail` of an answer, in bytes; longer ones are cut.
inline constexpr std::size_t kMaxDetailBytes = 1000;
/// Longest greeting: the names of all solvers of a worker, and a failure of at most kMaxDetailBytes.
inline constexpr std::size_t kMaxGreetingBytes = 16384;

/// "Solve this problem and time it."
struct Request {
  std::uint64_t sequence = 0;
  std::string solver;  ///< spec
  TimedRequest timing;
  Problem problem;
};

struct Response {
  std::uint64_t sequence = 0;
  TimedAnswer result;     ///< transport_s is not part of the message
  double busy_s = 0;      ///< wall clock from the parsed request to the finished answer
  bool retiring = false;  ///< the worker ends after this answer: an exception left it in doubt
};

/// What a worker says first.
struct Greeting {
  std::vector<std::string> solvers;
  std::string failure;  ///< why the solver that it was started for cannot be made; "" when it was made
};

/// The lengths that an answer's vectors may have, apart from 0.
struct AnswerSizes {
  Index z = 0;         ///< n
  Index velocity = 0;  ///< ngc; 0 for a bare LCP
  Index farkas = 0;    ///< nc; n for a bare LCP
};

/// Socket packet from the program: a request is complete. A new region's descriptor rides along with its first notice.
struct RequestNotice {
  std::uint64_t magic = kMagic;
  std::uint64_t sequence = 0;
  std::uint64_t request_bytes = 0;    ///< from the start of the region
  std::uint64_t response_offset = 0;  ///< multiple of 64
  std::uint64_t response_bytes = 0;   ///< room for the response
};

/// Socket packet from the worker: the response is complete, or none will come.
struct ResponseNotice {
  std::uint64_t magic = kMagic;
  std::uint64_t sequence = 0;
  std::uint64_t declined = 0;  ///< 1: the worker ends without having looked at the request; another may answer it
};

/// `value` holds only when `error` is empty; else `error` is one clause naming the field.
template <class T>
struct Parsed {
  T value;
  std::string error;
  bool ok() const { return error.empty(); }
};

AnswerSizes answer_sizes(const Problem& problem);

/// "" when every vector of the answer has a permitted length, else one clause.
std::string wrong_lengths(const Answer& answer, const AnswerSizes& sizes);

/// At most `max_bytes` of the text, as printable ASCII: line ends and control characters become spaces, others '?'.
std::string printable(std::string_view text, std::size_t max_bytes);

/// Each write returns the size of the whole message and writes it only where it fits: an empty span asks for the size.
std::size_t write_request(const Request& request, std::span<std::byte> out);
std::size_t write_response(const Response& response, std::span<std::byte> out);
std::size_t write_greeting(const Greeting& greeting, std::span<std::byte> out);

/// Room that any valid response with these sizes fits in.
std::size_t response_capacity(const AnswerSizes& sizes);

/// `bytes` is the message, no more and no less. Every shape of the problem is checked; its numbers may be anything.
Parsed<Request> parse_request(std::span<const std::byte> bytes);

/// `bytes` starts with the message; what follows it is ignored. Numbers in z, velocity and farkas may be anything,
/// times are finite and >= 0, counters >= -1, the claim is one of the enumeration, `detail` is made printable.
Parsed<Response> parse_response(std::span<const std::byte> bytes, std::uint64_t sequence, const AnswerSizes& sizes);

/// `bytes` is the message, no more and no less.
Parsed<Greeting> parse_greeting(std::span<const std::byte> bytes);

}  // namespace lcpbench::worker
