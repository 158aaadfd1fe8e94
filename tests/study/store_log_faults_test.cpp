// What a user relies on: the write-ahead log of a writer that was killed gives its rows back, and one that was damaged is
// refused unless only its last transaction is cut.

#include <cstdint>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/study/filled_store.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;

using StoreFaultsTest = FilledStoreTest;

std::string read_bytes(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// A killed writer's last rows stand in its log only.
class LogOfAKilledWriterTest : public StoreFaultsTest {
 protected:
  void SetUp() override {
    StoreFaultsTest::SetUp();
    {
      SyntheticStore writer(file_);
      for (std::int64_t trial = 0; trial < 4; ++trial) {
        writer.problem("paper/monotone/exp4", trial, {{writer.solver("lemke"), {}}});
        states_.push_back(rows(file_));
      }
      fs::copy_file(file_, killed_);
      fs::copy_file(file_.string() + "-wal", killed_.string() + "-wal");
    }
    main_ = read_bytes(killed_);
    log_ = read_bytes(killed_.string() + "-wal");
    ASSERT_EQ(checked_rows(killed_), states_.back());
  }

  /// What a command says of the store with one bit of its log flipped. @param after  becomes the rows, if it is read
  std::string cause_after_flip(std::uint64_t bit, std::string& after) const {
    std::string damaged = log_;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    std::ofstream(killed_, std::ios::binary) << main_;
    std::ofstream(killed_.string() + "-wal", std::ios::binary) << damaged;
    fs::remove(killed_.string() + "-shm");
    return input_error([&] { after = checked_rows(killed_); });
  }

  std::uint32_t number_at(std::size_t at) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = (value << 8U) | static_cast<unsigned char>(log_[at + i]);
    return value;
  }

  fs::path killed_ = folder_ / "killed.db";
  std::vector<std::string> states_;  ///< after each transaction
  std::string main_;
  std::string log_;
};

TEST_F(LogOfAKilledWriterTest, OneFlippedBitIsRefusedUnlessTheLastTransactionIsCut) {
  std::mt19937_64 random(16);
  int refused = 0;
  constexpr int kFlips = 300;
  for (int i = 0; i < kFlips; ++i) {
    const std::uint64_t bit = random() % (8 * log_.size());
    std::string after;
    const std::string cause = cause_after_flip(bit, after);
    if (cause != "no InputError") {
      ++refused;
      EXPECT_TRUE(contains(cause, "killed.db-wal is not what was written")) << cause;
    } else {
      EXPECT_TRUE(after == states_.back() || after == states_.end()[-2]) << "bit " << bit;
    }
  }
  EXPECT_GT(refused, kFlips / 2);
}

/// A power cut can leave out any frame of the last transaction.
TEST_F(LogOfAKilledWriterTest, DamageOfAnyFrameDropsTheLastTransactionAndRefusesTheOthers) {
  constexpr std::size_t kHeader = 32;
  constexpr std::size_t kFrameHeader = 24;
  const std::size_t frame_bytes = kFrameHeader + number_at(8);
  std::vector<std::size_t> frames;
  std::size_t last_begins = 0;  // the transaction
  std::size_t next_begins = 0;
  for (std::size_t at = kHeader; at + frame_bytes <= log_.size(); at += frame_bytes) {
    if (number_at(at + 8) != number_at(16) || number_at(at + 12) != number_at(20)) break;  // of an older log
    frames.push_back(at);
    if (number_at(at + 4) == 0) continue;
    last_begins = next_begins;
    next_begins = frames.size();
  }
  ASSERT_EQ(next_begins, frames.size());
  ASSERT_GT(frames.size() - last_begins, 2U) << "the last transaction has several frames";
  ASSERT_GT(last_begins, 2U);
  for (std::size_t frame = 0; frame < frames.size(); ++frame) {
    std::string after;
    const std::string cause = cause_after_flip(8 * (frames[frame] + kFrameHeader + 100), after);
    if (frame >= last_begins) {
      EXPECT_EQ(cause, "no InputError") << "frame " << frame + 1;
      EXPECT_TRUE(after == states_.end()[-2]) << "frame " << frame + 1;
    } else {
      EXPECT_TRUE(contains(cause, "frame " + std::to_string(frame + 1) + " of its write-ahead log")) << cause;
    }
  }
}

}  // namespace
}  // namespace lcpbench
