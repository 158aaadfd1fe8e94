// How far ways to take time steps are from the truth over time: step_truth ENGINE SECONDS FOLDER STEPPERS SCENE... The
// reference steps the scene on exactly, with steps 16 times as short, or FINEST times (a power of 4) where the variable
// of this name is set; its hash (FNV-1a of the bits of all positions) is in its own row. A second reference that begins 1e-12 m beside it
// tells how long a trajectory means anything: until the two are 0.1 mm apart. Until then positions are compared. Prints
// CSV; the FOLDER takes the simulations.
#include <algorithm>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "adapters/capture/launch.h"
#include "adapters/capture/scene.h"
#include "core/error.h"
#include "core/io/scenes_file.h"
#include "core/spec.h"

namespace lcpbench {
namespace {

constexpr double kApart = 1e-4;  // m
int finest() {
  const char* const asked = std::getenv("FINEST");
  return asked != nullptr ? std::atoi(asked) : 16;
}
constexpr const char* kReference = "exact{solver=cone_ipm{cone=true}}";

/// Positions of all parts, one entry for each hundredth of a second.
using Motion = std::vector<std::vector<double>>;

class Runs {
 public:
  Runs(std::string engine, double seconds, std::string folder)
      : engine_(std::move(engine)), seconds_(seconds), folder_(std::move(folder)) {}

  Motion run(const std::string& scene, int divide, double nudge, const std::string& stepper) const {
    const double h = capture::find_scene(scene).step / divide;
    const long every = std::lround(0.01 / h);
    const long steps = std::lround(seconds_ / h) + 1;
    const std::string file = folder_ + "/motion.scenes";
    const std::string spec = fmt::format("{}{{divide={},nudge={:g}}}", scene, divide, nudge);
    const volatile std::sig_atomic_t never = 0;
    const capture::EngineRun run = capture::run_engine(
        engine_, {spec, "", std::to_string(every), std::to_string(steps), file, stepper, file + ".csv", ""}, &never);
    if (run.ending != "exited with code 0") throw InputError(spec + " with " + stepper + ": " + run.message);
    Motion motion;
    const ScenesFile frames(file);
    for (std::size_t i = 0; i < frames.count(); ++i) {
      if (frames.step_number(i) % every != 0) continue;
      std::vector<double>& positions = motion.emplace_back();
      for (const std::vector<double>& pose : frames.read(i).poses) {
        if (pose.size() >= 3) positions.insert(positions.end(), pose.begin(), pose.begin() + 3);
      }
    }
    return motion;
  }

 private:
  std::string engine_;
  double seconds_;
  std::string folder_;
};

double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = a.size() == b.size() ? 0 : 1e300;
  for (std::size_t i = 0; i + 2 < std::min(a.size(), b.size()); i += 3) {
    largest = std::max(largest, std::hypot(a[i] - b[i], a[i + 1] - b[i + 1], a[i + 2] - b[i + 2]));
  }
  return largest;
}

/// Frames until two motions part.
std::size_t parting(const Motion& a, const Motion& b) {
  std::size_t frame = 0;
  while (frame < std::min(a.size(), b.size()) && apart(a[frame], b[frame]) < kApart) ++frame;
  return frame;
}

std::uint64_t hash(const Motion& motion) {
  std::uint64_t sum = 0xcbf29ce484222325U;
  for (const std::vector<double>& frame : motion) {
    for (const double place : frame) sum = (sum ^ std::bit_cast<std::uint64_t>(place)) * 0x100000001b3U;
  }
  return sum;
}

void measure(const Runs& runs, const std::string& scene, const std::vector<std::string>& steppers) {
  const Motion truth = runs.run(scene, finest(), 0, kReference);
  const std::size_t frames = parting(truth, runs.run(scene, finest(), 1e-12, kReference));
  const auto print = [&](const std::string& stepper, int divide) {
    const Motion motion = divide == finest() ? truth : runs.run(scene, divide, 0, stepper);
    double largest = 0;
    for (std::size_t i = 0; i < std::min(frames, motion.size()); ++i) {
      largest = std::max(largest, apart(motion[i], truth[i]));
    }
    const bool to_the_end = motion.size() >= frames;
    fmt::print("{},\"{}\",{},{:.2f},{},{:.3g},{},{}\n", scene, stepper, divide, 0.01 * static_cast<double>(frames),
               frames == truth.size() ? "no" : "yes", largest, to_the_end ? "yes" : "no",
               divide == finest() ? fmt::format("{:016x}", hash(truth)) : "");
    std::fflush(stdout);
  };
  for (int divide = 1; divide <= finest(); divide *= 4) print(kReference, divide);
  for (const std::string& stepper : steppers) print(stepper, 1);
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 6) {
    std::fprintf(stderr, "usage: %s ENGINE SECONDS FOLDER STEPPERS SCENE...\n", argv[0]);
    return 2;
  }
  try {
    std::filesystem::create_directories(argv[3]);
    const lcpbench::Runs runs(argv[1], std::atof(argv[2]), argv[3]);
    fmt::print("scene,stepper,divide,until_s,parts,error_m,to_the_end,hash\n");
    for (int i = 5; i < argc; ++i) lcpbench::measure(runs, argv[i], lcpbench::split_top_level(argv[4]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
