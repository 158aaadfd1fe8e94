// Any program, in any language, as a solver: problems on its standard input, answers on its standard output, as JSON.
#include <cstddef>
#include <string>
#include <utility>

#include "adapters/define_adapter.h"
#include "core/error.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <unordered_map>
#include <vector>

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "adapters/external/external_json.h"
#include "adapters/external/external_program.h"
#include "adapters/worker/start_directory.h"
#include "adapters/worker/child_processes.h"
#include "adapters/worker/control_group.h"
#include "adapters/worker/self_timed.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{.guarantees = "whatever the program guarantees", .obeys_time_limit = true};

struct ExternalSettings {
  std::string command;
  ProblemKind form = ProblemKind::kLcp;

  void visit(auto&& field) {
    field("command", command, "the program and its arguments, separated by spaces; quotes keep spaces together");
    field("form", form,
          Choices<ProblemKind>{
              {{"lcp", ProblemKind::kLcp}, {"contact", ProblemKind::kContact}, {"scene", ProblemKind::kScene}}},
          "what the program is given: (q, M); or v, N, D, mu, G; or bodies and contacts");
  }
};

class External;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// Longest part of a command in a message.
constexpr std::size_t kShownCommand = 200;
/// The repeats of a problem, sending it included, take at most this number times `repeat_until_s`. That is half of the
/// time that the main program allows this worker.
constexpr double kPatience = 20.0;
/// Repeats of one run: two runs on one problem, as `bench` makes them, do not use up its multiples.
constexpr int kMostRepeats = external::kMultiples / 2 - 1;
constexpr const char* kVersion1Note = "protocol version 1: a late second answer cannot be told apart";

/// This process ends by a fault of its own.
void end_all_and_die(int fault) {
  worker::end_children();
  worker::remove_control_group();
  raise(fault);  // the handler is gone (SA_RESETHAND): the parent sees what it was
}

/// From now on the end of lcpbench ends the program, its children and its daemons; so far it ends this process alone.
/// The program that started this worker ends it in the same way. A crash of this process ends them too; only SIGKILL
/// leaves daemons.
void end_all_with_parent() {
  const pid_t parent = getppid();
  worker::adopt_orphans();
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
    struct sigaction action {};
    if (sigaction(fault, nullptr, &action) != 0 || action.sa_handler != SIG_DFL) continue;  // a sanitizer's stays
    action.sa_handler = end_all_and_die;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(fault, &action, nullptr);
  }
  signal(SIGTERM, [](int) {
    worker::end_children();
    worker::remove_control_group();
    kill(0, SIGKILL);
  });
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) kill(0, SIGKILL);
}

/// The memory that each process may have, for all that the program starts together, where the system has groups for
/// that.
void limit_all_together() {
  rlimit memory{};
  if (getrlimit(RLIMIT_AS, &memory) != 0 || memory.rlim_cur == RLIM_INFINITY) return;
  worker::make_control_group(worker::group_folders(), worker::group_limits(memory.rlim_cur));
}

void add_note(const std::string& note, Answer& answer) {
  if (!note.empty()) answer.detail += (answer.detail.empty() ? "" : "; ") + note;
}

class External final : public Solver, public SelfTimed {
 public:
  explicit External(ExternalSettings settings) : settings_(std::move(settings)) {
    switch (settings_.form) {
      case ProblemKind::kLcp: capabilities_.needs = Needs::kDense; break;
      case ProblemKind::kContact: capabilities_.needs = Needs::kFactored; break;
      case ProblemKind::kScene: capabilities_.needs = Needs::kScene; break;
    }
    signal(SIGPIPE, SIG_IGN);
    end_all_with_parent();
    limit_all_together();
    start();
  }

  const Capabilities& capabilities() const override { return capabilities_; }

  void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) override {
    result = TimedAnswer{};
    times_ = SolveTimes{};
    time_limit_s_ = request.time_limit_s;
    const double begin_s = wall_clock_s();
    try {
      deadline_s_ = begin_s + time_limit_s_;
      load(problem);
      solve({.time_limit_s = request.time_limit_s}, result.answer);
      if (result.answer.claim != Claim::kUnsupported) {
        if (version_ == 1) add_note(kVersion1Note, result.answer);
        deadline_s_ += kPatience * request.repeat_until_s;
        add_note(repeat(problem, request, result.answer), result.answer);
      }
    } catch (const external::ProgramFailure& failure) {
      result = TimedAnswer{};
      result.answer.claim = failure.claim();
      result.answer.detail = failure.what();
      times_ = SolveTimes{};
      times_.solve_wall_s = wall_clock_s() - begin_s;
    }
    // By the wall clock: whatever the program uses, threads, children or a graphics card, this misses none of it.
    times_.setup_cpu_s = times_.setup_wall_s;
    times_.solve_cpu_s = times_.solve_wall_s;
    result.times = times_;
    if (program_ != nullptr) worker::reap_orphans(program_->id());
  }

  bool usable() const override { return program_ != nullptr && !program_->dead() && !worn_; }

 protected:
  void on_load(const Problem& problem) override {
    sizes_ = worker::answer_sizes(problem);
    present(problem, {});
  }

  void on_solve(const SolveRequest&, Answer& answer) override {
    const double begin_s = wall_clock_s();
    const std::string text = ask("solve", external::solve_message(time_limit_s_), external::longest_answer(sizes_));
    times_.solve_wall_s = wall_clock_s() - begin_s;
    try {
      answer = external::parse_answer(text, sizes_, expected());
    } catch (const external::BadAnswer& bad) {
      give_up("solve", bad);
    }
  }

 private:
  void start() {
    const std::vector<std::string> words = external::command_words(settings_.command);
    deadline_s_ = wall_clock_s() + program_start_s();
    try {
      try {
        start(words, external::kVersion);
      } catch (const external::ProgramFailure& failure) {
        // A program of version 1 may refuse a version that it does not know: it is asked again, in its own.
        if (failure.claim() == Claim::kTimeLimit) throw;
        start(words, 1);
      }
    } catch (const external::ProgramFailure& failure) {
      throw InputError("external: the program '" + settings_.command.substr(0, kShownCommand) +
                       "' did not print {\"sequence\": 1} as its first line, and flush it: " + failure.what() +
                       (failure.claim() == Claim::kTimeLimit ? "; if it starts slowly, raise --time-limit"
                                                             : "; run it in a terminal to see why") +
                       " (docs/reference/external.md)");
    }
  }

  void start(const std::vector<std::string>& words, int version) {
    program_ = std::make_unique<external::ExternalProgram>(words);
    told_version_ = version;
    constexpr std::size_t kLongestGreeting = 1024;
    const std::string text = program_->ask(next_line(external::start_message(version)), kLongestGreeting, deadline_s_);
    try {
      version_ = external::parse_start(text, sequence_);
    } catch (const external::BadAnswer& bad) {
      program_.reset();
      throw external::ProgramFailure(Claim::kCrashed, std::string("printed another line: ") + bad.what());
    }
  }

  /// Hands over a multiple of the problem and has it set up, which is timed. False, and nothing is asked, when the
  /// multiple is not exact.
  bool present(const Problem& problem, const external::Multiple& multiple) {
    const double begin_s = wall_clock_s();
    const Lcp lcp = settings_.form == ProblemKind::kLcp ? make_lcp(problem) : Lcp{};
    const double formed_s = wall_clock_s();
    if (!multiple.is_problem() && !external::is_exact(multiple, problem, settings_.form, lcp)) return false;
    const std::string message = external::problem_message(problem, settings_.form, lcp, multiple);
    if (multiple.is_problem()) note_question(message);
    acknowledge("problem", message);
    const double set_up_s = wall_clock_s();
    acknowledge("setup", external::setup_message());
    times_.transport_s = set_up_s - formed_s;
    times_.setup_wall_s = formed_s - begin_s + wall_clock_s() - set_up_s;
    return true;
  }

  /// Whether this process of the program has had the problem before, and how many multiples of it.
  void note_question(const std::string& message) {
    const auto [known, first] = multiples_asked_.try_emplace(std::hash<std::string>{}(message), 0);
    asked_before_ = !first;
    asked_ = &known->second;
  }

  /// Times short set-ups and solves again, and those of a problem that the program has had before: each time with a
  /// multiple of the problem that it has not had, so that no answer can be a kept one. Their mean is the time when each
  /// answer is the first one's multiple. @returns a note when it is not, or there was none; else "".
  std::string repeat(const Problem& problem, const TimedRequest& request, const Answer& first) {
    const SolveTimes once = times_;
    const double once_s = once.setup_wall_s + once.solve_wall_s;
    const double begin_s = wall_clock_s();
    const bool is_short = once_s < request.repeat_until_s;
    // An answer that was kept comes fast: one that leaves no room for another solve was not.
    const bool is_in_doubt = asked_before_ && request.repeat_until_s > 0 && 2 * once_s < deadline_s_ - begin_s;
    if (!is_short && !is_in_doubt) return {};
    const double wanted = is_short ? std::ceil(request.repeat_until_s / once_s) : 1;
    const int most =
        static_cast<int>(std::min<double>({wanted, kMostRepeats, static_cast<double>(request.max_repeats)}));
    SolveTimes sum;
    double longest_s = once.solve_wall_s;
    int repeats = 0;
    std::string why;
    try {
      Answer again;
      for (bool tried = false; why.empty() && repeats < most && *asked_ < external::kMultiples; tried = true) {
        if (tried && wall_clock_s() - begin_s > kPatience * request.repeat_until_s) break;
        const external::Multiple multiple = external::multiple_for(settings_.form, *asked_);
        ++*asked_;
        if (!present(problem, multiple)) continue;  // the next one may be exact
        on_solve({}, again);
        ++repeats;
        sum.setup_wall_s += times_.setup_wall_s;
        sum.solve_wall_s += times_.solve_wall_s;
        longest_s = std::max(longest_s, times_.solve_wall_s);
        why = external::difference(first, again, multiple);
      }
    } catch (const external::ProgramFailure& failure) {
      why = failure.what();
      longest_s = std::max(longest_s, wall_clock_s() - begin_s);
    }
    worn_ = *asked_ >= external::kMultiples;
    times_ = once;
    if (why.empty() && repeats > 0) {
      times_.repeats = repeats;
      times_.setup_wall_s = sum.setup_wall_s / repeats;
      times_.solve_wall_s = sum.solve_wall_s / repeats;
      return {};
    }
    if (asked_before_) times_.solve_wall_s = longest_s;  // the first answer may be one that was kept
    if (!why.empty()) return "the time is that of one solve, since the repeats on scaled copies failed: " + why;
    return asked_before_ ? "the time is that of one solve, on a problem that the program had solved before" : "";
  }

  void acknowledge(const char* verb, const std::string& message) {
    constexpr std::size_t kLongestAcknowledgement = 1024;
    const std::string text = ask(verb, message, kLongestAcknowledgement);
    try {
      external::parse_acknowledgement(text, expected());
    } catch (const external::BadAnswer& bad) {
      give_up(verb, bad);
    }
  }

  std::string ask(const char* verb, const std::string& message, std::size_t max_bytes) {
    try {
      return program_->ask(next_line(message), max_bytes, deadline_s_);
    } catch (const external::ProgramFailure& failure) {
      throw external::ProgramFailure(failure.claim(), std::string(verb) + ": " + failure.what());
    }
  }

  /// A question as it is sent: version 1 knew no numbers.
  std::string next_line(const std::string& message) {
    ++sequence_;
    return told_version_ > 1 ? external::numbered(message, sequence_) : message;
  }

  external::Expected expected() const { return {sequence_, version_ > 1}; }

  [[noreturn]] void give_up(const char* verb, const external::BadAnswer& bad) {
    program_.reset();
    throw external::ProgramFailure(Claim::kCrashed, std::string(verb) + ": returned no answer: " + bad.what());
  }

  ExternalSettings settings_;
  Capabilities capabilities_ = kCapabilities;
  std::unique_ptr<external::ExternalProgram> program_;
  int told_version_ = external::kVersion;  ///< of the protocol, in "start"
  int version_ = 1;                        ///< that the program speaks
  std::uint64_t sequence_ = 0;
  /// By the hash of each problem that the program has had: how many multiples of it, it has had.
  std::unordered_map<std::size_t, int> multiples_asked_;
  int* asked_ = nullptr;  ///< the entry of the problem that was presented last
  bool asked_before_ = false;
  bool worn_ = false;  ///< it has had all multiples of a problem: the next one is for a fresh process
  worker::AnswerSizes sizes_;
  SolveTimes times_;
  double time_limit_s_ = 0;
  double deadline_s_ = 0;
};

#endif

/// There is no program to fall back on.
template <Options (*settings_of)(const ExternalSettings&)>
Options checked_settings(const Options& options) {
  const auto settings = parse_settings<ExternalSettings>("external", options);
  if (settings.command.empty()) throw InputError("external: command is not set: external{command=./mine.py}");
  return settings_of(settings);
}

}  // namespace

SolverDefinition lcpbench_solver_external() {
  SolverDefinition definition = define_adapter<External, ExternalSettings>(
      {.name = "external",
       .summary = "any program: problems on its standard input, answers on its standard output",
       .source = "yours; docs/reference/external.md shows how",
       .capabilities = kCapabilities});
  definition.all_settings = checked_settings<all_settings<ExternalSettings>>;
  definition.changed_settings = checked_settings<changed_settings<ExternalSettings>>;
  return definition;
}

}  // namespace lcpbench
