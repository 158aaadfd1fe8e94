#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "adapters/worker/message.h"
#include "core/problem.h"
#include "core/timed_solve.h"

/// What the main program and a worker process say to each other, through a socket.
///
/// Every message is a frame (magic, version, sequence number, payload size) and a payload of fields (message.h). All of
/// a response is checked, because a library may damage its worker. A request is trusted: it comes from the program of
/// the same build.
namespace lcpbench::worker {

/// Raised with every change of the messages: a worker with another version is refused, not misread.
inline constexpr std::uint64_t kVersion = 11;
inline constexpr std::size_t kFrameBytes = 4 * sizeof(std::uint64_t);
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

/// "Solve this problem and time it."
struct Request {
  std::uint64_t sequence = 0;
  TimedRequest timing;  ///< its `start` is not sent: the one below is
  Problem problem;
  Vector start;  ///< TimedRequest::start; empty: none
};

/// Also the first message of a worker, with sequence number 0: its claim is kSolved when the worker has made its
/// solver; else `detail` says why not.
struct Response {
  std::uint64_t sequence = 0;
  TimedAnswer result;     ///< transport_s is not part of the message
  double busy_s = 0;      ///< wall clock of the solve, without the transport to a program behind the worker
  bool retiring = false;  ///< the worker ends after this answer: its state is doubtful, or it is of no more use
  bool declined = false;  ///< no answer: the worker ends without having looked at the request; another may answer it
};

/// The lengths that an answer's vectors may have, apart from 0.
struct AnswerSizes {
  Index z = 0;         ///< n
  Index velocity = 0;  ///< ngc; 0 for a bare LCP
  Index farkas = 0;    ///< nc and the bounded rows; n for a bare LCP
};

AnswerSizes answer_sizes(const Problem& problem);

/// "" when every vector of the answer has a permitted length, else one clause.
std::string wrong_lengths(const Answer& answer, const AnswerSizes& sizes);

/// At most `max_bytes` of the text, as printable ASCII: line ends and control characters become spaces, bytes that are
/// not ASCII '?'.
std::string printable(std::string_view text, std::size_t max_bytes);

/// The whole message. Nothing is checked; Problem::engine_impulses() are not sent.
std::string write_request(const Request& request);
std::string write_response(const Response& response);

/// The size of the message that these bytes begin with; 0 while they are no whole frame. @throws BadMessage when they
/// begin no message.
std::size_t message_size(std::string_view bytes);

/// Room that any valid response with these sizes fits in.
std::size_t response_capacity(const AnswerSizes& sizes);

/// `bytes` is the message, no more and no less. @pre write_request() of this version wrote them. @throws BadMessage for
/// what is cut short
Request parse_request(std::string_view bytes);

/// `bytes` is the message, no more and no less. Numbers in z, velocity and farkas may be anything, times are finite and
/// >= 0, counters >= -1, the claim is one of the enumeration, `detail` is made printable. @throws BadMessage
Response parse_response(std::string_view bytes, std::uint64_t sequence, const AnswerSizes& sizes);

}  // namespace lcpbench::worker
