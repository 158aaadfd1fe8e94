#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

#include "adapters/capture/engine.h"
#include "adapters/external/external_json.h"
#include "adapters/worker/asked_program.h"
#include "core/error.h"
#include "core/io/json_document.h"
#include "core/timed_solve.h"

namespace lcpbench::capture {

/// An engine that is a program of its own, asked by lines of JSON.
class AskedEngine : public Engine {
 public:
  /// @throws std::runtime_error where the program fails: the steps until then are kept
  void step(long index, Snapshot& snapshot, const VelocitySolver& loop) final {
    snapshot = {};
    origin_ = "step " + std::to_string(index);
    try {
      take(index, snapshot, loop);
    } catch (const InputError& error) {
      throw std::runtime_error(error.what());
    } catch (const worker::NoAnswer& failure) {
      throw std::runtime_error(origin_ + ": " + failure.what());
    }
  }

 protected:
  /// Starts the scene's program. @param origin what messages call its first answer
  /// @throws worker::NoAnswer where it does not start
  AskedEngine(const Scene& scene, std::string origin)
      : Engine(scene, "", ""),
        program_(external::command_words(scene.program), worker::AskedProgram::Channel::kStandard),
        origin_(std::move(origin)) {}

  /// A step into an empty snapshot. @throws worker::NoAnswer, and InputError for what is no such answer
  virtual void take(long index, Snapshot& snapshot, const VelocitySolver& loop) = 0;

  /// @throws as take()
  Json ask(const Json& question) {
    constexpr double kLongestAnswer_s = 60;
    constexpr std::size_t kLongestLine = std::size_t{1} << 28;  // bytes
    std::string line =
        program_.ask(question.dump() + "\n", external::line_size, kLongestLine, wall_clock_s() + kLongestAnswer_s);
    line.pop_back();
    return parse_json_document(line, origin_, true);
  }

  static void take_solve_time(const JsonObject& told, Snapshot& snapshot) {
    if (!told.given("solve_s")) return;
    snapshot.solve_s = told.number("solve_s");
    if (*snapshot.solve_s < 0) told.fail("solve_s", ": is negative");
  }

  const std::string& origin() const { return origin_; }

 private:
  worker::AskedProgram program_;
  std::string origin_;
};

}  // namespace lcpbench::capture
