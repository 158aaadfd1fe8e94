// What a user's own program may do, and what is made of it. The programs are Python scripts, so that the tests also
// show that no header, library or build of ours is needed.

#include <chrono>
#include <filesystem>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "adapters/external/external_json.h"
#include "adapters/worker/asked_program.h"
#include "adapters/worker/worker_client.h"
#include "core/error.h"
#include "core/io/problem_io.h"
#include "generators/sets.h"
#include "study/run/open_solver.h"
#include "tests/adapters/external_client.h"
#include "tests/adapters/worker_empty_poll.h"

namespace lcpbench {
namespace {

class ExternalFaultTest : public ::testing::TestWithParam<Fault> {};

TEST_P(ExternalFaultTest, IsReportedAndTheNextRunWorks) {
  const Fault& fault = GetParam();
  const auto solver = client();
  const Answer answer = run(*solver, fault.behaviour, fault.request);
  EXPECT_STREQ(to_string(answer.claim), to_string(fault.claim)) << answer.detail;
  EXPECT_NE(answer.detail.find(fault.detail), std::string::npos) << answer.detail;
  EXPECT_EQ(answer.z.size(), 0);
  expect_right(*solver);
}

INSTANTIATE_TEST_SUITE_P(
    Faults, ExternalFaultTest,
    ::testing::Values(
        Fault{"exception", Claim::kCrashed, "exited with code 1 without an answer; stderr: KeyError: 'no such"},
        Fault{"segfault", Claim::kCrashed, "solve: killed by signal 11 (SIGSEGV) without an answer"},
        Fault{"exit 0", Claim::kCrashed, "solve: exited with code 0 without an answer"},
        Fault{"close the output", Claim::kCrashed, "closed its output without an answer"},
        Fault{"sleep", Claim::kTimeLimit, "no answer within", kImpatient},
        Fault{"no line end", Claim::kTimeLimit, "no answer within", kImpatient},
        Fault{"stop", Claim::kTimeLimit, "no answer within", kImpatient},
        Fault{"stop reading", Claim::kTimeLimit, "no answer within", kImpatient},
        Fault{"huge", Claim::kCrashed, "an answer of more than"},
        Fault{"twice", Claim::kCrashed, "said more than was asked: '"},
        Fault{"debug", Claim::kCrashed, "said more than was asked: 'here I am'; what is no answer belongs on stderr"},
        Fault{"garbage", Claim::kCrashed, "returned no answer: line: column 1: not valid JSON"},
        Fault{"not utf-8", Claim::kCrashed, "not valid JSON, or not UTF-8"},
        Fault{"an array", Claim::kCrashed, "expected an object, found a list"},
        Fault{"nan", Claim::kCrashed, "not valid JSON: unexpected 'N' (in z[0])"},
        Fault{"null", Claim::kCrashed, "z[0]: expected a finite number, found null"},
        Fault{"overflow", Claim::kCrashed, "is beyond the range of double"},
        Fault{"short", Claim::kCrashed, "z: 1 entry, expected 5"},
        Fault{"long", Claim::kCrashed, "z: 2000 entries, expected 5"},
        Fault{"z is a text", Claim::kCrashed, "z: expected a list of numbers, found a text"},
        Fault{"velocity", Claim::kCrashed, "velocity: 1 entry, expected 0"},
        Fault{"solved without z", Claim::kCrashed, "z is missing"},
        Fault{"no claim", Claim::kCrashed, "claim: missing"},
        Fault{"claims a crash", Claim::kCrashed, "claim: a program cannot say that it crashed"},
        Fault{"unknown claim", Claim::kCrashed, "unknown claim 'optimal'"},
        Fault{"unknown field", Claim::kCrashed, "unknown field 'zeta'"},
        Fault{"negative counter", Claim::kCrashed, "iterations is -5, expected an integer in [0, "},
        Fault{"key twice", Claim::kCrashed, "returned no answer: line: z: given twice"},
        Fault{"wrong number", Claim::kCrashed, "sequence is 1, but the question has 4: a line that came late or twice"},
        Fault{"no number", Claim::kCrashed, "sequence is missing"}, Fault{"no z", Claim::kIterationLimit, ""},
        Fault{"unsupported", Claim::kUnsupported, "no such problems"}),
    fault_name);

TEST(ExternalTest, OneProcessServesAllProblemsAndANewOneFollowsACrash) {
  const auto solver = client();
  const auto process = run(*solver, "process").counters.iterations;
  EXPECT_GT(process, 0);
  expect_right(*solver);
  EXPECT_EQ(run(*solver, "process").counters.iterations, process);
  run(*solver, "segfault");
  EXPECT_NE(run(*solver, "process").counters.iterations, process);
}

void end_between_problems(TimedSolver& solver) {
  const auto process = static_cast<pid_t>(run(solver, "process").counters.iterations);
  ASSERT_GT(process, 0);
  ASSERT_EQ(kill(process, SIGKILL), 0);
  while (state_of(process) != 'Z') std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

TEST(ExternalTest, ProgramThatEndedBetweenProblemsIsStartedAnew) {
  const auto solver = client();
  end_between_problems(*solver);
  expect_right(*solver);
}

TEST(ExternalTest, CountersAndDetailArrive) {
  const Answer answer = run(*client(), "counters");
  EXPECT_STREQ(to_string(answer.claim), "solved");
  EXPECT_EQ(answer.counters.iterations, 3);
  EXPECT_EQ(answer.counters.pivots, 5);
  EXPECT_EQ(answer.counters.factorizations, 7);
  EXPECT_EQ(answer.detail, "three lines [31m");
}

TEST(ExternalTest, OutputGoesNowhereAndMegabytesOfItAreNoTrouble) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const Answer answer = run(*client(), "chatter");
  const std::string printed = ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
  EXPECT_STREQ(to_string(answer.claim), "solved") << answer.detail;
  EXPECT_EQ(printed, "");
}

TEST(ExternalTest, ProgramRunsWhereLcpbenchWasStarted) {
  const std::filesystem::path before = std::filesystem::current_path();
  const std::filesystem::path script = EXTERNAL_FAULTS;
  std::filesystem::current_path(script.parent_path());
  const Answer answer = run(*client("./" + script.filename().string()), "where");
  std::filesystem::current_path(before);
  EXPECT_EQ(answer.detail, std::filesystem::canonical(script.parent_path()).string());
}

/// A runtime that keeps a cache dies of this limit.
TEST(ExternalTest, TheLimitOnFilesIsNamedAndCanBeLifted) {
  const Answer limited = run(*client(), "write");
  EXPECT_STREQ(to_string(limited.claim), "crashed");
  EXPECT_NE(limited.detail.find("no file of more than 4 KiB: writes_files=true lifts this limit"), std::string::npos)
      << limited.detail;
  const auto free =
      worker_solver(EXTERNAL_WORKER, parse_spec("external{command=" EXTERNAL_FAULTS ",writes_files=true}"), {});
  EXPECT_STREQ(to_string(run(*free, "write").claim), "solved");
}

TEST(ExternalTest, ProgramThatDoesNotStartIsReportedAndBlamesNoProblem) {
  EXPECT_NE(start_error("./no_such_program").find("cannot run ./no_such_program: No such file"), std::string::npos);
  EXPECT_NE(start_error("/etc/passwd").find("Permission denied"), std::string::npos);
  EXPECT_NE(start_error("false").find("exited with code 1 without an answer"), std::string::npos);
  EXPECT_NE(start_error("cat").find("unknown field 'verb': expected {}, found "), std::string::npos);
  EXPECT_NE(start_error("sh -c 'echo missing licence >&2; exit 3'").find("stderr: missing licence"), std::string::npos);
  EXPECT_NE(start_error("").find("command"), std::string::npos);
  EXPECT_NE(start_error("'open").find("an open quote"), std::string::npos);
}

/// Seconds until a silent program is given up.
double wait_for_silence(const TimedRequest& request) {
  const double begin_s = wall_clock_s();
  const auto solver = client("sleep 100", "lcp", {.start_timeout_s = 0.2, .program_start_s = 0.4});
  TimedAnswer result;
  try {
    solver->run(named("right"), request, result);
    ADD_FAILURE() << "it starts";
  } catch (const WorkerError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find("solver 'external' does not start: the program 'sleep 100' did not print "
                        "{\"sequence\": 1} as its first line, and flush it: gave no answer within "),
              0U)
        << text;
    EXPECT_NE(text.find(" ms; if it starts slowly, raise --time-limit, or time_limit_s of a plan (docs/reference/"),
              std::string::npos)
        << text;
  }
  return wall_clock_s() - begin_s;
}

TEST(ExternalTest, WaitForAProgramToStartFollowsFromTheTimeLimit) {
  constexpr double kNever = 18.0;  // a busy machine, too, gives up earlier
  const double least_s = wait_for_silence({.time_limit_s = 0.1});
  EXPECT_GE(least_s, 0.4);
  EXPECT_LT(least_s, kNever);
  const double limit_s = wait_for_silence({.time_limit_s = 1.6});  // longer than the worker itself may take
  EXPECT_GE(limit_s, 1.6);
  EXPECT_LT(limit_s, kNever);
}

// The line that the program sends late is its answer to the problem before.
TEST(ExternalTest, LateSecondLineIsNotTakenAsTheNextAnswer) {
  const auto solver = client();
  expect_right(*solver);
  TimedAnswer result;
  solver->run(named("late line", -3.0), kPatient, result);
  EXPECT_STREQ(to_string(result.answer.claim), "crashed");
  EXPECT_NE(result.answer.detail.find("a line that came late or twice"), std::string::npos) << result.answer.detail;
  EXPECT_EQ(result.answer.z.size(), 0);
  expect_right(*solver);
}

TEST(ExternalTest, ProgramsOfVersion1RunWithANote) {
  for (const char* version : {" --version-1", " --only-version-1"}) {
    const auto solver = client(EXTERNAL_FAULTS + std::string(version));
    expect_right(*solver);
    EXPECT_EQ(run(*solver, "right").detail, "protocol version 1: a late second answer cannot be told apart");
    EXPECT_EQ(run(*solver, "unsupported").detail, "no such problems") << "a reason that reports count";
  }
}

// A program may remember its answers: it is asked once, whatever repetition is wanted of other solvers.
TEST(ExternalTest, EachProblemIsAskedOnce) {
  const auto solver = client();
  TimedAnswer result;
  solver->run(named("cache"), {.time_limit_s = 20, .repeat_until_s = 0.3}, result);
  EXPECT_STREQ(to_string(result.answer.claim), "solved") << result.answer.detail;
  EXPECT_EQ(result.times.repeats, 1);
  EXPECT_GE(result.times.solve_wall_s, 0.05);
}

TEST(ExternalTest, ProgramThatTakesAStartIsGivenTheOneThatIsThere) {
  const Vector start = Vector::LinSpaced(kSize, 0.5, 2.5);
  for (const char* const takes : {"true", "false"}) {
    const auto solver =
        worker_solver(EXTERNAL_WORKER, Spec{"external", {{"command", EXTERNAL_FAULTS}, {"warm_start", takes}}});
    EXPECT_EQ(run(*solver, "start").detail, "None");
    EXPECT_EQ(run(*solver, "start", {.time_limit_s = 20.0, .start = &start}).detail,
              *takes == 't' ? "[0.5, 1.0, 1.5, 2.0, 2.5]" : "None");
  }
}

TEST(AskedProgramTest, AnswerOfAProgramThatEndsBehindOurBackIsRead) {
  worker::AskedProgram program(external::command_words("sh -c 'read line; kill -STOP $$; echo {}'"),
                               worker::AskedProgram::Channel::kStandard);
  const std::vector<pid_t> children = children_of(getpid());
  ASSERT_EQ(children.size(), 1U);
  end_stopped_child_in_next_empty_poll(children[0]);
  EXPECT_EQ(program.ask("{}\n", external::line_size, 100, wall_clock_s() + 20.0), "{}\n");
  EXPECT_TRUE(child_has_ended_in_empty_poll());
  EXPECT_TRUE(program.dead());
}

/// A sweep over programs that differ in an argument.
std::unique_ptr<SweptSolver> sweep_of(int cells) {
  std::vector<Spec> specs;
  for (int cell = 0; cell < cells; ++cell) {
    specs.push_back({"external", {{"command", EXTERNAL_FAULTS " " + std::to_string(cell)}}});
  }
  return open_swept_solver(specs);
}

/// The processes that answer the cells.
std::set<std::int64_t> processes(SweptSolver& sweep) {
  std::vector<SweptAnswer> answers;
  sweep.run(named("process"), kPatient, answers);
  std::set<std::int64_t> result;
  for (const SweptAnswer& answer : answers) result.insert(answer.timed.answer.counters.iterations);
  return result;
}

TEST(ExternalSweepTest, ProcessesOfAFewCellsServeAllProblems) {
  const auto sweep = sweep_of(3);
  const std::set<std::int64_t> first = processes(*sweep);
  EXPECT_EQ(first.size(), 3U);
  EXPECT_EQ(processes(*sweep), first);
}

TEST(ExternalSweepTest, ManyCellsDoNotAddUpToManyProcesses) {
  const auto sweep = sweep_of(17);
  EXPECT_EQ(processes(*sweep).size(), 17U);
  EXPECT_TRUE(children_of(getpid()).empty());
}

// What the program does in "problem" is transport: 0.2 s there and 0.1 s in "setup" are told apart from 0.05 s in
// "solve".
TEST(ExternalTest, TimesAreTakenApartByTheWallClock) {
  const auto solver = client();
  expect_right(*solver);  // starting takes its time
  const double begin_s = wall_clock_s();
  TimedAnswer result;
  solver->run(named("delays"), {.time_limit_s = 20, .repeat_until_s = 0.4}, result);
  const double all_s = wall_clock_s() - begin_s;
  const SolveTimes& times = result.times;
  ASSERT_STREQ(to_string(result.answer.claim), "solved") << result.answer.detail;
  EXPECT_GE(times.setup_wall_s, 0.1);
  EXPECT_GE(times.solve_wall_s, 0.05);
  EXPECT_EQ(times.setup_cpu_s, times.setup_wall_s);
  EXPECT_EQ(times.solve_cpu_s, times.solve_wall_s);
  EXPECT_GE(times.transport_s, 0.2);
  EXPECT_EQ(times.repeats, 1);
  EXPECT_LE(times.setup_wall_s + times.solve_wall_s + times.transport_s, all_s) << "nothing counts twice";
}

TEST(ExternalTest, ProblemsOfTheOtherFormsAreRefusedOrGiven) {
  const auto contact = client(EXTERNAL_FAULTS, "contact");
  const Answer refused = run(*contact, "right");
  EXPECT_STREQ(to_string(refused.claim), "unsupported");
  EXPECT_NE(refused.detail.find("needs the contact problem"), std::string::npos) << refused.detail;
}

// An arm that runs into its stop: without the setting the program gets contacts in place of the rows.
TEST(ExternalTest, BoundedRowsAreGivenToProgramsThatKnowThem) {
  ContactProblem arm{.v = Vector{{-1}}, .N = Matrix(1, 0), .D = Matrix(1, 0), .mu = Vector(0),
                     .inertia = DenseInertia{Matrix{{2}}}};
  arm.rows = {.R = Matrix{{1}}, .bounds = LcpBounds::nonnegative(1), .b = Vector{{0.2}}, .is_angle = {1}};
  const auto answer_with = [&](const char* rows) {
    const auto solver = worker_solver(
        EXTERNAL_WORKER, Spec{"external", {{"command", EXTERNAL_FAULTS}, {"form", "contact"}, {"rows", rows}}}, {});
    TimedAnswer result;
    solver->run(Problem("bounded_rows", arm), kPatient, result);
    return result.answer;
  };
  const Answer given = answer_with("true");
  EXPECT_EQ(given.claim, Claim::kSolved) << given.detail;
  EXPECT_EQ(given.z, (Vector{{1.6}}));
  const Answer contacts = answer_with("false");
  EXPECT_EQ(contacts.claim, Claim::kUnsupported);
  EXPECT_EQ(contacts.detail, "got 1 contact");
}

// A message holds what the problem file of the same problem holds, number for number, on one line.
void expect_message_is_the_file(const Problem& as_file) {
  const std::string message = external::problem_message(as_file);
  EXPECT_EQ(message.find('\n'), std::string::npos);
  const nlohmann::json json = nlohmann::json::parse(message);
  EXPECT_EQ(json.at("verb"), "problem");
  EXPECT_EQ(json.at("problem"), nlohmann::json::parse(problem_json(as_file)));
  EXPECT_EQ(problem_hash(parse_problem_json(json.at("problem").dump(), "message")), problem_hash(as_file));
}

TEST(ExternalMessageTest, ProblemsAreGivenAsInTheProblemFile) {
  for (const char* set : {"paper/monotone/exp1", "paper/monotone/exp2", "paper/copositive/exp1", "rigid/exp1"}) {
    const Problem problem = open_set(set)->generate(7, 3);
    expect_message_is_the_file(Problem(problem.name(), problem.lcp()));
    expect_message_is_the_file(Problem(problem.name(), *problem.contact()));
    if (problem.scene() != nullptr) expect_message_is_the_file(problem);
  }
  ContactProblem with_rows = *open_set("paper/monotone/exp1")->generate(7, 3).contact();
  with_rows.rows = {.R = Matrix::Ones(with_rows.ngc(), 1),
                    .bounds = LcpBounds::nonnegative(1),
                    .is_angle = {1},
                    .names = {"hinge"}};
  expect_message_is_the_file(Problem("rows", with_rows));
  const Problem odd("a \"name\"", Lcp{Matrix{{-0.0, 4.9e-324}, {1e308, 0.1}}, Vector{{3.0, -1.0 / 3.0}}});
  const nlohmann::json json = nlohmann::json::parse(external::problem_message(odd));
  EXPECT_TRUE(std::signbit(json["problem"]["M"][0][0].get<double>()));
  EXPECT_EQ(json["problem"]["M"][0][1].get<double>(), 4.9e-324);
  EXPECT_EQ(json["problem"]["q"][1].get<double>(), -1.0 / 3.0);
}

TEST(ExternalMessageTest, CommandsAreSplitAtSpacesOutsideQuotes) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(external::command_words("a"), Words{"a"});
  EXPECT_EQ(external::command_words("  a  b\t "), (Words{"a", "b\t"}));
  EXPECT_EQ(external::command_words("a 'b \"c' \"d 'e\"f ''"), (Words{"a", "b \"c", "d 'ef", ""}));
  for (const char* wrong : {"", "  ", "''", "a 'b", "a \"b'"}) EXPECT_THROW(external::command_words(wrong), InputError);
}

}  // namespace
}  // namespace lcpbench
