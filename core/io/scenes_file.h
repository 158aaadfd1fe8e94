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
  std::string type;  ///< "box", "sphere", "capsule", "cylinder", "plane", "hull", ...
  std::vector<double> size;

  /// Empty, or what is wrong with the size of a hull. A file may hold other shapes of any size, of which only those are
  /// drawn that are as docs/reference/scenes-file.md says.
  std::string fault() const;
};

/// The first line of a scenes file: what holds for all its steps.
struct ScenesHeader {
  std::string scene;
  std::string engine;
  std::string engine_version;
  std::string loop;                   ///< whose impulses moved the scene on: "engine", or a solver's name
  std::optional<double> step_length;  ///< [s]
  std::vector<double> gravity;        ///< [m/s^2]: three entries, or none where it is not known
  std::vector<SceneShape> shapes;

  /// Name and version of the engine: "MuJoCo 3.2.7"; "" where it is not known.
  std::string engine_label() const {
    return engine + (engine.empty() || engine_version.empty() ? "" : " ") + engine_version;
  }
};

/// The largest step number. JSON readers that store numbers as doubles keep every integer up to it.
inline constexpr std::int64_t kLargestStep = std::int64_t{1} << 53;

/// The most steps of a file. An opened file's index takes 24 bytes a step, and up to twice that with reserved memory.
inline constexpr std::size_t kMostSteps = std::size_t{1} << 22;

/// One captured step. Members other than `step` and `problem` may be empty.
struct SceneStep {
  std::int64_t step = 0;                   ///< its number in the simulation: 0 to kLargestStep
  std::optional<double> time;              ///< [s]
  Problem problem;                         ///< of kind contact or scene
  std::vector<double> gap;                 ///< nc [m], negative: penetration
  std::vector<std::string> contact_ids;    ///< nc names that contacts keep from step to step
  std::vector<std::vector<double>> poses;  ///< by SceneShape::body: position [m] and quaternion (w, x, y, z), or empty
  /// Of each contact point [m], normal and tangent, in the world: 9 numbers, or none where it has no place.
  std::vector<std::vector<double>> contact_frames;
  Vector engine_impulses;                  ///< the engine's: f_N, f_D, f_R; read() also sets them in `problem`
  std::optional<double> engine_solve_s;    ///< [s] that the engine's own solver took
  Vector engine_velocity;                  ///< the engine's own velocity after the step [m/s, rad/s]: ngc entries
  /// How the problem differs from the step that the engine took, each as "what: how many".
  std::vector<std::string> notes;
};

/// An opened file of captured steps (docs/reference/scenes-file.md). It holds an index of the steps, and reads a step
/// when that is asked for. Memory: the index, and the text of one step. Thread-safe. @pre index < count()
class ScenesFile {
 public:
  /// Reads the header and finds the steps, without parsing them. @throws InputError
  explicit ScenesFile(const std::string& file) : ScenesFile(LineStream(file), file) {}
  /// Reads from memory; the bytes must outlive this object. Errors name `origin` in place of the file.
  ScenesFile(std::string_view bytes, const std::string& origin) : ScenesFile(LineStream(bytes, origin), origin) {}

  const ScenesHeader& header() const { return header_; }
  std::size_t count() const { return steps_.size(); }
  /// The step's number in the simulation. Numbers ascend with the index.
  std::int64_t step_number(std::size_t index) const { return steps_[index].step; }
  /// @throws InputError when there is no such step, naming those near it
  std::size_t index_of(std::int64_t step) const;
  /// Parses a step. @throws InputError naming file, line and field
  SceneStep read(std::size_t index) const;
  /// The line of a step as it stands in the file, without its end. @throws InputError when it cannot be read again
  std::string line(std::size_t index) const;
  /// A sentence that says what is missing at the end of the file; empty for a complete file.
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

/// The line of a step as ScenesWriter writes it, without its end. @throws InputError for one that read() would refuse
std::string scenes_line(const SceneStep& step);

/// Writes a compressed scenes file. If the program is killed before close(), the steps that were added can be read, and
/// ScenesFile may call the file truncated.
class ScenesWriter {
 public:
  /// Overwrites the file. @param level  of zstd's compression
  /// @throws InputError when the file cannot be written, or for a header that ScenesFile would refuse
  ScenesWriter(const std::string& file, const ScenesHeader& header, int level = 9);
  ~ScenesWriter();
  /// @throws InputError when the file cannot be written. Also, and then writes nothing: for a step that read() would
  /// refuse, for a number that is not above the last one, and beyond kMostSteps
  void add(const SceneStep& step);
  /// Adds a step as its line of text, without the line end; it is neither checked nor counted.
  /// @throws InputError when the file cannot be written
  void add_line(std::string_view line);
  /// Ends the compressed data. @throws InputError when the file cannot be written
  void close();

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Splits "F.scenes#120" into file and step number; nullopt for a name without ".scenes#".
/// @throws InputError when what follows is not an integer >= 0
std::optional<std::pair<std::string, std::int64_t>> scenes_step(const std::string& name);

/// Whether a file's name ends in ".scenes".
bool is_scenes_file(std::string_view name);

}  // namespace lcpbench
