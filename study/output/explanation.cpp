#include "study/output/explanation.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

namespace lcpbench {
namespace {

/// Format strings that say what is wrong in a row, with its z as {z} and |w| as {w}.
struct RowWords {
  std::string subject;
  const char* negative_z;
  const char* negative_w;
  const char* both;  ///< z and w both positive
};

RowWords words_of(const ContactProblem& problem, Index row) {
  const ContactLayout layout = contact_layout(problem);
  if (row < problem.nc()) {
    return {fmt::format("contact {} (row {})", row + 1, row), "has a negative normal impulse of {z:.3g} N s",
            "still approaches at {w:.3g} m/s", "separates at {w:.3g} m/s and has a normal impulse of {z:.3g} N s"};
  }
  if (row >= layout.lambda_offset()) {
    const Index contact = layout.cone_contact[static_cast<std::size_t>(row - layout.lambda_offset())];
    return {fmt::format("contact {} (row {})", contact + 1, row), "has a negative lambda of {z:.3g} m/s",
            "has more friction than its cone allows, by {w:.3g} N s",
            "has lambda = {z:.3g} m/s, and its friction is {w:.3g} N s below the limit of its cone"};
  }
  const Index direction = row - layout.friction_offset();
  const auto next = std::upper_bound(layout.friction_begin.begin(), layout.friction_begin.end(), direction);
  const auto contact = static_cast<std::size_t>(next - layout.friction_begin.begin()) - 1;
  return {fmt::format("friction direction {} of contact {} (row {})", direction - layout.friction_begin[contact] + 1,
                      contact + 1, row),
          "has a negative impulse of {z:.3g} N s", "has a sliding speed against it that is {w:.3g} m/s above lambda",
          "has an impulse of {z:.3g} N s, and lambda is {w:.3g} m/s above the sliding speed against it"};
}

/// "1e-4".
std::string short_number(double power_of_ten) {
  std::string text = fmt::format("{:.0e}", power_of_ten);
  if (const std::size_t zero = text.find("e-0"); zero != std::string::npos) text.erase(zero + 2, 1);
  return text;
}

std::string state_of(const RowWords& words, const WorstRow& worst) {
  const bool z_is_negative = worst.z < 0 && (!(worst.w < 0) || worst.residual != std::abs(worst.w));
  const bool w_is_negative = worst.w < 0 && !z_is_negative;
  const char* form = w_is_negative ? words.negative_w : z_is_negative ? words.negative_z : words.both;
  return words.subject + " " +
         fmt::format(fmt::runtime(form), fmt::arg("z", worst.z), fmt::arg("w", std::abs(worst.w)));
}

/// The row whose conditions the answer violates most, and by how much. @pre not errors.unresolved
std::string worst_row_words(const Problem& problem, const Errors& errors) {
  const WorstRow& worst = errors.worst;
  if (worst.row < 0) return "its error cannot be measured: the data are not finite, or the inertia is indefinite";
  if (const ContactProblem* contact = problem.contact()) {
    return fmt::format("{}: residual {:.3g} relative to its island's scale of {:.3g} m/s; the limit is {}",
                       state_of(words_of(*contact, worst.row), worst), errors.velocity_residual_relative, worst.scale,
                       short_number(kSolvedVelocityResidual));
  }
  const RowWords words{fmt::format("row {}", worst.row), "has z = {z:.3g}, below zero", "has w = -{w:.3g}, below zero",
                       "has z = {z:.3g} and w = {w:.3g}, but one of them must be zero"};
  return fmt::format("{}: backward error {:.3g} of its block; the limit is {}", state_of(words, worst),
                     errors.backward_row_norm, short_number(kSolvedBackwardError));
}

/// How far the velocity that came with the answer is from the one that its z implies.
std::string velocity_words(const Errors& errors) {
  const WorstCoordinate& worst = errors.worst_coordinate;
  if (worst.coordinate < 0) return "its velocity is of another length than the problem's, or not finite";
  return fmt::format(
      "its velocity is not the one that its z gives: coordinate {} is {:.6g}, and z gives {:.6g}; error {:.3g} "
      "relative to |v| + |G*||J||f|; the limit is {}",
      worst.coordinate, worst.returned, worst.implied, errors.returned_velocity_error,
      short_number(kSolvedReturnedVelocity));
}

/// z passes, and the velocity beside it does not.
bool only_velocity_fails(const Errors& errors) {
  return errors.velocity_residual_relative <= kSolvedVelocityResidual && !errors.velocity_passes();
}

std::string because(const JudgedAnswer& answer) {
  return answer.truth_because.empty() ? "" : " (" + answer.truth_because + ")";
}

/// "ended with crashed (exited with code 1 without an answer)".
std::string ended_with(const JudgedAnswer& answer) {
  return fmt::format("ended with {}{}", to_string(answer.claim),
                     answer.detail.empty() ? "" : " (" + answer.detail + ")");
}

std::string missed_or_open(const Problem& problem, const JudgedAnswer& answer) {
  if (answer.claim == Claim::kSolved) {
    return "said solved; inertia unresolved: the answer is not measured, as 113 bits do not tell the rank of G";
  }
  const bool known = answer.verdict == Verdict::kMissed;
  if (answer.claim == Claim::kUnsolvable) {
    return known ? "said unsolvable, but the problem has a solution" + because(answer)
                 : "said unsolvable, but without a valid proof; it is not known whether there is a solution";
  }
  const char* const has_none = "is not known to have a solution";
  const std::string has = answer.truth == Truth::kNearly ? "is nearly solvable" : "has a solution";
  std::string words = fmt::format("{}; the problem {}", ended_with(answer), known ? has + because(answer) : has_none);
  if (answer.unusable.empty() && only_velocity_fails(answer.errors)) {
    words += "; " + velocity_words(answer.errors);
  } else if (answer.unusable.empty() && answer.errors.worst.row >= 0) {
    words += "; the worst row of its z: " + worst_row_words(problem, answer.errors);
  }
  return words;
}

}  // namespace

Json problem_summary_json(const Problem& problem, const std::string& unnamed) {
  const ContactProblem* contact = problem.contact();
  return {{"name", problem.name().empty() ? unnamed : problem.name()},
          {"kind", to_string(problem.kind())},
          {"n", problem.size()},
          {"ngc", contact != nullptr ? Json(contact->ngc()) : Json()},
          {"nc", contact != nullptr ? Json(contact->nc()) : Json()},
          {"edges", contact != nullptr ? Json(contact->edges) : Json()}};
}

std::string nearly_words(double least_violation_m_per_s) {
  std::string words = "proven to have no exact solution, while an answer within the tolerance is known";
  if (!std::isnan(least_violation_m_per_s)) {
    words += fmt::format("; every answer violates some contact by at least {:.3g} m/s", least_violation_m_per_s);
  }
  return words;
}

std::string why_without_errors(const Answer& answer, Index n) {
  if (answer.z.size() == 0 && n > 0) {
    return answer.claim == Claim::kSolved || answer.detail.empty() ? "no z returned" : "";
  }
  if (answer.z.size() != n) {
    return "z has " + std::to_string(answer.z.size()) + " entries, expected " + std::to_string(n);
  }
  return answer.z.allFinite() ? "" : "z is not finite";
}

std::string soft_engine_words(std::string engine) {
  std::transform(engine.begin(), engine.end(), engine.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::array<std::array<const char*, 2>, 4> kOnPurpose{
      {{"mujoco", "MuJoCo softens contacts"},
       {"ode", "ODE corrects penetration and ends after 20 sweeps"},
       {"bullet", "Bullet corrects penetration and ends after 10 sweeps"},
       {"dart", "DART corrects penetration"}}};
  for (const auto& [name, what] : kOnPurpose) {
    if (!engine.starts_with(name)) continue;
    return fmt::format(
        "{} on purpose: its own answers (engine) to steps captured without --soft are judged here on hard "
        "contacts, which it does not solve",
        what);
  }
  return "";
}

std::string why_not_solved(const Problem& problem, const JudgedAnswer& answer) {
  switch (answer.verdict) {
    case Verdict::kSolved: return "";
    case Verdict::kWrong:
      if (answer.errors.solved || answer.errors.unresolved) {
        return "said solved, but the problem is proven to have no solution" + because(answer) + ".";
      }
      if (answer.unusable.empty() && only_velocity_fails(answer.errors)) {
        return "said solved, but " + velocity_words(answer.errors) + ".";
      }
      return "said solved, but " +
             (answer.unusable.empty() ? worst_row_words(problem, answer.errors) : answer.unusable) + ".";
    case Verdict::kUnsolvable:
      return fmt::format("{} the problem is proven to have no{} solution{}.",
                         answer.claim == Claim::kUnsolvable
                             ? "said unsolvable, which is right:"
                             : ended_with(answer) + ", and",
                         answer.truth == Truth::kNearly ? " exact" : "", because(answer));
    case Verdict::kRefused:
      return "refused the problem" + (answer.detail.empty() ? std::string() : ": " + answer.detail) + ".";
    case Verdict::kMissed:
    case Verdict::kOpen: return missed_or_open(problem, answer) + ".";
  }
  return "";
}

}  // namespace lcpbench
