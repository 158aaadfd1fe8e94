#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/io/line_stream.h"
#include "core/problem.h"

namespace lcpbench {

/// A body's shape, for pictures: its kind and its measures, in the body's frame.
struct SceneShape {
  int body = -1;     ///< -1: the world
  std::string type;  ///< "box", "sphere", "capsule", "cylinder", "plane", ...
  std::vector<double> size;
};

/// What a scenes file says once.
struct ScenesHeader {
  std::string scene;
  std::string engine;
  std::string engine_version;
  std::string loop;                   ///< whose impulses moved the scene on: "engine", or a solver's name
  std::optional<double> step_length;  ///< [s]
  std::vector<double> gravity;        ///< [m/s^2]: three entries, or none where it is not known
  std::vector<SceneShape> shapes;
};

/// The largest number of a step: JSON readers keep every integer up to it.
inline constexpr std::int64_t kLargestStep = std::int64_t{1} << 53;

/// Of a file: their index takes 40 bytes each.
inline constexpr std::size_t kMostSteps = std::size_t{1} << 22;

/// One captured step. All but the number and the problem may be empty.
struct SceneStep {
  std::int64_t step = 0;  ///< up to kLargestStep
  std::optional<double> time;              ///< [s]
  Problem problem;                         ///< with contacts
  std::vector<double> gap;                 ///< nc [m], negative: penetration
  std::vector<std::string> contact_ids;    ///< nc names that contacts keep from step to step
  std::vector<std::vector<double>> poses;  ///< per body of the pictures: position and quaternion (w, x, y, z), or empty
  Vector engine_impulses;                  ///< the engine's [N s]: f_N, then f_D; read() gives them to `problem` too
  Vector engine_velocity;                  ///< the engine's own velocity after the step: ngc entries
};

/// A file of captured steps (docs/reference/scenes-file.md), opened: an index of its steps, each read when asked for.
/// Memory: the index, and the text of one step. Thread-safe. An `index` below is less than count().
class ScenesFile {
 public:
  /// Reads the header and finds the steps, without parsing them. @throws InputError
  explicit ScenesFile(const std::string& file) : ScenesFile(LineStream(file), file) {}
  /// The same of bytes in memory, which must outlive it; `origin` stands for the file in errors.
  ScenesFile(std::string_view bytes, const std::string& origin) : ScenesFile(LineStream(bytes, origin), origin) {}

  const ScenesHeader& header() const { return header_; }
  std::size_t count() const { return steps_.size(); }
  /// The number of the step in the simulation; ascending.
  std::int64_t step_number(std::size_t index) const { return steps_[index].step; }
  /// @throws InputError when there is no such step, naming those near it
  std::size_t index_of(std::int64_t step) const;
  /// Parses a step. @throws InputError naming file, line and field
  SceneStep read(std::size_t index) const;
  /// The line of a step as it stands in the file, without its end.
  std::string line(std::size_t index) const;
  /// What is missing at the end, in a sentence; empty for a complete file.
  const std::string& truncation() const { return truncation_; }

 private:
  struct Entry {
    std::int64_t step;
    LinePlace place;
  };

  ScenesFile(LineStream stream, const std::string& origin);
  bool is_whole(const LineStream::Line& line);
  void add(const LineStream::Line& line);
  void truncate(const std::string& cause);

  mutable LineStream stream_;
  mutable std::mutex mutex_;  ///< of stream_
  std::string origin_;
  ScenesHeader header_;
  std::vector<Entry> steps_;
  std::string truncation_;
};

/// The line of a step as ScenesWriter writes it, without its end. @throws InputError for what read() would refuse
std::string scenes_line(const SceneStep& step);

/// Writes a scenes file, compressed; what has been added survives when the program is killed.
class ScenesWriter {
 public:
  /// @param level of zstd's compression @throws InputError when the file cannot be created, or the header not be read
  /// again
  ScenesWriter(const std::string& file, const ScenesHeader& header, int level = 9);
  ~ScenesWriter();
  /// @throws InputError when it cannot be written, and for a step that could not be read again or whose number is not
  /// above the last, which is left out
  void add(const SceneStep& step);
  /// A line that is a step as the reference has it, without its end. Not checked.
  void add_line(std::string_view line);
  /// @throws InputError when not all of it arrived
  void close();

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// "F.scenes#120" in its two parts; nullopt for a name without ".scenes#". @throws InputError when no number of a step
/// follows
std::optional<std::pair<std::string, std::int64_t>> scenes_step(const std::string& name);

/// Whether a file's name says that it holds captured steps.
bool is_scenes_file(std::string_view name);

}  // namespace lcpbench
