#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/types.h"

namespace lcpbench {

/// A vector as the store keeps it: its length (32 bits), then index (32 bits) and IEEE bits (64 bits) of every entry
/// that is not +0, all little-endian. Exact: -0, NaN payloads and infinities come back bit for bit. At most 2^27
/// entries: decode_vector() refuses more.
std::string encode_vector(const Vector& vector);

/// The inverse. @throws InputError when the bytes are no encoded vector.
Vector decode_vector(std::string_view bytes);

/// An id of some content that is never negative: the upper 63 bits of XXH3-64. That any two of a million different
/// contents share an id has the probability 5e-8.
std::int64_t content_id(std::string_view bytes);

}  // namespace lcpbench
