#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace lcpbench {

/// The Philox4x64-10 bijection: one block of four 64-bit words for each counter under a key.
/// [Salmon, Moraes, Dror, Shaw 2011, "Parallel random numbers: as easy as 1, 2, 3"]
std::array<std::uint64_t, 4> philox_block(const std::array<std::uint64_t, 4>& counter,
                                          const std::array<std::uint64_t, 2>& key);

/// The number of a stream name: FNV-1a, 64 bits, over its bytes. Part of the frozen layout.
std::uint64_t stream_id(std::string_view name);

/// Names one trial of one random set. Equal keys give equal draws; any other key gives an unrelated sequence.
struct TrialKey {
  std::uint64_t stream = 0;  ///< stream_id of the set's stream name
  std::uint64_t seed = 0;
  std::uint64_t trial = 0;
};

/// The purpose of a draw. Each purpose has its own sequence, so that more draws for one purpose never shift another.
/// The numbers are part of the frozen layout (docs/reference/generators.md): never reuse or renumber one.
enum class Purpose : std::uint64_t {
  kCoordinateCount = 1,
  kContactCount = 2,
  kRedundantCount = 3,
  kEdgeCount = 4,
  kInertiaRank = 5,
  kVelocity = 6,
  kNormals = 7,
  kTangents = 8,
  kFriction = 9,
  kInertiaVectors = 10,
  kInertiaWeights = 11,
  kRedundancySources = 12,
  kRedundancyFactors = 13,
  kRedundancyPlaces = 14,
  kBodyCount = 32,
  kBodyMass = 33,
  kBodyShape = 34,
  kBodyPosition = 35,
  kContactBodies = 36,
  kContactPoints = 37,
  kConditioning = 38,
  kMadeTrial = 40,
  kMadeShape = 41,
  kMadeVelocity = 42,
  kMadeFriction = 43,
  kMadeOffset = 44,
  kMatrixOrder = 48,
  kMatrixCondition = 49,
  kMatrixVectors = 50,
  kPlantedSupport = 51,
  kPlantedValues = 52,
  kChange = 65,
};

/// Draws of the grid are integers k that stand for the dyadic number k * kGridStep.
constexpr int kGridBits = 20;
constexpr double kGridStep = 0x1p-20;

/// The sequence of draws of one purpose in one trial. Word i is lane i mod 4 of
/// philox_block(counter = (i div 4, trial, purpose, attempt), key = (seed, stream)).
class DrawSequence {
 public:
  /// @param attempt 0, or how many whole draws of this purpose were refused before.
  DrawSequence(const TrialKey& key, Purpose purpose, std::uint64_t attempt = 0);

  /// The next 64 uniform bits.
  std::uint64_t word();

  /// Uniform on {low, ..., high}, without bias: words below 2^64 mod (high - low + 1) are passed over. @pre low <= high
  std::int64_t integer(std::int64_t low, std::int64_t high);

  /// Uniform on {-2^20, ..., 2^20 - 1}: U(-1, 1) in grid steps. One word, its upper 21 bits.
  std::int64_t signed_grid();

  /// Uniform on {0, ..., 2^20 - 1}: U(0, 1) in grid steps. One word, its upper 20 bits.
  std::int64_t unit_grid();

 private:
  std::array<std::uint64_t, 2> key_;
  std::array<std::uint64_t, 4> counter_;
  std::array<std::uint64_t, 4> block_{};
  std::size_t lane_ = 4;
};

/// A Fisher-Yates shuffle from the last place down.
template <class T>
void shuffle(std::vector<T>& order, DrawSequence& draws) {
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[static_cast<std::size_t>(draws.integer(0, static_cast<std::int64_t>(i) - 1))]);
  }
}

}  // namespace lcpbench
