#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <numbers>
#include <string_view>

#include <unistd.h>

#include "adapters/worker/worker_client.h"
#include "core/io/scenes_file.h"
#include "core/round_cone.h"
#include "study/certificates/certify_store.h"
#include "study/certificates/judge.h"
#include "study/commands/commands.h"
#include "study/commands/problem_files.h"
#include "study/commands/solve_models.h"
#include "study/commands/solve_total.h"
#include "study/evaluation/fastest_contact.h"
#include "study/evaluation/bounded_row_states.h"
#include "study/models/ladder.h"
#include "study/models/pyramid.h"
#include "study/output/columns.h"
#include "study/output/solution_text.h"
#include "study/report/sets.h"
#include "study/run/open_solver.h"
#include "study/run/study.h"

namespace lcpbench {
namespace {

struct SolveArguments {
  std::vector<std::string> files;
  std::vector<std::string> solvers;
  double time_limit_s = 10.0;
  double max_velocity_error = 0;  ///< m/s; 0: the problem's own model of friction
  std::optional<double> solved_at;
  bool json = false;
};

struct Attempt {
  SolverRow solver;
  FrictionModel model = FrictionModel::kPyramid;  ///< that the answer is measured by
  TimedAnswer timed;
  Judgement judgement;
  Truth truth = Truth::kUnknown;  ///< of the problem
  double least_violation_m_per_s = std::numeric_limits<double>::quiet_NaN();  ///< proven of every answer; NaN: nothing
  Verdict verdict = Verdict::kOpen;
  Vector velocity;
  std::string note;  ///< why there are no errors; "" when there are
  std::string why;   ///< why the verdict is not solved; "" when it is
  std::size_t place = 0;  ///< among the solvers as they were asked for
  std::string label;      ///< solver_label(); of the solver `engine` with the engine's name and version

  /// Set-up and solve, thread CPU time: what other programs do at the moment is not the solver's. Infinite where no
  /// time is known.
  double time_s() const {
    const double time = timed.times.setup_cpu_s + timed.times.solve_cpu_s;
    return std::isnan(time) ? std::numeric_limits<double>::infinity() : time;
  }
};

/// Which solvers run, each opened once for all files.
class Solvers {
 public:
  explicit Solvers(const std::vector<std::string>& asked_for) : asked_for_(solver_specs(asked_for)) {
    for (const Spec& spec : asked_for_) opened(spec);
  }

  /// Those asked for; else all that can run here and take the problem.
  std::vector<Spec> choose(const Problem& problem, const std::string& file) const {
    std::vector<Spec> fitting = asked_for_.empty() ? those_that_take(problem) : asked_for_;
    for (Spec& spec : fitting) spec = judged_as_solved(spec, problem, file);
    return fitting;
  }

  /// Whether the user named the solvers.
  bool named() const { return !asked_for_.empty(); }

  TimedSolver& opened(const Spec& spec) {
    std::unique_ptr<TimedSolver>& solver = opened_[spec.text()];
    if (solver == nullptr) solver = open_solver(spec);
    return *solver;
  }

 private:
  static std::vector<Spec> those_that_take(const Problem& problem) {
    std::vector<Spec> fitting;
    for (const RegisteredSolver& solver : registered_solvers()) {
      const Capabilities& capabilities = solver.definition.capabilities;
      if (!(runs_unasked(solver) || capabilities.captured_only) || !why_not(capabilities, problem).empty()) continue;
      fitting.push_back({solver.definition.name, {}});
    }
    return fitting;
  }

  std::vector<Spec> asked_for_;
  std::map<std::string, std::unique_ptr<TimedSolver>> opened_;
};

/// @param once  no solve is repeated for its time: see are_timed_once()
Attempt attempt(const Problem& problem, const Spec& spec, TimedSolver& solver, Judge& judge, double time_limit_s,
                bool once) {
  Attempt result;
  result.solver = solver_row(spec);
  const EngineAnswer* const engine = problem.engine_answer();
  result.label = solver_label(result.solver.text(), engine != nullptr ? engine->engine : "");
  TimedRequest request;
  request.time_limit_s = time_limit_s;
  request.repeat_until_s = once ? 0 : kRepeatUntilS;
  solver.run(problem, request, result.timed);
  const Answer& answer = result.timed.answer;
  result.model = friction_model(result.solver.friction, problem);
  result.judgement = judge.judgement(judge.judge(answer, result.model));
  result.note = why_without_errors(answer, problem.size());
  result.velocity = answer.velocity;
  if (result.velocity.size() == 0 && problem.contact() != nullptr && result.judgement.errors.usable) {
    result.velocity = post_impact_velocity(*problem.contact(), answer.z);
  }
  return result;
}

bool has_rows(const Problem& problem) { return problem.contact() != nullptr && problem.contact()->has_rows(); }

/// How the truth of the problem is known, in words; "" where it is not.
std::string because(const Judge& judge, const std::vector<Attempt>& attempts) {
  const auto first = [&](auto holds) { return std::find_if(attempts.begin(), attempts.end(), holds); };
  const auto exact = [&] { return fmt::format("exact proof: {}", to_string(judge.certificate()->proof)); };
  switch (judge.findings().truth()) {
    case Truth::kUnknown: break;
    case Truth::kUnsolvable:
    case Truth::kNearly: {
      const auto proves = first([](const Attempt& a) { return a.judgement.proof_holds; });
      return proves != attempts.end() ? "the proof of " + proves->label + " is valid" : exact();
    }
    case Truth::kSolvable: return judge.findings().has(Evidence::kTheory) ? "by theory" : exact();
    case Truth::kAnswered: {
      const auto solves = [](const Attempt& a) {
        return a.model == FrictionModel::kPyramid && a.judgement.errors.solved;
      };
      return first(solves)->label + " solved it";
    }
  }
  return "";
}

/// The largest proven lower bound on the violation of any answer; NaN without a proof of unsolvability that gives one.
double proven_violation_m_per_s(const Problem& problem, const Judge& judge, const std::vector<Attempt>& attempts) {
  double largest = judge.certificate() ? least_violation(problem, *judge.certificate())
                                       : std::numeric_limits<double>::quiet_NaN();
  for (const Attempt& each : attempts) largest = std::fmax(largest, each.judgement.errors.least_violation_m_per_s);
  return largest;
}

/// Whether a false answer solves the same contacts with a box of friction: each tangent limited by itself, as usual
/// engines do it. A box is the pyramid of 4 edges turned by 45 degrees, with sqrt(2) mu.
std::string box_words(const Problem& problem, const Attempt& attempt) {
  const ContactProblem* const contact = problem.contact();
  const Errors& errors = attempt.judgement.errors;
  const bool fits = attempt.verdict == Verdict::kWrong && attempt.model == FrictionModel::kPyramid && errors.usable &&
                    errors.measure() > errors.limit && contact != nullptr && !contact->has_rows() &&
                    cols(contact->D) > 0 && why_no_round_cone(*contact).empty() &&
                    std::ranges::all_of(contact->edges, [](int edges) { return edges == 0 || edges == 4; });
  if (!fits) return "";
  const auto angles = [&](double angle) { return std::vector(contact->edges.size(), angle); };
  const TangentImpulses given = tangent_impulses(*contact, 4, angles(0), attempt.timed.answer.z);
  ContactProblem box = with_pyramid(*contact, 4, angles(std::numbers::pi / 4));
  box.mu *= std::numbers::sqrt2;
  Answer answer;
  answer.z = pyramid_impulses(box, {given.normal, (given.first + given.second) / std::numbers::sqrt2,
                                    (given.second - given.first) / std::numbers::sqrt2});
  const double residual = Evaluator({problem.name(), box}).errors(answer).measure();
  if (!(residual <= errors.limit)) return "";
  return fmt::format(
      " With a box of friction, |t1| <= mu f_N and |t2| <= mu f_N, its residual is {:.3g}: the problem has the pyramid "
      "|t1| + |t2| <= mu f_N. Write tangents turned by 45 degrees and sqrt(2) mu to compare it by its own friction.",
      residual);
}

/// Of a step whose contacts all part without an impulse, which an engine would have left alone.
std::string parting_words(const ContactProblem& contact) {
  if (contact.has_rows()) return "";
  double least = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < contact.nc(); ++i) {
    least = std::min(least, dot_column(contact.N, i, contact.v) + contact.offset(i));
  }
  if (!(least > 0 && std::isfinite(least))) return "";
  return fmt::format(
      " No contact approaches (least N'v + b {:.3g} m/s), so that nothing would happen: are the normals turned, or "
      "is v the velocity after the impact?",
      least);
}

/// Right answers first, then honest failures, then false claims, then refusals.
int rank(const Attempt& attempt) {
  if (attempt.timed.answer.claim == Claim::kUnsupported) return 4;
  switch (attempt.verdict) {
    case Verdict::kSolved: return 0;
    case Verdict::kUnsolvable: return 1;
    case Verdict::kMissed:
    case Verdict::kOpen: return 2;
    case Verdict::kWrong: return 3;
    case Verdict::kRefused: return 4;
  }
  return 4;
}

/// Runs and judges the chosen solvers; the best attempt comes first, by rank() and then time. A solver whose worker
/// does not start has none: stderr says why, and `all_started` becomes false. Once `*stop` is not 0, no further solver
/// runs.
std::vector<Attempt> attempts_on(const Problem& problem, const std::string& file, Solvers& solvers,
                                 BoundedCertifier& certifier, const SolveArguments& arguments,
                                 const volatile std::sig_atomic_t* stop, ProgressLine& progress, bool& all_started) {
  Judge judge(problem, certifier, arguments.solved_at);
  std::vector<Attempt> attempts;
  const std::vector<Spec> chosen = solvers.choose(problem, file);
  const bool once = are_timed_once(chosen);
  for (const Spec& spec : chosen) {
    if (*stop != 0) break;
    if (progress.is_on_terminal()) progress.show("solving with " + spec.text());
    try {
      attempts.push_back(attempt(problem, spec, solvers.opened(spec), judge, arguments.time_limit_s, once));
      attempts.back().place = attempts.size();
    } catch (const WorkerError& error) {
      all_started = false;
      say(stderr, "lcpbench: {}\n", error.what());
    }
  }
  if (progress.is_on_terminal()) progress.show("explaining the answers");
  const bool is_solved = std::ranges::any_of(attempts, [](const Attempt& each) { return each.judgement.errors.solved; });
  if (!is_solved) judge.settle_few_unknowns();
  const std::string known_by = because(judge, attempts);
  std::optional<std::vector<std::string>> names;
  const double least_violation_m_per_s = proven_violation_m_per_s(problem, judge, attempts);
  for (Attempt& each : attempts) {
    const Answer& answer = each.timed.answer;
    const Errors& errors = each.judgement.errors;
    each.truth = each.model == FrictionModel::kPyramid ? judge.findings().truth() : Truth::kUnknown;
    each.verdict = verdict(answer.claim, errors, each.truth);
    each.least_violation_m_per_s = least_violation_m_per_s;
    if (each.verdict == Verdict::kSolved) continue;
    if (!names) names = contact_names(file);  // which reads the step again
    each.why = why_not_solved(problem, {answer.claim, each.verdict, errors, answer.detail, each.note, known_by,
                                        each.truth, each.model, *names,
                                        each.note.empty() ? &answer.z : nullptr});
    each.why += box_words(problem, each);
    const bool engine_is_wrong = each.solver.name == "engine" && each.verdict == Verdict::kWrong;
    if (engine_is_wrong) each.why += parting_words(*problem.contact());
  }
  progress.clear();
  std::ranges::stable_sort(attempts, {}, [](const Attempt& each) { return std::pair(rank(each), each.time_s()); });
  return attempts;
}

/// @param states  of the problem's bounded rows; nullptr: it has none
Json attempt_json(const Problem& problem, const Json& summary, const Attempt& attempt, BoundedRowStates* states) {
  const Answer& answer = attempt.timed.answer;
  const bool is_measured = states != nullptr && attempt.judgement.errors.usable;
  return {{"problem", summary},
          {"solver", attempt.solver.name},
          {"settings", attempt.solver.settings},
          {"label", attempt.label},
          {"model", to_string(attempt.model)},
          {"claim", to_string(answer.claim)},
          {"verdict", to_string(attempt.verdict)},
          {"truth", to_string(attempt.truth)},
          {"least_violation_m_per_s", json_number(attempt.least_violation_m_per_s)},
          {"why", attempt.why},
          {"z", json_vector(answer.z, attempt.judgement.errors.usable)},
          {"velocity", json_vector(attempt.velocity)},
          {"impulses", to_string(answer.impulses)},
          {"rows", is_measured ? row_states_json(problem.contact()->rows, states->of(answer.z)) : Json()},
          {"errors", errors_json(problem, attempt.judgement.errors)},
          {"time",
           {{"setup_s", json_number(attempt.timed.times.setup_cpu_s)},
            {"solve_s", json_number(attempt.timed.times.solve_cpu_s)},
            {"verify_s", json_number(attempt.judgement.verify_s)}}},
          {"counters",
           {{"iterations", json_count(answer.counters.iterations)},
            {"pivots", json_count(answer.counters.pivots)},
            {"factorizations", json_count(answer.counters.factorizations)}}},
          {"detail", answer.detail + (answer.detail.empty() || attempt.note.empty() ? "" : "; ") + attempt.note}};
}

void print_velocity(const Attempt& best) {
  const std::string numbers = few_numbers(best.velocity);
  if (best.verdict != Verdict::kSolved || numbers.empty()) return;
  say_folded("velocity after the impact ({}) [m/s, rad/s]: {}\n", best.label, numbers);
}

/// Which impulses z has, where others may give the same motion.
void print_impulses(const Problem& problem, const Attempt& best) {
  const ContactProblem* const contact = problem.contact();
  if (best.verdict != Verdict::kSolved || contact == nullptr || best.velocity.size() != contact->ngc()) return;
  if (!may_have_other_impulses(*contact, best.velocity)) return;
  constexpr const char* kAsksForEven = "auto{impulses=even}";
  const bool even = best.timed.answer.impulses == Impulses::kEven;
  const bool in_vain = !even && best.label == kAsksForEven;
  say_folded("other impulses may give the same motion; {} {}\n", best.label,
             even      ? "shows those that equally stiff contacts would carry"
             : in_vain ? "did not find those that equally stiff contacts would carry, and shows any"
                       : "shows those that it reached, auto{impulses=even} looks for those that equally stiff contacts "
                         "would carry");
}

/// The verified answer itself.
void print_solution(const Problem& problem, const std::string& file, const Attempt& best) {
  if (best.verdict != Verdict::kSolved) return;
  say(stdout, "{}",
      solution_text(problem, best.label, best.timed.answer.z, best.velocity, contact_names(file),
                    text_width()));
}

/// Where the pyramid is too coarse: its answer violates the cone's conditions by more than 1 % of the scale.
void print_coarse_model(const Problem& problem, const std::string& file, const Attempt& best) {
  constexpr double kLargestShare = 0.01;
  const double error = best.judgement.errors.model_error_m_per_s;
  if (problem.contact() == nullptr || best.verdict != Verdict::kSolved || best.model != FrictionModel::kPyramid) return;
  const double share = share_of_scale(*problem.contact(), error);
  if (!(share > kLargestShare)) return;
  const std::string ladder =
      has_rows(problem) ? ""
                        : fmt::format("lcpbench models {} compares the models, --max-velocity-error {:.1g} takes the "
                                      "coarsest that suffices, ",
                                      shell_word(file_argument(file)), kLargestShare * error / share);
  say_folded(
      "this pyramid of friction violates Coulomb's round cone by {:.3g} m/s, {:.2g} % of the largest speed at a "
      "contact: {}--solver 'cone_ipm{{cone=true}}' solves the cone\n",
      error, 100 * share, ladder);
}

/// How a verified answer differs from hard contacts with Coulomb friction, in two parts.
struct ModelErrors {
  std::optional<FastestContact> relaxation;  ///< convex model against Coulomb friction, the contacts as given
  std::optional<FastestContact> softness;    ///< these with Coulomb friction, against hard contacts at rest
  std::string without;                       ///< what of softness and moving surfaces the contacts have, in words
};

/// Both parts are missing for all but verified answers to contact problems; each is missing where it does not apply, or
/// where the other model's problem is not solved in time.
ModelErrors model_errors(const Problem& problem, const Attempt& best, double time_limit_s) {
  ModelErrors errors;
  const ContactProblem* const given = problem.contact();
  if (given == nullptr || best.verdict != Verdict::kSolved) return errors;
  const std::unique_ptr<Solver> solver =
      make_solver(best.model == FrictionModel::kPyramid ? Spec{"auto", {}} : solver_of(ContactModel::kCone, 0));
  const auto velocity = [&](const ContactProblem& contact) -> std::optional<Vector> {
    solver->load({problem.name(), contact});
    Answer answer;
    solver->solve({.time_limit_s = time_limit_s}, answer);
    if (answer.claim != Claim::kSolved) return std::nullopt;
    return post_impact_velocity(contact, answer.z);
  };
  std::optional<Vector> coulomb = best.velocity;
  if (best.model == FrictionModel::kConvex) {
    coulomb = velocity(*given);
    if (coulomb) errors.relaxation = fastest_contact(*given, best.velocity - *coulomb);
  }
  if (!coulomb || !given->is_soft()) return errors;
  const bool compliant = given->compliance_n.size() > 0 || given->compliance_t.size() > 0;
  errors.without = !compliant ? "moving surfaces: without tangential offsets"
                   : given->offset_t.size() == 0 ? "softness: without compliance"
                                                 : "softness: without compliance and tangential offsets";
  ContactProblem hard = *given;
  hard.compliance_n = hard.compliance_t = hard.offset_t = Vector();
  if (const auto of_hard = velocity(hard)) errors.softness = fastest_contact(*given, *coulomb - *of_hard);
  return errors;
}

void print_difference(const char* condition, const FastestContact& difference) {
  if (difference.contact < 0) {
    say_folded("{} no contact would move differently\n", condition);
  } else {
    say_folded("{} contact {} would move differently by {:.3g} m/s\n", condition, difference.contact,
               difference.m_per_s);
  }
}

void print_model_errors(const ModelErrors& errors) {
  if (errors.relaxation) print_difference("relaxation: with Coulomb's friction", *errors.relaxation);
  if (errors.softness) print_difference(errors.without.c_str(), *errors.softness);
}

/// The verified answer by the first one's model of friction that moves most differently from it, if by more than
/// least_difference().
void print_spread(const Problem& problem, const std::vector<Attempt>& attempts) {
  const Attempt& first = attempts.front();
  if (first.verdict != Verdict::kSolved || problem.contact() == nullptr) return;
  const ContactProblem& contact = *problem.contact();
  FastestContact worst{least_difference(contact), -1};
  const Attempt* other = nullptr;
  for (const Attempt& each : attempts) {
    const bool comparable = each.verdict == Verdict::kSolved && each.model == first.model &&
                            each.velocity.size() == contact.ngc() && first.velocity.size() == contact.ngc();
    if (!comparable) continue;
    const FastestContact difference = fastest_contact(contact, each.velocity - first.velocity);
    if (!(difference.m_per_s > worst.m_per_s)) continue;
    worst = difference;
    other = &each;
  }
  if (other == nullptr) return;
  say_folded("another verified answer moves differently by {:.3g} m/s, at contact {}: {} against {}; both pass the "
             "check\n",
             worst.m_per_s, worst.contact, other->label, first.label);
}

/// One sentence for each reason, with all solvers that it holds for, in kMostLines at most: of the engine, and of the
/// solvers that the user named.
void print_reasons(const std::vector<Attempt>& attempts, bool named) {
  constexpr std::ptrdiff_t kMostLines = 40;
  std::vector<std::pair<std::string, std::string>> reasons;  // reason, solvers
  std::size_t left_out = 0;
  for (const Attempt& each : attempts) {
    if (each.why.empty()) continue;
    if (!named && each.solver.name != "engine") {
      ++left_out;
      continue;
    }
    const auto known = std::ranges::find(reasons, each.why, &std::pair<std::string, std::string>::first);
    if (known == reasons.end()) {
      reasons.emplace_back(each.why, each.label);
    } else {
      known->second += ", " + each.label;
    }
  }
  std::ptrdiff_t lines = 0;
  for (const auto& [why, solvers] : reasons) {
    const std::string text = folded(fmt::format("{} {}\n", solvers, why), text_width());
    lines += std::ranges::count(text, '\n');
    if (lines < kMostLines) {
      say(stdout, "{}", text);
    } else {
      ++left_out;
    }
  }
  if (left_out == 0) return;
  say_folded("{}{} refused or failed: --solver NAME says why\n", reasons.empty() ? "" : "also, ",
             counted_noun(left_out, "solver"));
}

void print_nearly(const Problem& problem, const std::vector<Attempt>& attempts) {
  const auto nearly = std::ranges::find(attempts, Truth::kNearly, &Attempt::truth);
  if (nearly == attempts.end()) return;
  say_folded("nearly solvable: {}\n", nearly_words(nearly->least_violation_m_per_s, has_rows(problem)));
}

/// How many solved it, which of them is the fastest, and whose claims are false.
void print_conclusion(const std::vector<Attempt>& attempts) {
  const auto solved = std::ranges::count(attempts, Verdict::kSolved, &Attempt::verdict);
  std::string text = fmt::format("solved by {} of {}", solved, counted_noun(attempts.size(), "solver"));
  const Attempt& best = attempts.front();
  if (solved > 0 && std::isfinite(best.time_s())) {
    text += fmt::format("; the fastest is {}: {}", best.label, format_seconds(best.time_s()));
  }
  std::vector<std::string> wrong;
  for (const Attempt& each : attempts) {
    if (each.verdict == Verdict::kWrong) wrong.push_back(each.label);
  }
  if (!wrong.empty()) text += fmt::format("; claims that are false: {}", fmt::join(wrong, ", "));
  say_folded("{}\n", text);
}

constexpr const char* kTwoErrors =
    "solver's m/s: the residual of the conditions that the solver's model of friction has. model's m/s: the residual of "
    "the round Coulomb cone's conditions; it estimates the model's error on one step and ranks no answers: no impulse "
    "at all may have less.\n";

constexpr const char* kTwoResiduals =
    "contacts' m/s: the largest residual of the contacts. rows': that of the bounded rows, in the row's own unit.\n";

/// @param rows  of attempt_json(), one for each attempt
std::string attempts_table(const Problem& problem, const std::vector<Attempt>& attempts, const Json& rows) {
  const bool contact = problem.contact() != nullptr;
  using Align = TextTable::Align;
  const auto time = [](const Json& row) {
    const Json& times = row["time"];
    const bool known = times["setup_s"].is_number() && times["solve_s"].is_number();
    return known ? format_seconds(times["setup_s"].get<double>() + times["solve_s"].get<double>()) : "-";
  };
  std::vector<JsonColumn> columns{{{"solver", Align::kLeft, 0, 20}, field("label")},
                                  {{"claim", Align::kLeft, 0, 20}, field("claim")}};
  if (std::ranges::any_of(attempts, [](const Attempt& each) { return each.model != FrictionModel::kPyramid; })) {
    columns.push_back({{"model", Align::kLeft, 1}, field("model")});
  }
  columns.push_back({{"verdict", Align::kLeft}, field("verdict")});
  columns.push_back(contact ? JsonColumn{{"residual rho"}, field("errors/velocity_residual_relative", format_error)}
                            : JsonColumn{{"backward error"}, field("errors/backward_row_norm", format_error)});
  if (std::any_of(attempts.begin(), attempts.end(), [](const Attempt& each) {
        return !std::isnan(each.judgement.errors.model_error_m_per_s);
      })) {
    columns.push_back(
        {{"solver's m/s", Align::kRight, 3}, field("errors/velocity_residual_m_per_s", format_error)});
    columns.push_back({{"model's m/s", Align::kRight, 2}, field("errors/model_error_m_per_s", format_error)});
  }
  if (has_rows(problem)) {
    columns.push_back(
        {{"contacts' m/s", Align::kRight, 1}, field("errors/contact_residual_m_per_s", format_error)});
    columns.push_back({{"rows'", Align::kRight, 1}, [](const Json& row) -> std::string {
                         const Json& worst = row["errors"]["worst_bounded_row"];
                         if (worst.is_null()) return row["errors"]["contact_residual_m_per_s"].is_null() ? "-" : "0";
                         const Json& residual = worst["residual"];
                         return (residual.is_null() ? "inf" : format_error(residual.get<double>())) + " " +
                                worst["unit"].get<std::string>();
                       }});
  }
  columns.push_back({{contact ? "violation m/s" : "natural residual", Align::kRight, 4},
                     field(contact ? "errors/violation_m_per_s" : "errors/natural_residual", format_error)});
  columns.push_back({{"time"}, time});
  columns.push_back({{"set-up", Align::kRight, 5}, field("time/setup_s", format_seconds)});
  columns.push_back({{"solve", Align::kRight, 5}, field("time/solve_s", format_seconds)});
  columns.push_back({{"verify", Align::kRight, 6}, field("time/verify_s", format_seconds)});
  columns.push_back({{"detail", Align::kLeft, 7, 30}, field("detail")});
  return table_text(columns, rows);
}

/// The answer that is shown where nobody named a solver: that of `auto`, which rests where contacts can, with the
/// impulses of equally stiff contacts, if it is verified as the best one is; else the best one.
Attempt answer_to_show(const Problem& problem, const std::vector<Attempt>& attempts, BoundedCertifier& certifier,
                       const SolveArguments& arguments) {
  const Attempt& best = attempts.front();
  const Spec spec{"auto", problem.contact() != nullptr ? Options{{"impulses", "even"}} : Options{}};
  if (best.verdict != Verdict::kSolved || best.model != FrictionModel::kPyramid) return best;
  Judge judge(problem, certifier, arguments.solved_at);
  Attempt shown = attempt(problem, spec, *open_solver(spec), judge, arguments.time_limit_s, false);
  shown.verdict = verdict(shown.timed.answer.claim, shown.judgement.errors, best.truth);
  return shown.verdict == Verdict::kSolved ? shown : best;
}

/// On a terminal the verdict *wrong* is red, unless NO_COLOR is set.
void print_table(const std::string& table) {
  constexpr std::string_view kCell = "  wrong ";
  constexpr std::string_view kRed = "  \033[31mwrong\033[0m ";
  std::string text = printable(table, "\n");
  const bool coloured = isatty(STDOUT_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr;
  for (std::size_t at = 0; coloured && (at = text.find(kCell, at)) != std::string::npos; at += kRed.size()) {
    text.replace(at, kCell.size(), kRed);
  }
  fmt::print("{}", text);
}

/// @param shown  the answer itself that is printed; nullptr: none is
void print_attempts(const Problem& problem, const std::string& file, const std::vector<Attempt>& attempts, Json rows,
                    const ModelErrors& model_errors, bool named, const Attempt* shown) {
  say_folded("{}\n", problem_summary_text(problem, file));
  if (attempts.empty()) {
    say(stdout, "no available solver takes this problem; lcpbench solvers lists what each needs\n\n");
    return;
  }
  if (named) {  // in the order in which the user named them
    const Json by_rank = rows;
    for (std::size_t i = 0; i < attempts.size(); ++i) rows[attempts[i].place - 1] = by_rank[i];
  }
  const std::string table = attempts_table(problem, attempts, rows);
  print_table(table);
  if (table.find("model's m/s") != std::string::npos) say_folded("{}", kTwoErrors);
  if (table.find("rows'") != std::string::npos) say_folded("{}", kTwoResiduals);
  print_reasons(attempts, named);
  print_nearly(problem, attempts);
  if (shown != nullptr) print_solution(problem, file, *shown);
  print_conclusion(attempts);
  print_spread(problem, attempts);
  const Attempt& answer = shown != nullptr ? *shown : attempts.front();
  if (shown != nullptr) print_impulses(problem, answer);
  print_coarse_model(problem, file, answer);
  print_model_errors(model_errors);
  print_velocity(answer);
  say(stdout, "\n");
}

int solve(const SolveArguments& arguments) {
  if (arguments.max_velocity_error > 0) {
    return solve_by_models(arguments.files, arguments.max_velocity_error, arguments.time_limit_s, arguments.json);
  }
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  ProgressLine progress;
  Solvers solvers(arguments.solvers);
  BoundedCertifier certifier;
  bool all_started = true;
  bool one_crashed = false;
  SolveTotal total;
  std::optional<std::string> soft_engine;
  const bool alone = arguments.files.size() == 1 && !is_scenes_file(arguments.files.front());
  const auto examine = [&](const Problem& problem, const std::string& file, Json& rows) {
    bool started = true;
    auto attempts = attempts_on(problem, file, solvers, certifier, arguments, stop, progress, started);
    all_started = all_started && started;
    total.add_problem();
    for (const Attempt& each : attempts) {
      one_crashed = one_crashed || each.timed.answer.claim == Claim::kCrashed;
      const Errors& errors = each.judgement.errors;
      total.add(each.solver.text(), each.label, file, each.timed.answer.claim, each.verdict, errors.measure(),
                each.time_s());
      const bool own = each.solver.name == "engine" && each.verdict == Verdict::kWrong && !problem.contact()->is_soft();
      if (own && !soft_engine) soft_engine = soft_engine_words(report::engine_of(file.starts_with("scene/") ? file : "file:" + file));
    }
    const ModelErrors errors =
        attempts.empty() ? ModelErrors() : model_errors(problem, attempts.front(), arguments.time_limit_s);
    const Json described_problem = problem_summary_json(problem, file);
    std::optional<BoundedRowStates> states;
    if (arguments.json && has_rows(problem)) states.emplace(*problem.contact());
    for (const Attempt& each : attempts) {
      rows.push_back(attempt_json(problem, described_problem, each, states ? &*states : nullptr));
      if (errors.relaxation) rows.back()["relaxation_m_per_s"] = json_number(errors.relaxation->m_per_s);
      if (errors.softness) rows.back()["softness_m_per_s"] = json_number(errors.softness->m_per_s);
    }
    if (arguments.json) return;
    if ((started && *stop == 0) || !attempts.empty()) {  // else stderr has said all
      std::optional<Attempt> shown;
      if (alone && !attempts.empty()) {
        shown = solvers.named() ? attempts.front() : answer_to_show(problem, attempts, certifier, arguments);
      }
      print_attempts(problem, file, attempts, rows, errors, solvers.named(), shown ? &*shown : nullptr);
    }
    rows.clear();
  };
  const int exit_code = examine_problem_files(arguments.files, arguments.json, examine);
  if (!arguments.json) {
    say(stdout, "{}", total.text(text_width()));
    if (!soft_engine.value_or("").empty()) say_folded("{}.\n", *soft_engine);
  }
  if (exit_code != kExitDone) return exit_code;
  if (!all_started) return kExitBadInput;
  return one_crashed && !arguments.solvers.empty() ? kExitCheckFailed : kExitDone;
}

}  // namespace

Action add_solve_command(CLI::App& command) {
  const auto arguments = std::make_shared<SolveArguments>();
  command.add_option("FILE", arguments->files, "problem files, steps F.scenes#K, or problems of sets SET#K (seed 1)")
      ->required();
  add_repeatable(command, "--solver", arguments->solvers,
                 "name{key=value,...}; may be repeated (default: all that fit)");
  command
      .add_option("--max-velocity-error", arguments->max_velocity_error,
                  "m/s: solve each island by the coarsest model of friction whose measured error against the round cone "
                  "is at most this")
      ->check(number_check(1e-12, 1e6))
      ->excludes("--solver");
  add_solved_at(command, arguments->solved_at)->excludes("--max-velocity-error");
  add_number(command, "--time-limit", arguments->time_limit_s, "seconds for each solve", number_check());
  add_output_options(command, arguments->json);
  command.footer(
      "claim: what the solver says. verdict: lcpbench's own check of the answer. A file that cannot be read "
      "does not stop the others; the exit code is then 2, as it is if a solver does not start. Exit code 1: a solver "
      "that --solver names crashed, or returned what is no answer; or an answer misses --max-velocity-error (see "
      "docs/explanation/friction-models.md). Ctrl-C shows the answers so far (exit code 3).");
  return [arguments] { return solve(*arguments); };
}

}  // namespace lcpbench
