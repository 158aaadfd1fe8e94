// Any program, in any language, as a solver: problems on its standard input, answers on its standard output, as JSON.
#include <cstddef>
#include <string>
#include <utility>

#include "adapters/define_adapter.h"
#include "core/error.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "adapters/external/external_json.h"
#include "adapters/worker/asked_program.h"
#include "adapters/worker/child_processes.h"
#include "adapters/worker/self_timed.h"
#include "adapters/worker/start_directory.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kExternalCapabilities{
    .friction_setting = "cone=true", .guarantees = "whatever the program guarantees", .obeys_time_limit = true};

struct ExternalSettings {
  std::string command;
  ProblemKind form = ProblemKind::kLcp;
  bool cone = false;
  bool compliance = false;
  bool rows = false;
  bool warm_start = false;
  bool writes_files = false;
  std::string name;

  void visit(auto&& field) {
    field("command", command, "the program and its arguments, separated by spaces; quotes keep spaces together");
    field("form", form,
          Choices<ProblemKind>{
              {{"lcp", ProblemKind::kLcp}, {"contact", ProblemKind::kContact}, {"scene", ProblemKind::kScene}}},
          "what the program is given: (q, M); or v, N, D, mu, G; or bodies and contacts");
    field("cone", cone, "its friction is the round cone, by which its answers are judged");
    field("compliance", compliance,
          "whether it knows compliance_n, compliance_t and offset_t: it is then given soft contacts as they are, and "
          "else, in the form contact, their rigid equivalent");
    field("rows", rows,
          "whether it knows bounded rows: in the form contact it is then given them as they are, and else contacts that "
          "have the same solutions");
    field("warm_start", warm_start,
          "whether it can begin from a guess at z, which it is then given with `run --start last`");
    field("writes_files", writes_files,
          "whether it may write files of more than 4 KiB, as a runtime does that keeps a cache (numba)");
    field("name", name, "what tables call it");
  }
};

class External;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// Longest part of a command in a message.
constexpr std::size_t kShownCommand = 200;
constexpr std::size_t kLongestAcknowledgement = 1024;
constexpr const char* kVersion1Note = "protocol version 1: a late second answer cannot be told apart";

/// Names the limit on files where it seems to be what the program died of.
std::string about_file_limit(const std::string& failure) {
  for (const char* sign : {"File too large", "SIGXFSZ", "EFBIG"}) {
    if (failure.find(sign) == std::string::npos) continue;
    return "; it may write no file of more than 4 KiB: writes_files=true lifts this limit";
  }
  return "";
}

/// This process ends by a fault of its own.
void end_all_and_die(int fault) {
  worker::end_children();
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
    kill(0, SIGKILL);
  });
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) kill(0, SIGKILL);
}

class External final : public Solver, public SelfTimed {
 public:
  explicit External(ExternalSettings settings) : settings_(std::move(settings)) {
    switch (settings_.form) {
      case ProblemKind::kLcp: capabilities_.needs = Needs::kDense; break;
      case ProblemKind::kContact: capabilities_.needs = Needs::kFactored; break;
      case ProblemKind::kScene: capabilities_.needs = Needs::kScene; break;
    }
    capabilities_.warm_start = settings_.warm_start;
    capabilities_.compliance = settings_.compliance || settings_.form == ProblemKind::kLcp;  // M has it
    capabilities_.rows = settings_.rows && settings_.form == ProblemKind::kContact;
    signal(SIGPIPE, SIG_IGN);
    end_all_with_parent();
    rlimit size{};
    if (settings_.writes_files && getrlimit(RLIMIT_FSIZE, &size) == 0) {
      size.rlim_cur = size.rlim_max;
      setrlimit(RLIMIT_FSIZE, &size);
    }
    start();
  }

  const Capabilities& capabilities() const override { return capabilities_; }

  void run(const Problem& problem, const TimedRequest& request, TimedAnswer& result) override {
    result = TimedAnswer{};
    times_ = SolveTimes{};
    const double begin_s = wall_clock_s();
    try {
      deadline_s_ = begin_s + request.time_limit_s;
      load(problem);
      solve({.start = request.start, .time_limit_s = request.time_limit_s}, result.answer);
      if (version_ == 1 && result.answer.claim != Claim::kUnsupported) {
        result.answer.detail += (result.answer.detail.empty() ? "" : "; ") + std::string(kVersion1Note);
      }
    } catch (const worker::NoAnswer& failure) {
      result = TimedAnswer{};
      result.answer.claim = failure.claim();
      result.answer.detail = failure.what() + about_file_limit(failure.what());
      times_ = SolveTimes{};
      times_.solve_wall_s = wall_clock_s() - begin_s;
    }
    // By the wall clock: whatever the program uses, threads, children or a graphics card, this misses none of it.
    times_.setup_cpu_s = times_.setup_wall_s;
    times_.solve_cpu_s = times_.solve_wall_s;
    result.times = times_;
    if (program_ != nullptr) worker::reap_orphans(program_->id());
  }

  bool usable() const override { return program_ != nullptr && !program_->dead(); }

 protected:
  void on_load(const Problem& problem) override {
    sizes_ = worker::answer_sizes(problem);
    const double begin_s = wall_clock_s();
    // "scene" needs a scene and "contact" contacts: the capabilities say so, and others are refused before this.
    std::optional<Problem> as_given;
    if (settings_.form == ProblemKind::kLcp) as_given.emplace(problem.name(), finite_lcp(problem));
    if (settings_.form == ProblemKind::kContact) as_given.emplace(problem.name(), *problem.contact());
    const double formed_s = wall_clock_s();
    acknowledge("problem", external::problem_message(as_given ? *as_given : problem));
    const double set_up_s = wall_clock_s();
    acknowledge("setup", external::setup_message());
    times_.transport_s = set_up_s - formed_s;
    times_.setup_wall_s = formed_s - begin_s + wall_clock_s() - set_up_s;
  }

  void on_solve(const SolveRequest& request, Answer& answer) override {
    const Vector* start = settings_.warm_start ? request.start : nullptr;
    const double begin_s = wall_clock_s();
    ask("solve", external::solve_message(request.time_limit_s, start), external::longest_answer(sizes_),
        [&](const auto& text) {
          times_.solve_wall_s = wall_clock_s() - begin_s;
          answer = external::parse_answer(text, sizes_, expected());
        });
  }

 private:
  void start() {
    const std::vector<std::string> words = external::command_words(settings_.command);
    deadline_s_ = wall_clock_s() + program_start_s();
    try {
      try {
        start(words, external::kVersion);
      } catch (const worker::NoAnswer& failure) {
        // A program of version 1 may refuse a version that it does not know: it is asked again, in its own.
        if (failure.claim() == Claim::kTimeLimit) throw;
        start_again(words, failure.what());
      }
    } catch (const worker::NoAnswer& failure) {
      throw InputError("external: the program '" + settings_.command.substr(0, kShownCommand) +
                       "' did not print {\"sequence\": 1} as its first line, and flush it: " + failure.what() +
                       about_file_limit(failure.what()) +
                       (failure.claim() == Claim::kTimeLimit
                            ? "; if it starts slowly, raise --time-limit, or time_limit_s of a plan"
                            : "; run it in a terminal to see why") +
                       " (docs/reference/external.md)");
    }
  }

  /// @param cause  of the failure in the version that most programs speak: what is wrong with such a one
  void start_again(const std::vector<std::string>& words, const std::string& cause) {
    try {
      start(words, 1);
    } catch (const worker::NoAnswer& failure) {
      if (failure.what() == cause) throw;
      throw worker::NoAnswer(failure.claim(), cause + "; then, asked in version 1: " + failure.what());
    }
  }

  void start(const std::vector<std::string>& words, int version) {
    try {
      program_ = std::make_unique<worker::AskedProgram>(words, worker::AskedProgram::Channel::kStandard,
                                                        start_directory());
    } catch (const InputError& error) {
      throw InputError(std::string("external: ") + error.what() +
                       "; docs/reference/external.md says how to name a program");
    }
    told_version_ = version;
    const std::string text = next_answer(external::start_message(version), kLongestAcknowledgement);
    try {
      version_ = external::parse_start(text, sequence_);
    } catch (const worker::BadMessage& bad) {
      program_.reset();
      throw worker::NoAnswer(Claim::kCrashed, std::string("printed another line: ") + bad.what());
    }
  }

  void acknowledge(const char* verb, const std::string& message) {
    ask(verb, message, kLongestAcknowledgement,
        [&](const auto& text) { external::parse_acknowledgement(text, expected()); });
  }

  /// Asks, and has the answer read by `parse`.
  template <class Parse>
  void ask(const char* verb, const std::string& message, std::size_t max_bytes, Parse&& parse) {
    const std::string asked = std::string(verb) + ": ";
    try {
      parse(next_answer(message, max_bytes));
    } catch (const worker::NoAnswer& failure) {
      throw worker::NoAnswer(failure.claim(), asked + failure.what());
    } catch (const worker::BadMessage& bad) {
      program_.reset();
      throw worker::NoAnswer(Claim::kCrashed, asked + "returned no answer: " + bad.what());
    }
  }

  /// The line with which the program answers the next question. Version 1 knew no numbers.
  std::string next_answer(const std::string& message, std::size_t max_bytes) {
    ++sequence_;
    const std::string question = told_version_ > 1 ? external::numbered(message, sequence_) : message;
    std::string answer = program_->ask(question + "\n", external::line_size, max_bytes, deadline_s_);
    answer.pop_back();
    return answer;
  }

  external::Expected expected() const { return {sequence_, version_ > 1}; }

  ExternalSettings settings_;
  Capabilities capabilities_ = kExternalCapabilities;
  std::unique_ptr<worker::AskedProgram> program_;
  int told_version_ = external::kVersion;  ///< of the protocol, in "start"
  int version_ = 1;                        ///< that the program speaks
  std::uint64_t sequence_ = 0;
  worker::AnswerSizes sizes_;
  SolveTimes times_;
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
       .capabilities = kExternalCapabilities});
  definition.all_settings = checked_settings<all_settings<ExternalSettings>>;
  definition.changed_settings = checked_settings<changed_settings<ExternalSettings>>;
  return definition;
}

}  // namespace lcpbench
