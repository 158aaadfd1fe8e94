#pragma once

#include <cstdint>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

namespace lcpbench {

/// Where an uncompressed byte is: so many bytes behind the beginning of the compressed frame at `frame`. A file that is
/// not compressed is one frame at 0.
struct LinePlace {
  std::uint64_t frame = 0;
  std::uint64_t offset = 0;
};

/// The lines of a text that is plain or compressed by zstd, told by its first bytes. Holds one piece of the text, not
/// the whole. Errors (InputError) name the origin: lines above 256 MiB, compressed texts above 64 GiB or far longer
/// than their compressed bytes, damaged compression.
class LineStream {
 public:
  static constexpr std::uint64_t kMaxLineBytes = std::uint64_t{1} << 28;
  static constexpr std::uint64_t kMaxTextBytes = std::uint64_t{1} << 36;
  /// A text longer than kAnyTextBytes may be at most kMaxExpansion times as long as the compressed bytes read so far.
  /// Captured steps are about 8 times as long.
  static constexpr std::uint64_t kAnyTextBytes = std::uint64_t{1} << 28;
  static constexpr std::uint64_t kMaxExpansion = 1024;

  /// @throws InputError when the file cannot be opened
  explicit LineStream(const std::string& file);
  /// Views the bytes; they must outlive the stream.
  LineStream(std::string_view bytes, std::string origin);
  ~LineStream();
  LineStream(LineStream&&) noexcept;

  struct Line {
    LinePlace place;
    std::uint64_t size = 0;  ///< without its end
    bool ended = false;      ///< false: the text ends here without a line end
  };

  /// Goes past the next line; false at the end of the text. Keeps the line's first `keep` bytes in text().
  bool next(Line& line, std::uint64_t keep = kMaxLineBytes);
  const std::string& text() const { return text_; }

  /// The next line is the one that begins there. What lies between is read only where a frame has to be decompressed.
  void seek(LinePlace place);

  /// After the last line: whether the text ends inside a compressed frame.
  bool cut_off() const;

 private:
  struct Decompressor;

  void begin();
  std::size_t read(char* to, std::size_t count);
  void restart(std::uint64_t at);
  bool fill();

  std::string origin_;
  std::ifstream file_;
  std::string_view bytes_;
  bool in_memory_ = false;
  std::uint64_t input_at_ = 0;          ///< of the next byte that is read from the file or from memory
  std::unique_ptr<Decompressor> zstd_;  ///< none for plain text
  std::string piece_;                   ///< uncompressed
  std::size_t used_ = 0;                ///< of piece_
  LinePlace piece_place_;
  std::uint64_t total_ = 0;  ///< decompressed bytes since the last restart()
  std::string text_;
};

}  // namespace lcpbench
