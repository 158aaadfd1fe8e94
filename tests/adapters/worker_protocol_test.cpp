// Problems and answers cross the process border bit for bit, and no malformed answer crosses it at all.

#include "adapters/worker/worker_protocol.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"

namespace lcpbench {

const std::vector<RegisteredSolver>& registered_solvers() {
  static const std::vector<RegisteredSolver> none;
  return none;
}

namespace worker {
namespace {

constexpr std::size_t kVersionAt = 8;
constexpr std::size_t kPayloadAt = 24;

Matrix numbered(Index rows, Index cols) {
  Matrix values(rows, cols);
  for (Index i = 0; i < values.size(); ++i) values.data()[i] = std::ldexp(static_cast<double>(3 * i + 1), -7);
  return values;
}

SparseMatrix sparse_numbered(Index rows, Index cols) {
  SparseMatrix values(rows, cols);
  for (Index j = 0; j < cols; j += 2) values.insert(j % rows, j) = static_cast<double>(j) + 0.1;
  return values;
}

ContactProblem contact(Jacobian N, Jacobian D, Inertia inertia) {
  return {.v = numbered(6, 1),
          .N = std::move(N),
          .D = std::move(D),
          .edges = {4, 0, 2},
          .mu = Eigen::Vector3d(0.5, 0.0, 0.25),
          .inertia = std::move(inertia),
          .b = Eigen::Vector3d(0.125, 0.0, -2.0)};
}

ContactProblem with_rows(ContactProblem problem) {
  problem.rows = {.R = sparse_numbered(6, 2),
                  .bounds = LcpBounds::nonnegative(2),
                  .b = numbered(2, 1),
                  .compliance = numbered(2, 1),
                  .is_angle = {0, 1},
                  .names = {"", "hinge"}};
  problem.rows.bounds.friction_of[1] = 0;
  return problem;
}

RigidScene scene() {
  RigidScene result;
  result.bodies.resize(2);
  result.bodies[1].mass = 0.1;
  result.bodies[1].angular_velocity = {1, 2, 3};
  result.contacts.resize(2);
  result.contacts[0] = {.body_a = 1, .body_b = 0, .point = {0.1, 0.2, 0.3}, .mu = 0.7, .edges = 4, .b = -0.25};
  return result;
}

std::vector<Problem> problems_of_every_kind() {
  const Matrix G = Matrix::Identity(6, 6) * 3.0;
  Lcp lcp{numbered(4, 4), numbered(4, 1)};
  lcp.M(0, 0) = -0.0;
  lcp.M(1, 1) = std::numeric_limits<double>::quiet_NaN();
  lcp.q(0) = std::numeric_limits<double>::denorm_min();
  return {Problem("an LCP", lcp),
          Problem("empty", Lcp{}),
          Problem("dense", contact(numbered(6, 3), numbered(6, 6), DenseInertia{G})),
          Problem("mixed", contact(numbered(6, 3), sparse_numbered(6, 6), InverseInertia{G})),
          Problem("sparse", contact(sparse_numbered(6, 3), sparse_numbered(6, 6),
                                    BlockInertia{{numbered(2, 2), numbered(3, 3), numbered(1, 1)}})),
          Problem("factors", contact(numbered(6, 3), numbered(6, 6), FactoredInertia{numbered(6, 4), numbered(4, 1)})),
          Problem("rows", with_rows(contact(numbered(6, 3), numbered(6, 6), DenseInertia{G}))),
          Problem("scene", scene())};
}

Request request_for(const Problem& problem) {
  Request request;
  request.sequence = 42;
  request.timing = {.time_limit_s = 0.5, .repeat_until_s = 0.25, .max_repeats = 7};
  request.problem = problem;
  request.start = numbered(problem.size(), 1);
  return request;
}

/// What `parse` says of the message; "" when it takes it.
template <class Parse>
std::string fault_of(Parse&& parse) {
  try {
    parse();
    return "";
  } catch (const BadMessage& bad) {
    return bad.what();
  }
}

bool is_request(const std::string& bytes) {
  return fault_of([&] { parse_request(bytes); }).empty();
}

void set_word(std::string& bytes, std::size_t at, std::uint64_t value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

TEST(WorkerProtocolTest, RequestsOfEveryKindArriveBitForBit) {
  for (const Problem& problem : problems_of_every_kind()) {
    const std::string bytes = write_request(request_for(problem));
    const Request parsed = parse_request(bytes);
    EXPECT_EQ(write_request(parsed), bytes) << problem.name();
    EXPECT_EQ(parsed.sequence, 42U);
    EXPECT_EQ(parsed.timing.time_limit_s, 0.5);
    EXPECT_EQ(parsed.timing.repeat_until_s, 0.25);
    EXPECT_EQ(parsed.timing.max_repeats, 7);
    EXPECT_EQ(parsed.start.size(), problem.size());
    EXPECT_EQ(parsed.problem.name(), problem.name());
    EXPECT_EQ(parsed.problem.kind(), problem.kind());
    EXPECT_EQ(parsed.problem.size(), problem.size());
  }
}

TEST(WorkerProtocolTest, BoundedRowsArriveWhole) {
  const Problem given("rows", with_rows(contact(numbered(6, 3), numbered(6, 6), DenseInertia{Matrix::Identity(6, 6)})));
  const Problem parsed = parse_request(write_request(request_for(given))).problem;
  const BoundedRows &rows = parsed.contact()->rows, &expected = given.contact()->rows;
  EXPECT_EQ(to_dense(rows.R), to_dense(expected.R));
  EXPECT_EQ(rows.bounds.lower, expected.bounds.lower);
  EXPECT_EQ(rows.bounds.upper, expected.bounds.upper);
  EXPECT_EQ(rows.bounds.friction_of, expected.bounds.friction_of);
  EXPECT_EQ(rows.b, expected.b);
  EXPECT_EQ(rows.compliance, expected.compliance);
  EXPECT_EQ(rows.is_angle, expected.is_angle);
  EXPECT_EQ(rows.names, expected.names);
}

TEST(WorkerProtocolTest, RequestsCutShortAreRefused) {
  for (const Problem& problem : problems_of_every_kind()) {
    const std::string whole = write_request(request_for(problem));
    for (std::size_t length = 0; length < whole.size(); ++length) {
      std::string cut = whole.substr(0, length);
      EXPECT_FALSE(is_request(cut));
      if (length < kPayloadAt + 8) continue;
      set_word(cut, kPayloadAt, length - kPayloadAt - 8);
      EXPECT_FALSE(is_request(cut)) << problem.name() << " cut to " << length << " bytes";
    }
  }
}

Response full_response() {
  Response response;
  response.sequence = 9;
  Answer& answer = response.result.answer;
  answer.claim = Claim::kUnsolvable;
  answer.z = numbered(3, 1);
  answer.z(1) = std::numeric_limits<double>::quiet_NaN();
  answer.velocity = numbered(2, 1);
  answer.farkas = numbered(1, 1);
  answer.counters = {.iterations = 4, .pivots = 5, .factorizations = -1};
  answer.detail = "ray";
  response.result.times = {.setup_wall_s = 1, .setup_cpu_s = 2, .solve_wall_s = 3, .solve_cpu_s = 4, .repeats = 6};
  response.busy_s = 8;
  response.retiring = true;
  return response;
}

constexpr AnswerSizes kSizes{.z = 3, .velocity = 2, .farkas = 1};

TEST(WorkerProtocolTest, ResponsesArriveBitForBit) {
  const std::string bytes = write_response(full_response());
  const Response parsed = parse_response(bytes, 9, kSizes);
  EXPECT_EQ(write_response(parsed), bytes);
  EXPECT_EQ(parsed.result.answer.claim, Claim::kUnsolvable);
  EXPECT_TRUE(std::isnan(parsed.result.answer.z(1)));
  EXPECT_EQ(parsed.result.answer.counters.pivots, 5);
  EXPECT_EQ(parsed.result.answer.detail, "ray");
  EXPECT_EQ(parsed.result.times.solve_cpu_s, 4);
  EXPECT_EQ(parsed.result.times.repeats, 6);
  EXPECT_EQ(parsed.busy_s, 8);
  EXPECT_TRUE(parsed.retiring);
}

TEST(WorkerProtocolTest, EveryResponseThatIsValidFitsTheRoomMadeForIt) {
  Response largest = full_response();
  largest.result.answer.detail.assign(2 * kMaxDetailBytes, 'x');
  EXPECT_EQ(write_response(largest).size(), response_capacity(kSizes));
}

TEST(WorkerProtocolTest, EightBytesReplacedByAHugeNumberAreReadAsTheyAreOrRefused) {
  const std::string whole = write_response(full_response());
  for (std::size_t at = 0; at + 8 <= whole.size(); ++at) {
    for (const std::uint64_t value : {~std::uint64_t{0}, std::uint64_t{1} << 61, std::uint64_t{1} << 32}) {
      std::string changed = whole;
      set_word(changed, at, value);
      fault_of([&] {
        const Response parsed = parse_response(changed, 9, kSizes);
        EXPECT_EQ(write_response(parsed).size(), changed.size()) << at;
        EXPECT_EQ(wrong_lengths(parsed.result.answer, kSizes), "") << at;
      });
    }
  }
}

TEST(WorkerProtocolTest, ResponsesCutShortAreRefused) {
  const std::string whole = write_response(full_response());
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_NE(fault_of([&] { parse_response(whole.substr(0, length), 9, kSizes); }), "");
  }
}

TEST(WorkerProtocolTest, WhatIsNoAnswerIsRefusedAndNamed) {
  const auto error = [](auto&& change) {
    Response response = full_response();
    change(response, response.result.answer);
    return fault_of([&] { parse_response(write_response(response), 9, kSizes); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error([](Response&, Answer&) {}), "");
  EXPECT_EQ(error([](Response&, Answer& a) { a.z.resize(0); }), "");
  EXPECT_EQ(error([](Response& r, Answer&) { r.sequence = 8; }), "sequence number 8, expected 9");
  EXPECT_EQ(error([](Response&, Answer& a) { a.z.conservativeResize(2); }), "z has 2 entries, expected 3 or none");
  EXPECT_EQ(error([](Response&, Answer& a) { a.farkas = Vector::Zero(2); }),
            "farkas has 2 entries, expected 1 or none");
  EXPECT_EQ(error([](Response&, Answer& a) { a.claim = static_cast<Claim>(7); }), "claim: unknown");
  EXPECT_EQ(error([](Response&, Answer& a) { a.claim = static_cast<Claim>(-1); }), "claim: unknown");
  EXPECT_EQ(error([](Response&, Answer& a) { a.counters.pivots = -2; }), "a counter is below -1");
  EXPECT_EQ(error([&](Response& r, Answer&) { r.result.times.solve_cpu_s = nan; }), "a time is negative or not finite");
  EXPECT_EQ(error([](Response& r, Answer&) { r.busy_s = -1e-9; }), "a time is negative or not finite");
  EXPECT_EQ(error([](Response& r, Answer&) { r.busy_s = HUGE_VAL; }), "a time is negative or not finite");
  EXPECT_EQ(error([](Response& r, Answer&) { r.result.times.repeats = 0; }), "repeats: out of range");
}

TEST(WorkerProtocolTest, MessagesOfAnotherVersionAreRefused) {
  std::string bytes = write_response(full_response());
  set_word(bytes, kVersionAt, kVersion + 1);
  EXPECT_NE(fault_of([&] { parse_response(bytes, 9, kSizes); }).find("rebuild"), std::string::npos);
}

TEST(WorkerProtocolTest, DetailIsMadePrintable) {
  EXPECT_EQ(printable("a\nb\x1b[1m\xc3\xa9\x7f", 100), "a b [1m?? ");
  EXPECT_EQ(printable("abcdef", 3), "abc");
}

}  // namespace
}  // namespace worker
}  // namespace lcpbench
