// Any program, in any language, as a solver: problems on its standard input, answers on its standard output, as JSON.
#include <cstddef>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/registry.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <algorithm>
#include <cmath>
#include <memory>

#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "adapters/external_json.h"
#include "adapters/external_program.h"
#include "adapters/self_timed.h"
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

#ifndef LCPBENCH_DESCRIBE_ONLY

/// How long a program may take from its start to its first answer: a little less than a worker may.
constexpr double kStartTimeout_s = 18.0;

/// From now on the end of lcpbench ends the whole process group, the program and its children with it; so far it ends
/// this process alone.
void end_group_with_parent() {
  const pid_t parent = getppid();
  signal(SIGTERM, [](int) { kill(0, SIGKILL); });
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
    signal(SIGPIPE, SIG_IGN);
    end_group_with_parent();
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
      if (result.answer.claim != Claim::kUnsupported) repeat(request);
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
    result.times.transport_s = wall_clock_s() - begin_s - times_.repeats * (times_.setup_wall_s + times_.solve_wall_s);
  }

  bool usable() const override { return program_ != nullptr && !program_->dead(); }

 protected:
  void on_load(const Problem& problem) override {
    sizes_ = worker::answer_sizes(problem);
    const double begin_s = wall_clock_s();
    const Lcp lcp = settings_.form == ProblemKind::kLcp ? make_lcp(problem) : Lcp{};
    const double forming_M_s = wall_clock_s() - begin_s;
    acknowledge("problem", external::problem_message(problem, settings_.form, lcp));
    times_.setup_wall_s = forming_M_s + set_up();
  }

  void on_solve(const SolveRequest&, Answer& answer) override {
    const double begin_s = wall_clock_s();
    const std::string text = ask("solve", external::solve_message(time_limit_s_), external::longest_answer(sizes_));
    times_.solve_wall_s = wall_clock_s() - begin_s;
    try {
      answer = external::parse_answer(text, sizes_);
    } catch (const external::BadAnswer& bad) {
      give_up("solve", bad);
    }
  }

 private:
  void start() {
    program_ = std::make_unique<external::ExternalProgram>(external::command_words(settings_.command));
    deadline_s_ = wall_clock_s() + kStartTimeout_s;
    try {
      acknowledge("start", external::start_message());
    } catch (const external::ProgramFailure& failure) {
      const char* const hint = failure.claim() == Claim::kTimeLimit ? " (does it flush its answers?)" : "";
      throw InputError("external: " + settings_.command + ": " + failure.what() + hint);
    }
  }

  /// Seconds.
  double set_up() {
    const double begin_s = wall_clock_s();
    acknowledge("setup", external::setup_message());
    return wall_clock_s() - begin_s;
  }

  /// Short set-ups and solves again, in batches, as timed_solve() does.
  void repeat(const TimedRequest& request) {
    const double once_s = times_.setup_wall_s + times_.solve_wall_s;
    if (!(once_s < request.repeat_until_s)) return;
    const int repeats =
        static_cast<int>(std::min<double>(request.max_repeats, std::ceil(request.repeat_until_s / once_s)));
    double setup_s = 0;
    double solve_s = 0;
    Answer again;
    for (int i = 0; i < repeats; ++i) {
      deadline_s_ = wall_clock_s() + time_limit_s_;
      setup_s += set_up();
      on_solve({}, again);
      solve_s += times_.solve_wall_s;
    }
    times_.repeats = repeats;
    times_.setup_wall_s = setup_s / repeats;
    times_.solve_wall_s = solve_s / repeats;
  }

  void acknowledge(const char* verb, const std::string& message) {
    constexpr std::size_t kLongestAcknowledgement = 1024;
    const std::string text = ask(verb, message, kLongestAcknowledgement);
    try {
      external::parse_acknowledgement(text);
    } catch (const external::BadAnswer& bad) {
      give_up(verb, bad);
    }
  }

  std::string ask(const char* verb, const std::string& message, std::size_t max_bytes) {
    try {
      return program_->ask(message, max_bytes, deadline_s_);
    } catch (const external::ProgramFailure& failure) {
      throw external::ProgramFailure(failure.claim(), std::string(verb) + ": " + failure.what());
    }
  }

  [[noreturn]] void give_up(const char* verb, const external::BadAnswer& bad) {
    program_.reset();
    throw external::ProgramFailure(Claim::kCrashed, std::string(verb) + ": returned no answer: " + bad.what());
  }

  ExternalSettings settings_;
  Capabilities capabilities_ = kCapabilities;
  std::unique_ptr<external::ExternalProgram> program_;
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
  SolverDefinition definition{.name = "external",
                              .summary = "any program: problems on its standard input, answers on its standard output",
                              .source = "yours; docs/external.md shows how",
                              .capabilities = kCapabilities};
#ifdef LCPBENCH_DESCRIBE_ONLY
  definition = with_settings<ExternalSettings>(std::move(definition));
#else
  definition = define_solver<External, ExternalSettings>(std::move(definition));
#endif
  definition.all_settings = checked_settings<all_settings<ExternalSettings>>;
  definition.changed_settings = checked_settings<changed_settings<ExternalSettings>>;
  return definition;
}

}  // namespace lcpbench
