#include <array>
#include <cstdint>
#include <fstream>
#include <string>

#include <fmt/format.h>

#include "core/error.h"
#include "study/store/store_files.h"

// The format of the log: https://www.sqlite.org/fileformat2.html#the_write_ahead_log

namespace lcpbench {
namespace {

constexpr std::size_t kHeaderBytes = 32;
constexpr std::size_t kFrameHeaderBytes = 24;
constexpr std::size_t kMostPageBytes = 65536;

std::uint32_t number_at(const char* bytes, bool big_endian = true) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) {
    const auto byte = static_cast<unsigned char>(bytes[big_endian ? i : 3 - i]);
    value = (value << 8U) | byte;
  }
  return value;
}

using Sums = std::array<std::uint32_t, 2>;

struct Log {
  bool big_endian = true;  ///< how the sums read the bytes
  std::size_t page_bytes = 0;
  std::array<std::uint32_t, 2> salt{};

  void add(Sums& sums, const char* bytes, std::size_t count) const {
    for (std::size_t i = 0; i < count; i += 8) {
      sums[0] += number_at(bytes + i, big_endian) + sums[1];
      sums[1] += number_at(bytes + i + 4, big_endian) + sums[0];
    }
  }
};

bool equal(const Sums& sums, const char* bytes) {
  return sums[0] == number_at(bytes) && sums[1] == number_at(bytes + 4);
}

/// @returns false where the header is not what was written
bool read_header(const char* bytes, Log& log, Sums& sums) {
  constexpr std::uint32_t kMagic = 0x377f0682;
  if ((number_at(bytes) & ~1U) != kMagic) return false;
  log.big_endian = (number_at(bytes) & 1U) != 0;
  log.page_bytes = number_at(bytes + 8);
  log.salt = {number_at(bytes + 16), number_at(bytes + 20)};
  log.add(sums, bytes, 24);
  return equal(sums, bytes + 24) && log.page_bytes >= 512 && log.page_bytes <= kMostPageBytes;
}

[[noreturn]] void refuse(const std::filesystem::path& store, const std::string& what) {
  throw InputError(
      fmt::format("{0}: the store is damaged: {1} of its write-ahead log {0}-wal is not what was written; without the "
                  "log the store lacks its last rows",
                  store.string(), what));
}

}  // namespace

void check_log(const std::filesystem::path& store) {
  std::ifstream file(side_file(store, "-wal"), std::ios::binary);
  std::string bytes(kHeaderBytes, '\0');
  if (!file.read(bytes.data(), kHeaderBytes)) return;
  Log log;
  Sums sums{};
  const bool sound_header = read_header(bytes.data(), log, sums);
  if (!sound_header) {
    if (file.peek() != std::ifstream::traits_type::eof()) refuse(store, "the header");
    return;
  }
  bytes.resize(kFrameHeaderBytes + log.page_bytes);
  std::uint64_t unsound = 0;       // number of the first unsound frame, counted from 1
  bool transaction_ended = false;  // of the first unsound frame
  for (std::uint64_t frame = 1; file.read(bytes.data(), static_cast<std::streamsize>(bytes.size())); ++frame) {
    const bool of_this_log = number_at(bytes.data() + 8) == log.salt[0] && number_at(bytes.data() + 12) == log.salt[1];
    if (unsound == 0) {
      log.add(sums, bytes.data(), 8);
      log.add(sums, bytes.data() + kFrameHeaderBytes, log.page_bytes);
      if (of_this_log && equal(sums, bytes.data() + 16)) continue;
      unsound = frame;
    } else if (!of_this_log) {
      continue;
    }
    // A frame that commits ends its transaction. The transaction of the unsound frame may be lost, no later one.
    const bool commits = number_at(bytes.data() + 4) != 0;
    if (commits && transaction_ended) refuse(store, fmt::format("frame {}", unsound));
    transaction_ended = transaction_ended || commits;
  }
}

}  // namespace lcpbench
