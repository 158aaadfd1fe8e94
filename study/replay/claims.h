#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "study/replay/replay_folder.h"

namespace lcpbench {

/// What somebody says of ways to take time steps, and the replays that test it.
struct FieldClaim {
  enum class Kind {
    kBetter,  ///< the first stepper's measure is smaller than the second's
    kKeeps,   ///< the stepper's measure is at most the limit
  };
  std::string id;
  std::string claim;
  std::string source;
  std::string engine;  ///< "ode" where the plan names none
  Kind kind = Kind::kBetter;
  std::string measure;  ///< "drift_m", "slip_m", "deepest_m", "energy_rise_j", or "error_m": see error_of()
  double limit = 0;
  std::vector<std::string> scenes;
  std::vector<std::string> steppers;
};

/// The steps that all claims are tested over, and what each scene's first body is put aside by, [m]: a repetition each.
inline constexpr std::int64_t kClaimSteps = 300;
inline constexpr double kClaimNudges[] = {0, 1e-6, 2e-6};
/// What stands for the truth where the measure is "error_m": the round cone, in steps a sixteenth as long.
inline constexpr std::int64_t kTruthDivide = 16;
inline constexpr const char* kTruthStepper = "exact{solver=cone_ipm{cone=true}}";

/// @param origin  what errors call the text @throws InputError naming what is wrong, also an unknown measure
std::vector<FieldClaim> read_claims(const std::string& text, const std::string& origin);

/// The measures of a scene: for each stepper of the claim, and then for kBaseline, one number for each repetition;
/// infinite where the scene was lost; error_m only where error_of() is.
struct ClaimedScene {
  std::string scene;
  std::vector<std::vector<double>> values;
};

/// The largest distance of a part from where the truth has it [m], over the frames that both have; infinite where the
/// replay ended before the truth did.
double error_of(const ScenesFile& frames, const ScenesFile& truth);

/// How far apart two replays of a scene are when they count as parted [m].
inline constexpr double kApart = 1e-4;

/// The time of the first frame in which a part is kApart from where another replay in the same steps has it, or that
/// the other lacks, since one of them ended early; infinity: there is none.
double parting_s(const ScenesFile& frames, const ScenesFile& other);

/// The measure of a replay; infinite where the scene was lost within `steps` steps, NaN where it has no such measure:
/// no claim holds then. @param measure  of FieldClaim, not "error_m"
double measure_of(const Replay& replay, std::int64_t steps, const std::string& measure);

/// What all repetitions of a scene say of the claim: yes, no difference, or no, also where some have no difference;
/// kSometimes: it holds in some.
enum class Holds { kYes, kNo, kSometimes, kSame };
Holds holds(const FieldClaim& claim, const ClaimedScene& scene);

/// "holds"; "does not hold" where no scene is kYes; else "holds on a, b; no difference on c; not on d", d being scenes
/// of kNo and kSometimes.
std::string claim_verdict(const FieldClaim& claim, const std::vector<ClaimedScene>& scenes);

/// The claim's part of the page, with its table.
std::string claim_section(const FieldClaim& claim, const std::vector<ClaimedScene>& scenes);

/// The page, in Markdown, for kClaimSteps and kClaimNudges. @param plan  its name or file, as --plan takes it
/// @param verdicts  rows of its first table @param sections  those of claim_section(), a blank line before each
std::string claims_page(const std::string& plan, const std::string& verdicts, const std::string& sections);

/// The embedded plan.
extern const std::string_view kClaimsOfTheField;

}  // namespace lcpbench
