#include "core/io/line_stream.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>
#include <system_error>
#include <utility>

#include <zstd.h>

#include "core/io/problem_checks.h"

namespace lcpbench {
namespace {

constexpr std::size_t kPieceBytes = std::size_t{1} << 17;

}  // namespace

struct LineStream::Decompressor {
  std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context{ZSTD_createDCtx(), ZSTD_freeDCtx};
  std::string buffer = std::string(kPieceBytes, '\0');
  ZSTD_inBuffer input{nullptr, 0, 0};
  bool inside = false;  ///< a frame has begun and has not ended
};

LineStream::LineStream(const std::string& file) : origin_(file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found) throw input_error(origin_, "no such file");
  if (status.type() != std::filesystem::file_type::regular) throw input_error(origin_, "is not a regular file");
  file_.open(file, std::ios::binary);
  if (!file_) throw input_error(origin_, std::string("cannot be opened: ") + std::strerror(errno));
  begin();
}

LineStream::LineStream(std::string_view bytes, std::string origin)
    : origin_(std::move(origin)), bytes_(bytes), in_memory_(true) {
  begin();
}

LineStream::~LineStream() = default;
LineStream::LineStream(LineStream&&) noexcept = default;

void LineStream::begin() {
  constexpr std::string_view kZstd = "\x28\xB5\x2F\xFD";
  std::string beginning(kZstd.size(), '\0');
  beginning.resize(read(beginning.data(), beginning.size()));
  if (beginning == kZstd) zstd_ = std::make_unique<Decompressor>();
  if (zstd_ && !zstd_->context) throw std::bad_alloc();
  restart(0);
}

std::size_t LineStream::read(char* to, std::size_t count) {
  std::size_t got = 0;
  if (in_memory_) {
    got = std::min<std::uint64_t>(count, bytes_.size() - std::min<std::uint64_t>(input_at_, bytes_.size()));
    std::copy_n(bytes_.data() + input_at_, got, to);
  } else {
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(input_at_));
    file_.read(to, static_cast<std::streamsize>(count));
    if (file_.bad()) throw input_error(origin_, "cannot be read");
    got = static_cast<std::size_t>(file_.gcount());
  }
  input_at_ += got;
  return got;
}

void LineStream::restart(std::uint64_t at) {
  input_at_ = at;
  piece_.clear();
  used_ = 0;
  total_ = 0;
  piece_place_ = {zstd_ ? at : 0, zstd_ ? 0 : at};
  if (!zstd_) return;
  ZSTD_DCtx_reset(zstd_->context.get(), ZSTD_reset_session_only);
  zstd_->input = {zstd_->buffer.data(), 0, 0};
  zstd_->inside = false;
}

/// The next piece of the text, of one frame; false at its end.
bool LineStream::fill() {
  piece_place_.offset += piece_.size();
  used_ = 0;
  piece_.resize(kPieceBytes);
  if (!zstd_) {
    piece_.resize(read(piece_.data(), piece_.size()));
    return !piece_.empty();
  }
  ZSTD_inBuffer& input = zstd_->input;
  for (;;) {
    if (input.pos == input.size) {
      input = {zstd_->buffer.data(), read(zstd_->buffer.data(), zstd_->buffer.size()), 0};
    }
    if (!zstd_->inside) piece_place_ = {input_at_ - (input.size - input.pos), 0};
    ZSTD_outBuffer output{piece_.data(), piece_.size(), 0};
    const bool exhausted = input.size == 0;
    if (exhausted && !zstd_->inside) break;
    const std::size_t result = ZSTD_decompressStream(zstd_->context.get(), &output, &input);
    if (ZSTD_isError(result)) {
      throw input_error(origin_, std::string("damaged compression: ") + ZSTD_getErrorName(result));
    }
    zstd_->inside = result != 0;
    total_ += output.pos;
    if (total_ > kAnyTextBytes && (total_ - kAnyTextBytes) / kMaxExpansion > input_at_) {
      throw input_error(origin_, "its text is more than " + std::to_string(kMaxExpansion) +
                                     " times as long as its compressed bytes");
    }
    if (total_ > kMaxTextBytes) {
      throw input_error(origin_, "more than " + std::to_string(kMaxTextBytes) + " bytes of text");
    }
    if (output.pos > 0) {
      piece_.resize(output.pos);
      return true;
    }
    if (exhausted) break;
  }
  piece_.clear();
  return false;
}

bool LineStream::next(Line& line, std::uint64_t keep) {
  text_.clear();
  line = {};
  bool begun = false;
  for (;;) {
    if (used_ == piece_.size() && !fill()) return begun;
    if (!begun) line.place = {piece_place_.frame, piece_place_.offset + used_};
    begun = true;
    const std::size_t end = std::min(piece_.find('\n', used_), piece_.size());
    const std::size_t count = end - used_;
    if (text_.size() < keep) {
      text_.append(piece_, used_, static_cast<std::size_t>(std::min<std::uint64_t>(count, keep - text_.size())));
    }
    line.size += count;
    used_ = end;
    if (line.size > kMaxLineBytes) {
      throw input_error(origin_, "a line of more than " + std::to_string(kMaxLineBytes) + " bytes");
    }
    if (end == piece_.size()) continue;
    ++used_;
    line.ended = true;
    return true;
  }
}

void LineStream::seek(LinePlace place) {
  const LinePlace here{piece_place_.frame, piece_place_.offset + used_};
  if (!zstd_) return restart(place.offset);
  if (place.frame != here.frame || place.offset < here.offset) restart(place.frame);
  for (;;) {
    const std::uint64_t end = piece_place_.offset + piece_.size();
    if (piece_place_.frame == place.frame && place.offset < end && place.offset >= piece_place_.offset) break;
    if (!fill()) throw input_error(origin_, "has changed while it was read");
  }
  used_ = static_cast<std::size_t>(place.offset - piece_place_.offset);
}

bool LineStream::cut_off() const { return zstd_ && zstd_->inside; }

}  // namespace lcpbench
