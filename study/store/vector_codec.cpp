#include "study/store/vector_codec.h"

#define XXH_INLINE_ALL
#include <bit>

#include <xxhash.h>

#include "core/error.h"

namespace lcpbench {
namespace {

constexpr std::size_t kLengthBytes = 4;
constexpr std::size_t kIndexBytes = 4;
constexpr std::size_t kEntryBytes = kIndexBytes + 8;
constexpr std::uint64_t kMaxLength = std::uint64_t{1} << 27;  // 1 GiB decoded: more is a damaged length

void append(std::string& bytes, std::uint64_t value, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) bytes.push_back(static_cast<char>((value >> (8 * i)) & 0xff));
}

std::uint64_t read(std::string_view bytes, std::size_t begin, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[begin + i])) << (8 * i);
  }
  return value;
}

}  // namespace

std::string encode_vector(const Vector& vector) {
  std::string bytes;
  bytes.reserve(kLengthBytes + kEntryBytes * static_cast<std::size_t>(vector.size()));
  append(bytes, static_cast<std::uint64_t>(vector.size()), kLengthBytes);
  for (Index i = 0; i < vector.size(); ++i) {
    const auto bits = std::bit_cast<std::uint64_t>(vector[i]);
    if (bits == 0) continue;
    append(bytes, static_cast<std::uint64_t>(i), kIndexBytes);
    append(bytes, bits, 8);
  }
  return bytes;
}

Vector decode_vector(std::string_view bytes) {
  const InputError damaged("the store is damaged: a vector does not decode");
  if (bytes.size() < kLengthBytes || (bytes.size() - kLengthBytes) % kEntryBytes != 0) throw damaged;
  const std::uint64_t size = read(bytes, 0, kLengthBytes);
  if (size > kMaxLength) throw damaged;
  Vector vector = Vector::Zero(static_cast<Index>(size));
  for (std::size_t at = kLengthBytes; at < bytes.size(); at += kEntryBytes) {
    const std::uint64_t index = read(bytes, at, kIndexBytes);
    if (index >= size) throw damaged;
    vector[static_cast<Index>(index)] = std::bit_cast<double>(read(bytes, at + kIndexBytes, 8));
  }
  return vector;
}

std::int64_t content_id(std::string_view bytes) {
  return static_cast<std::int64_t>(XXH3_64bits(bytes.data(), bytes.size()) >> 1U);
}

}  // namespace lcpbench
