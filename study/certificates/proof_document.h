#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/problem.h"
#include "study/certify/certificate.h"

namespace lcpbench {

/// A problem and what is proven of it, as one line of JSON without the newline: all that someone needs who trusts
/// nothing of ours. study/check_certificates.py reads it; docs/explanation/certificates.md says what stands in it.
///
/// The problem is written as the contact problem, or the bare LCP, that the proof is about: a scene is not. Vectors
/// that the certificate does not have are null.
/// @pre the certificate is not open.
std::string proof_document(const Problem& problem, const Certificate& certificate);

/// Bytes that inflate() makes the text of again, in the format of zlib (RFC 1950).
std::string deflate(std::string_view text);

/// @throws InputError when the bytes are not what deflate() gives.
std::string inflate(std::string_view bytes);

/// The entries of an exact vector as fractions in lowest terms: "-17/3", "2".
std::vector<std::string> fractions(const ExactVector& vector);

}  // namespace lcpbench
