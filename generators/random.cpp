#include "generators/random.h"

#include <Random123/philox.h>

namespace lcpbench {

std::array<std::uint64_t, 4> philox_block(const std::array<std::uint64_t, 4>& counter,
                                          const std::array<std::uint64_t, 2>& key) {
  const philox4x64_ctr_t in = {{counter[0], counter[1], counter[2], counter[3]}};
  const philox4x64_key_t with = {{key[0], key[1]}};
  const philox4x64_ctr_t out = philox4x64_R(10, in, with);
  return {out.v[0], out.v[1], out.v[2], out.v[3]};
}

std::uint64_t stream_id(std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char letter : name) {
    hash ^= static_cast<unsigned char>(letter);
    hash *= 0x100000001b3U;
  }
  return hash;
}

DrawSequence::DrawSequence(const TrialKey& key, Purpose purpose, std::uint64_t attempt)
    : key_{key.seed, key.stream}, counter_{0, key.trial, static_cast<std::uint64_t>(purpose), attempt} {}

std::uint64_t DrawSequence::word() {
  if (lane_ == block_.size()) {
    block_ = philox_block(counter_, key_);
    ++counter_[0];
    lane_ = 0;
  }
  return block_[lane_++];
}

std::int64_t DrawSequence::integer(std::int64_t low, std::int64_t high) {
  const std::uint64_t count = static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low) + 1;
  if (count == 0) return static_cast<std::int64_t>(word());  // all 2^64
  const std::uint64_t surplus = (0 - count) % count;         // 2^64 mod count
  std::uint64_t drawn = word();
  while (drawn < surplus) drawn = word();
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(low) + drawn % count);
}

std::int64_t DrawSequence::signed_grid() {
  return static_cast<std::int64_t>(word() >> (63 - kGridBits)) - (std::int64_t{1} << kGridBits);
}

std::int64_t DrawSequence::unit_grid() { return static_cast<std::int64_t>(word() >> (64 - kGridBits)); }

}  // namespace lcpbench
