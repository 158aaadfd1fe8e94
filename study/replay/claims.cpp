#include "study/replay/claims.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "core/io/json_document.h"

namespace lcpbench {
namespace {

constexpr std::string_view kMeasures[] = {"drift_m", "slip_m", "deepest_m", "energy_rise_j", "error_m"};
constexpr double kLostScene = std::numeric_limits<double>::infinity();
/// Two distances [m] or energies [J] of at most this count as equal.
constexpr double kNegligible = 1e-4;
/// So do two numbers whose difference is at most this share of the larger one.
constexpr double kNegligibleShare = 0.05;

std::string number(const FieldClaim& claim, double value) {
  if (std::isinf(value)) return "lost";
  return claim.measure == "energy_rise_j" ? fmt::format("{:.2g} J", value) : length_text(value);
}

/// "1 cm to 2.5 m": the least and the largest of the repetitions; one number where they are the same in print.
std::string range(const FieldClaim& claim, const std::vector<double>& values) {
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  const std::string from = number(claim, *least);
  const std::string to = number(claim, *largest);
  return from == to ? from : from + " to " + to;
}

/// The largest distance between the positions of a part in two frames [m].
double distance(const SceneStep& a, const SceneStep& b) {
  double largest = 0;
  for (std::size_t k = 0; k < std::min(a.poses.size(), b.poses.size()); ++k) {
    if (a.poses[k].size() < 3 || b.poses[k].size() < 3) continue;
    largest = std::max(largest, std::hypot(a.poses[k][0] - b.poses[k][0], a.poses[k][1] - b.poses[k][1],
                                           a.poses[k][2] - b.poses[k][2]));
  }
  return largest;
}

/// The index of the frame of a step; count() where there is none. The last frame is that of the last step, which need
/// not be a multiple of the steps between frames.
std::size_t frame_of(const ScenesFile& frames, std::int64_t step) {
  std::size_t at = 0;
  while (at < frames.count() && frames.step_number(at) != step) ++at;
  return at;
}

Holds holds_once(const FieldClaim& claim, double first, double second) {
  if (claim.kind == FieldClaim::Kind::kKeeps) return first <= claim.limit ? Holds::kYes : Holds::kNo;
  if (first == second || std::max(first, second) <= kNegligible) return Holds::kSame;
  if (std::min(first, second) >= (1 - kNegligibleShare) * std::max(first, second)) return Holds::kSame;
  return first < second ? Holds::kYes : Holds::kNo;
}

const char* word(Holds holds) {
  switch (holds) {
    case Holds::kYes: return "yes";
    case Holds::kNo: return "no";
    case Holds::kSometimes: return "in some repetitions";
    case Holds::kSame: return "no difference";
  }
  return "";
}

}  // namespace

std::vector<FieldClaim> read_claims(const std::string& text, const std::string& origin) {
  const Json document = parse_json_document(text, origin);
  const JsonObject plan(document, origin);
  plan.only({"format", "version", "claims"});
  if (plan.text("format") != "lcpbench-claims") plan.fail("format", ": expected 'lcpbench-claims'");
  plan.integer("version", 1, 1);
  std::vector<FieldClaim> claims;
  for (const JsonObject& each : plan.objects("claims")) {
    each.only({"id", "claim", "source", "engine", "measure", "limit", "scenes", "steppers"});
    FieldClaim& claim = claims.emplace_back();
    claim.id = each.text("id");
    claim.claim = each.text("claim");
    claim.source = each.text("source");
    claim.measure = each.text("measure");
    if (std::ranges::find(kMeasures, claim.measure) == std::end(kMeasures)) {
      each.fail("measure", ": expected drift_m, slip_m, deepest_m, energy_rise_j or error_m");
    }
    claim.scenes = each.texts("scenes");
    claim.steppers = each.texts("steppers");
    claim.engine = each.given("engine") ? each.text("engine") : "ode";
    if (each.given("limit")) {
      claim.kind = FieldClaim::Kind::kKeeps;
      claim.limit = each.number("limit");
    }
    const std::size_t needed = claim.kind == FieldClaim::Kind::kKeeps ? 1 : 2;
    if (claim.steppers.size() != needed) each.fail("steppers", fmt::format(": expected {}", needed));
    if (claim.scenes.empty()) each.fail("scenes", ": a claim needs a scene");
  }
  return claims;
}

double error_of(const ScenesFile& frames, const ScenesFile& truth) {
  double largest = 0;
  std::size_t common = 0;
  for (std::size_t i = 0; i < frames.count(); ++i) {
    const std::size_t at = frame_of(truth, kTruthDivide * frames.step_number(i));
    if (at == truth.count()) continue;
    largest = std::max(largest, distance(frames.read(i), truth.read(at)));
    ++common;
  }
  // Where neither ended early, both have all frames but the last, whose steps differ.
  return common + 1 < truth.count() ? kLostScene : largest;
}

double parting_s(const ScenesFile& frames, const ScenesFile& other) {
  for (std::size_t i = 0; i < frames.count(); ++i) {
    const std::size_t at = frame_of(other, frames.step_number(i));
    const SceneStep frame = frames.read(i);
    const bool parted = at == other.count() || distance(frame, other.read(at)) > kApart;
    if (parted) return frame.time.value_or(std::numeric_limits<double>::quiet_NaN());
  }
  return std::numeric_limits<double>::infinity();
}

double measure_of(const Replay& replay, std::int64_t steps, const std::string& measure) {
  if (replay.survived() < steps) return kLostScene;
  if (measure == "energy_rise_j") return replay.energy_rise();
  if (measure == "drift_m") return replay.largest(&ReplayStep::drift_m);
  if (measure == "slip_m") return replay.largest(&ReplayStep::slip_m);
  return replay.largest(&ReplayStep::deepest_m);
}

Holds holds(const FieldClaim& claim, const ClaimedScene& scene) {
  const std::vector<double>& first = scene.values.front();
  const std::vector<double>& second = scene.values[claim.steppers.size() - 1];
  std::set<Holds> found;
  for (std::size_t i = 0; i < first.size(); ++i) found.insert(holds_once(claim, first[i], second[i]));
  if (found.size() == 1) return *found.begin();
  return found.contains(Holds::kYes) ? Holds::kSometimes : found.empty() ? Holds::kSame : Holds::kNo;
}

std::string claim_verdict(const FieldClaim& claim, const std::vector<ClaimedScene>& scenes) {
  std::string yes, same, no;
  for (const ClaimedScene& scene : scenes) {
    const Holds held = holds(claim, scene);
    std::string& list = held == Holds::kYes ? yes : held == Holds::kSame ? same : no;
    list += (list.empty() ? "" : ", ") + scene.scene;
  }
  if (yes.empty()) return "does not hold";
  if (same.empty() && no.empty()) return "holds";
  return "holds on " + yes + (same.empty() ? "" : "; no difference on " + same) + (no.empty() ? "" : "; not on " + no);
}

std::string claim_section(const FieldClaim& claim, const std::vector<ClaimedScene>& scenes) {
  const bool keeps = claim.kind == FieldClaim::Kind::kKeeps;
  std::string text = fmt::format("## {}\n\n{}\n\n*Source*: {}.\n\n", claim.id, claim.claim, claim.source);
  text += fmt::format("*Tested*: in each scene, {} of `{}` is {}.\n\n", claim.measure, claim.steppers.front(),
                      keeps ? "at most " + number(claim, claim.limit)
                            : fmt::format("smaller than that of `{}`", claim.steppers.back()));
  text += "| scene |";
  for (const std::string& stepper : claim.steppers) text += fmt::format(" `{}` |", stepper);
  text += fmt::format(" `{}` | holds |\n| --- | --- |", kBaseline);
  for (std::size_t i = 0; i <= claim.steppers.size(); ++i) text += " --- |";
  for (const ClaimedScene& scene : scenes) {
    text += fmt::format("\n| {} |", scene.scene);
    for (const std::vector<double>& values : scene.values) text += fmt::format(" {} |", range(claim, values));
    text += fmt::format(" {} |", word(holds(claim, scene)));
  }
  return text + fmt::format("\n\n**Verdict**: {}.\n", claim_verdict(claim, scenes));
}

std::string claims_page(const std::string& plan, const std::string& verdicts, const std::string& sections) {
  return fmt::format(
             R"(# Claims of the field, tested

What is said of ways to take time steps, and what {} steps of scenes show. This command makes the page anew; with
`--claim TITLE`, the title of a section, it tests one claim:

    lcpbench replay --plan {} --out FOLDER

Each scene is simulated three times, its first body displaced by 0, 1 and 2 micrometres: the tables give the least and
the largest number. The steps are as long as those of the scene. The [steppers](../howto/replay-a-scene.md#steppers) and
[measures](../howto/replay-a-scene.md#the-measures) have their pages.

- *Lost*: something that should stand or be held moved, or a contact sank, by more than {:g} m; or the replay ended
  early.
- `error_m`: the largest distance of a part from its place in a replay with the round cone in steps a sixteenth as long,
  at thirty times; lost only where the replay ended early.
- `{}`: the step without any contact. A stepper whose number is near it does nothing for that scene.
- A claim holds on a scene if it does in all three repetitions. Where it compares two steppers, numbers within 5 % of
  each other, and two numbers of at most 1e-4 m or J, make no difference; nor do two steppers that both lose the scene.

| claim | verdict |
| --- | --- |
)",
             kClaimSteps, plan, kLost, kBaseline) +
         verdicts + sections;
}

}  // namespace lcpbench
