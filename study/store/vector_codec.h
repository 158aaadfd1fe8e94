#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/types.h"

namespace lcpbench {

/// A vector as the store keeps it: its length (32 bits), then index (32 bits) and IEEE bits (64 bits) of every entry
/// that is not +0, all little-endian. Exact: -0, NaN payloads and infinities come back bit for bit.
std::string encode_vector(const Vector& vector);

/// The inverse. @throws InputError when the bytes are no encoded vector.
Vector decode_vector(std::string_view bytes);

/// A 63-bit id of some content: XXH3-64 without its sign bit. Two of a million different contents share an id with
/// probability 5e-8.
std::int64_t content_id(std::string_view bytes);

}  // namespace lcpbench
