#include "study/output/explanation.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/answer/cone_friction.h"
#include "core/answer/contact_scale.h"
#include "core/entries.h"
#include "core/islands.h"
#include "study/evaluation/bounded_row_states.h"

namespace lcpbench {
namespace {

/// "5.4 mm/s", "0.25 m/s".
std::string speed(double m_per_s) {
  const double magnitude = std::abs(m_per_s);
  return magnitude < 0.1 ? fmt::format("{:.3g} mm/s", 1000 * magnitude) : fmt::format("{:.3g} m/s", magnitude);
}

/// How a contact moves along its normal, and by which units.
struct NormalRow {
  double f_N = 0;
  double w_N = 0;
  double offset = 0;
  bool of_joint = false;  ///< its normal is a coordinate of a joint, which may be an angle
};

std::string normal_words(const NormalRow& row, bool negative_z, bool negative_w) {
  const char* const impulse = row.of_joint ? "N s or N m s" : "N s";
  if (negative_z && !negative_w) return fmt::format("has a negative normal impulse of {:.3g} {}", row.f_N, impulse);
  std::string motion = fmt::format("{} at {}", negative_w ? "still approaches" : "separates", speed(row.w_N));
  if (row.offset != 0) motion = fmt::format("has w_N = N'v+ + b = {:.3g} m/s", row.w_N);
  if (row.of_joint) motion.replace(motion.find("m/s"), 3, "m/s or rad/s");
  return negative_w ? motion : fmt::format("{} and has a normal impulse of {:.3g} {}", motion, row.f_N, impulse);
}

/// Of a contact that slides, with that much friction left.
std::string unused_words(const WorstRow& at, double slack) {
  return fmt::format("slides at {} although its friction is not used up: {:.3g} N s are left", speed(at.slip), slack);
}

/// Of a contact whose friction violates the conditions of the round cone. @param slack  mu f_N - |f_t|
std::string slip_words(const WorstRow& at, double slack) {
  if (slack < -kSolvedVelocityResidual * at.friction) {
    return fmt::format("has more friction than its cone allows, by {:.3g} N s", -slack);
  }
  // By how much the friction differs from one of its size that opposes the slip.
  if (at.friction * std::sqrt(std::max(0.0, 2 - 2 * at.opposing)) > slack) {
    const double degrees = std::acos(std::clamp(at.opposing, -1.0, 1.0)) * 180 / std::numbers::pi;
    return fmt::format("slides at {}, and its friction of {:.3g} N s points {:.3g} degrees away from opposing that",
                       speed(at.slip), at.friction, degrees);
  }
  return unused_words(at, slack);
}

/// The same of the convex model, which asks for w_N >= mu |w_t|, and f'w = 0.
std::string convex_words(const WorstRow& at, double slack, double mu) {
  const double above = at.separation - mu * at.slip;
  if (at.normal < 0) return normal_words({.f_N = at.normal}, true, false);
  if (above < 0 && slack >= -kSolvedVelocityResidual * at.friction) {
    return fmt::format("slides at {} and {} at {}; the convex model asks it to separate at {}", speed(at.slip),
                       at.separation < 0 ? "approaches" : "separates", speed(at.separation), speed(mu * at.slip));
  }
  const double missing = at.slip * (mu * at.normal - at.friction * at.opposing);
  if (!(slack < 0) && above * at.normal > missing) {
    return fmt::format("has a normal impulse of {:.3g} N s and separates {} faster than the convex model asks",
                       at.normal, speed(above));
  }
  return slip_words(at, slack);
}

/// What is wrong at a bounded row.
std::string row_state(const BoundedRows& rows, Index row, const JudgedAnswer& answer) {
  const WorstRow& at = answer.errors.worst;
  const char* const unit = impulse_unit(rows, row);
  const Vector impulses = answer.z != nullptr ? Vector(answer.z->tail(rows.size())) : Vector::Zero(rows.size());
  const auto [lower, upper] = bounds_of(rows, row, impulses);
  const std::string impulse = fmt::format("{:.3g} {}", at.z, unit);
  if (at.z < lower) return fmt::format("has an impulse of {}, below its lower bound of {:.3g}", impulse, lower);
  if (at.z > upper) return fmt::format("has an impulse of {}, above its upper bound of {:.3g}", impulse, upper);
  const std::string moves = fmt::format("moves at w = {:.3g} {}", at.w, velocity_unit(rows, row));
  const bool is_up = at.w > 0;  // which asks for an impulse at the lower bound
  const char* const name = is_up ? "lower" : "upper";
  const double bound = is_up ? lower : upper;
  if (!std::isfinite(bound)) return fmt::format("{}, although its impulse has no {} bound", moves, name);
  return fmt::format("{}, although its impulse of {} is {} its {} bound of {:.3g}", moves, impulse,
                     is_up ? "above" : "below", name, bound);
}

/// "row 2 (hinge) moves at w = 0.1 rad/s, although its impulse has no lower bound".
std::string bounded_row_words(const BoundedRows& rows, Index row, const JudgedAnswer& answer) {
  const std::string words = fmt::format("bounded {} {}", rows.name_of(row), row_state(rows, row, answer));
  if (rows.is_angle[static_cast<std::size_t>(row)] == 0) return words;
  return fmt::format("{}; its residual of {:.3g} rad/s counts as {:.3g} m/s", words, answer.errors.worst.in_own_unit,
                     answer.errors.worst.residual);
}

/// The contact of a row, or the bounded row, and what is wrong there.
std::string contact_state(const ContactProblem& of, const JudgedAnswer& answer, bool negative_z, bool negative_w) {
  const WorstRow& at = answer.errors.worst;
  const auto words = [&](Index contact) {
    const std::string number = fmt::format("contact {}", contact);
    const auto& names = answer.contact_names;
    return names.empty() ? number : fmt::format("{} ({})", number, names[static_cast<std::size_t>(contact)]);
  };
  const ContactLayout layout = contact_layout(of);
  if (at.row >= layout.row_offset()) return bounded_row_words(of.rows, at.row - layout.row_offset(), answer);
  if (at.row < of.nc()) {
    const std::string name = words(at.row);
    const NormalRow row{at.z, at.w, of.offset(at.row), name.find("(limit of ") != std::string::npos};
    return name + " " + normal_words(row, negative_z, negative_w);
  }
  if (at.row >= layout.lambda_offset()) {
    const Index contact = layout.cone_contact[static_cast<std::size_t>(at.row - layout.lambda_offset())];
    const std::string subject = words(contact) + " ";
    if (answer.model == FrictionModel::kCone) return subject + slip_words(at, at.w);
    if (answer.model == FrictionModel::kConvex) return subject + convex_words(at, at.w, of.mu(contact));
    if (negative_w) return subject + fmt::format("has more friction than its cone allows, by {:.3g} N s", -at.w);
    if (negative_z) return subject + fmt::format("has a negative sliding speed in z, of {}", speed(at.z));
    if (!(at.slip >= 0.5 * at.z)) {
      return subject + fmt::format("has a sliding speed of {} in z, and slides at {}", speed(at.z), speed(at.slip));
    }
    return subject + unused_words(at, at.w);
  }
  const Index direction = at.row - layout.friction_offset();
  const auto next = std::upper_bound(layout.friction_begin.begin(), layout.friction_begin.end(), direction);
  const auto contact = static_cast<std::size_t>(next - layout.friction_begin.begin()) - 1;
  const std::string subject = fmt::format("{}, friction direction {},", words(static_cast<Index>(contact)),
                                          direction - layout.friction_begin[contact]);
  if (negative_w) return fmt::format("{} slides against it {} faster than z says", subject, speed(at.w));
  if (negative_z) return fmt::format("{} has a negative impulse of {:.3g} N s", subject, at.z);
  return fmt::format("{} has an impulse of {:.3g} N s, and slides against it {} slower than in other directions",
                     subject, at.z, speed(at.w));
}

/// "1e-4".
std::string short_number(double x) {
  std::string text = fmt::format("{:.0e}", x);
  if (std::stod(text) != x) return fmt::format("{:g}", x);
  if (const std::size_t zero = text.find("e-0"); zero != std::string::npos) text.erase(zero + 2, 1);
  return text;
}

/// What counts at least in the scale of the row's island: see ContactScale.
double scale_floor(const ContactProblem& problem, Index row) {
  const RowIslands islands = row_islands(problem);
  const auto island = [&](Index of) { return islands.of_row[static_cast<std::size_t>(of)]; };
  ContactScale<double> scale;
  const auto add_rows = [&](const Jacobian& J, Index count, Index first, const auto& lever) {
    for (Index j = 0; j < count; ++j) {
      if (island(first + j) != island(row)) continue;
      double velocity = 0, terms = 0, entries = 0;
      for_each_entry(J, j, [&](Index i, double entry) {
        velocity += entry * problem.v(i);
        terms += std::abs(entry * problem.v(i));
        entries += entry != 0 ? 1 : 0;
      });
      scale.add_row(lever(first + j) * velocity, lever(first + j) * terms, entries);
    }
  };
  const auto one = [](Index) { return 1.0; };
  const ContactLayout layout = contact_layout(problem);
  add_rows(problem.N, layout.nc, 0, one);
  add_rows(problem.D, layout.lambda_offset() - layout.friction_offset(), layout.friction_offset(), one);
  if (problem.has_rows()) {
    ContactResidual residual(problem);
    const auto lever = [&](Index of) {
      return residual.lcp ? to_double(residual.lcp->lever(static_cast<std::size_t>(of))) : 1.0;
    };
    add_rows(problem.rows.R, layout.rows, layout.row_offset(), lever);
  }
  return scale.floor();
}

/// "the 0.362 m/s that no impulses leave in its island".
std::string scale_words(const ContactProblem& problem, const WorstRow& worst) {
  constexpr double kRounding = 1e-9;  // of a floor in double
  const bool is_floor = worst.scale <= scale_floor(problem, worst.row) * (1 + kRounding);
  return is_floor ? fmt::format("{:.3g} m/s, the floor of its island's scale", worst.scale)
                  : fmt::format("the {:.3g} m/s that no impulses leave in its island", worst.scale);
}

/// The row whose conditions the answer violates most, and by how much. @pre not errors.unresolved
std::string worst_row_words(const Problem& problem, const JudgedAnswer& answer) {
  const Errors& errors = answer.errors;
  const WorstRow& worst = errors.worst;
  if (worst.row < 0) return "its error cannot be measured: the data are not finite, or the inertia is indefinite";
  const bool negative_z = worst.z < 0 && (!(worst.w < 0) || worst.residual != std::abs(worst.w));
  const bool negative_w = worst.w < 0 && !negative_z;
  if (const ContactProblem* contact = problem.contact()) {
    return fmt::format("{}: error {:.3g}, relative to {}; the limit is {}",
                       contact_state(*contact, answer, negative_z, negative_w), errors.velocity_residual_relative,
                       scale_words(*contact, worst), short_number(errors.limit));
  }
  const Lcp& lcp = problem.lcp();
  if (lcp.is_mixed()) {
    const int of = lcp.bounds.friction_of[static_cast<std::size_t>(worst.row)];
    const std::string bounds =
        of >= 0 ? fmt::format("+-{:g} z[{}]", lcp.bounds.mu(worst.row), of)
                : fmt::format("{:g} and {:g}", lcp.bounds.lower(worst.row), lcp.bounds.upper(worst.row));
    return fmt::format(
        "row {} has z = {:.6g} and w = {:.3g}, which do not belong together with its bounds {}: backward "
        "error {:.3g}, relative to its scale of {:.3g}; the limit is {}",
        worst.row, worst.z, worst.w, bounds, errors.backward_row_norm, worst.scale, short_number(errors.limit));
  }
  const std::string w = worst.w == 0 ? "w above zero, but below the least double" : fmt::format("w = {:.3g}", worst.w);
  const std::string state = negative_w   ? fmt::format("has w = {:.3g}, below zero", worst.w)
                            : negative_z ? fmt::format("has z = {:.3g}, below zero", worst.z)
                                         : fmt::format("has z = {:.3g} and {}, but one of them must be zero", worst.z, w);
  return fmt::format("row {} {}: backward error {:.3g}, relative to its scale of {:.3g}; the limit is {}", worst.row,
                     state, errors.backward_row_norm, worst.scale, short_number(errors.limit));
}

/// Where rounding the answer's own impulses to doubles moves the worst row by more than the limit allows: that no
/// doubles may hold a solution. "" elsewhere, and above kLargestFormed unknowns.
std::string rounding_words(const Problem& problem, const JudgedAnswer& answer) {
  constexpr Index kLargestFormed = 600;
  const WorstRow& worst = answer.errors.worst;
  if (answer.z == nullptr || worst.row < 0 || problem.size() > kLargestFormed) return "";
  const Vector& z = *answer.z;
  const Vector moved = problem.lcp().M.row(worst.row).cwiseAbs().transpose().cwiseProduct(z.cwiseAbs()) * 0x1p-53;
  if (!(moved.sum() > answer.errors.limit * worst.scale)) return "";
  return fmt::format("; entries of z up to {:.3g} cancel in it, and rounding them to doubles alone may move it by {:.3g}",
                     z.cwiseAbs().maxCoeff(), moved.sum());
}

/// How far the velocity that came with the answer is from the one that its z implies.
std::string velocity_words(const Errors& errors) {
  const WorstCoordinate& worst = errors.worst_coordinate;
  if (worst.coordinate < 0) return "its velocity is of another length than the problem's, or not finite";
  return fmt::format(
      "its velocity is not the one that its z gives: coordinate {} is {:.6g}, and z gives {:.6g}; error {:.3g}, "
      "relative to its scale of {:.3g}, |v| + |G*||J||f| or its floor; the limit is {}",
      worst.coordinate, worst.returned, worst.implied, errors.returned_velocity_error, worst.scale,
      short_number(kSolvedReturnedVelocity));
}

/// z passes, and the velocity beside it does not.
bool only_velocity_fails(const Errors& errors) {
  return errors.measure() <= errors.limit && !errors.velocity_passes();
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
    const std::string no_cone = answer.model == FrictionModel::kPyramid ? "" : why_no_cone(*problem.contact());
    if (!no_cone.empty()) return "said solved; not measured, because no round cone is known for " + no_cone;
    return "said solved; inertia unresolved: the answer is not measured, as 113 bits do not tell G* well enough";
  }
  const bool known = answer.verdict == Verdict::kMissed;
  if (answer.claim == Claim::kUnsolvable) {
    if (known) return "said unsolvable, but the problem has a solution" + because(answer);
    const bool answered = answer.truth == Truth::kAnswered;
    return fmt::format("said unsolvable, but without a valid proof; {}it is not known whether there is {} solution",
                       answered ? "the problem has an answer within the tolerance" + because(answer) + ", and " : "",
                       answered ? "an exact" : "a");
  }
  const char* const has_none = "is not known to have a solution";
  const std::string has = answer.truth == Truth::kSolvable ? "has a solution"
                          : answer.truth == Truth::kNearly ? "is nearly solvable"
                                                           : "has an answer within the tolerance";
  std::string words = fmt::format("{}; the problem {}", ended_with(answer), known ? has + because(answer) : has_none);
  if (answer.unusable.empty() && only_velocity_fails(answer.errors)) {
    words += "; " + velocity_words(answer.errors);
  } else if (answer.unusable.empty() && answer.errors.worst.row >= 0) {
    words += "; the worst row of its z: " + worst_row_words(problem, answer) + rounding_words(problem, answer);
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
          {"edges", contact != nullptr ? Json(contact->edges) : Json()},
          {"rows", contact != nullptr ? Json(contact->rows.size()) : Json()}};
}

std::string nearly_words(double least_violation_m_per_s, bool has_rows) {
  std::string words = "proven to have no exact solution, but within the tolerance of one";
  if (!std::isnan(least_violation_m_per_s)) {
    words += fmt::format("; every answer violates some contact{} by at least {:.3g} m/s{}",
                         has_rows ? " or bounded row" : "", least_violation_m_per_s, has_rows ? " or rad/s" : "");
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
             (answer.unusable.empty() ? worst_row_words(problem, answer) + rounding_words(problem, answer)
                                      : answer.unusable) +
             ".";
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
