#include "study/commands/solve_models.h"

#include <algorithm>
#include <utility>

#include "core/round_cone.h"
#include "core/timed_solve.h"
#include "study/commands/commands.h"
#include "study/commands/problem_files.h"
#include "study/evaluation/friction_model.h"
#include "study/models/ladder.h"

namespace lcpbench {
namespace {

/// The answer to the whole problem, and how each island got it.
struct Mixture {
  std::vector<LadderIsland> islands;
  std::vector<Climb> climbs;
  Answer answer;
  Errors errors;  ///< of the whole answer, by the conditions of the cone
  double chosen_s = 0;  ///< solving by the chosen models, thread CPU, as all times here
  double spent_s = 0;   ///< solving by all models tried, but for Climb::next
  double verify_s = 0;  ///< measuring `errors`
  bool met = true;      ///< `errors` are within the error asked for
};

/// The z of the whole problem from those of its islands, zero where an island has no answer. An island's z has the
/// normal impulses of its contacts, and then of each contact with friction four: along the tangents u, v, -u, -v.
Vector whole_impulses(const ContactProblem& contact, const Mixture& mixture) {
  const ContactLayout layout = contact_layout(contact);
  Vector z = Vector::Zero(layout.size());
  for (std::size_t i = 0; i < mixture.islands.size(); ++i) {
    const Vector& part = mixture.climbs[i].chosen.impulses;
    const std::vector<Index>& contacts = mixture.islands[i].contacts;
    auto at = static_cast<Index>(contacts.size());
    for (std::size_t k = 0; k < contacts.size() && part.size() > 0; ++k) {
      const auto c = static_cast<std::size_t>(contacts[k]);
      z(contacts[k]) = part(static_cast<Index>(k));
      if (layout.lambda[c] < 0) continue;
      const Index begin = layout.friction_begin[c];
      share_among_directions(part(at) - part(at + 2), part(at + 1) - part(at + 3),
                             z.segment(layout.friction_offset() + begin, layout.friction_begin[c + 1] - begin));
      at += 4;
    }
  }
  complete_slip_bounds(contact, layout, post_impact_velocity(contact, z), z);
  return z;
}

/// Why the whole answer misses the error: the first island that does, else a contact outside all islands.
std::string why_missed(const Mixture& mixture, double error_m_per_s) {
  for (std::size_t i = 0; i < mixture.climbs.size(); ++i) {
    const ModelAnswer& chosen = mixture.climbs[i].chosen;
    const Index first = mixture.islands[i].contacts.front();
    if (!chosen.answered()) {
      return fmt::format("the island of contact {} has no answer: {}", first, to_string(chosen.claim));
    }
    if (!mixture.climbs[i].met) {
      return fmt::format("the finest model of the island of contact {} leaves {:.2e} m/s", first, chosen.error_m_per_s);
    }
  }
  return fmt::format("a contact that nothing moves violates its conditions by more than {} m/s", error_m_per_s);
}

/// Solves island by island. Without answer and errors if `stop` is raised before the last island.
Mixture mix(const Problem& problem, std::vector<LadderIsland> islands, double error_m_per_s,
            const volatile std::sig_atomic_t* stop) {
  Mixture mixture;
  mixture.islands = std::move(islands);
  for (const LadderIsland& island : mixture.islands) {
    if (*stop != 0) return mixture;
    const Climb& climbed = mixture.climbs.emplace_back(climb(*island.ladder, error_m_per_s));
    mixture.chosen_s += climbed.chosen.time_s;
    mixture.spent_s += climbed.spent_s;
  }
  mixture.answer.z = whole_impulses(*problem.contact(), mixture);
  mixture.answer.velocity = post_impact_velocity(*problem.contact(), mixture.answer.z);
  const double begin = thread_cpu_clock_s();
  mixture.errors = Evaluator(problem).errors(mixture.answer);
  measure_friction(FrictionModel::kCone, problem, mixture.answer, mixture.errors);
  mixture.verify_s = thread_cpu_clock_s() - begin;
  // Of the whole answer as it is returned, not of the islands' alone: contacts that nothing moves count.
  mixture.met = mixture.errors.velocity_residual_m_per_s <= error_m_per_s;
  mixture.answer.claim = mixture.met ? Claim::kSolved : Claim::kNumericalFailure;
  if (!mixture.met) mixture.answer.detail = why_missed(mixture, error_m_per_s);
  return mixture;
}

Json climb_json(const LadderIsland& island, const Climb& climbed) {
  const bool further = climbed.next.answered();
  return {{"contacts", island.contacts},
          {"model", to_string(climbed.chosen.model)},
          {"met", climbed.met},
          {"error_m_per_s", json_number(climbed.chosen.error_m_per_s)},
          {"solver_error_m_per_s", json_number(climbed.chosen.solver_error_m_per_s)},
          {"time_s", json_number(climbed.chosen.time_s)},
          {"spent_s", json_number(climbed.spent_s)},
          {"next_model", further ? Json(to_string(climbed.next.model)) : Json()},
          {"next_time_s", json_number(climbed.next.time_s)},
          {"next_change_m_per_s", json_number(climbed.change_m_per_s)}};
}

Json mixture_json(const Problem& problem, const Json& summary, const Mixture& mixture, double error_m_per_s) {
  Json islands = Json::array();
  for (std::size_t i = 0; i < mixture.islands.size(); ++i) {
    islands.push_back(climb_json(mixture.islands[i], mixture.climbs[i]));
  }
  return {{"problem", summary},
          {"solver", "models"},
          {"settings", fmt::format("max_velocity_error={}", error_m_per_s)},
          {"model", "cone"},
          {"claim", to_string(mixture.answer.claim)},
          {"met", mixture.met},
          {"z", json_vector(mixture.answer.z)},
          {"velocity", json_vector(mixture.answer.velocity)},
          {"errors", errors_json(problem, mixture.errors)},
          {"time",
           {{"chosen_s", json_number(mixture.chosen_s)},
            {"spent_s", json_number(mixture.spent_s)},
            {"verify_s", json_number(mixture.verify_s)}}},
          {"detail", mixture.answer.detail},
          {"islands", islands}};
}

void add_model_row(TextTable& table, ContactModel model, const Mixture& mixture) {
  std::size_t islands = 0;
  std::size_t contacts = 0;
  double error = 0;
  double solver_error = 0;
  double time_s = 0;
  for (std::size_t i = 0; i < mixture.climbs.size(); ++i) {
    const ModelAnswer& chosen = mixture.climbs[i].chosen;
    if (chosen.model != model) continue;
    ++islands;
    contacts += mixture.islands[i].contacts.size();
    error = larger_or_nan(error, chosen.error_m_per_s);
    solver_error = larger_or_nan(solver_error, chosen.solver_error_m_per_s);
    time_s += chosen.time_s;
  }
  if (islands == 0) return;
  table.add_row({to_string(model), std::to_string(islands), std::to_string(contacts), format_error(error),
                 format_error(solver_error), format_seconds(time_s)});
}

void print_mixture(const Mixture& mixture, double error_m_per_s) {
  TextTable table({{"model", TextTable::Align::kLeft},
                   {"islands"},
                   {"contacts"},
                   {"error m/s"},
                   {"of it the solver's", TextTable::Align::kRight, 1},
                   {"time"}});
  double next_s = 0;
  double change = 0;
  bool further = false;
  for (const ContactModel model : kClimbed) add_model_row(table, model, mixture);
  for (const Climb& each : mixture.climbs) {
    next_s += each.next.answered() ? each.next.time_s : each.chosen.time_s;
    further = further || each.next.answered();
    if (each.next.answered()) change = std::max(change, each.change_m_per_s);
  }
  if (!table.empty()) say(stdout, "{}", table.text(text_width()));
  std::string text = fmt::format(
      "{} {} m/s: the residual of the cone's conditions is {} m/s; {} for the models chosen, {} "
      "with all models tried",
      mixture.met ? "meets" : "misses", error_m_per_s, format_error(mixture.errors.velocity_residual_m_per_s),
      format_seconds(mixture.chosen_s), format_seconds(mixture.spent_s));
  if (!mixture.met) text += "; " + mixture.answer.detail;
  if (further) {
    text += fmt::format("; the cone takes {} and changes the velocities at the contacts by {} m/s at most",
                        format_seconds(next_s), format_error(change));
  }
  say_folded("{}\n\n", text);
}

}  // namespace

int solve_by_models(const std::vector<std::string>& files, double error_m_per_s, double time_limit_s, bool json) {
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  bool met = true;
  const auto examine = [&](const Problem& problem, const std::string& file, Json& rows) {
    const Mixture mixture = mix(problem, ladder_islands(problem, file, time_limit_s), error_m_per_s, stop);
    if (*stop != 0) return;
    met = met && mixture.met;
    if (json) {
      rows.push_back(mixture_json(problem, problem_summary_json(problem, file), mixture, error_m_per_s));
    } else {
      say_folded("{}\n", problem_summary_text(problem, file));
      print_mixture(mixture, error_m_per_s);
    }
  };
  const int exit_code = examine_problem_files(files, json, examine);
  return exit_code == kExitDone && !met ? kExitCheckFailed : exit_code;
}

}  // namespace lcpbench
