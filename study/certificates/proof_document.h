#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/problem.h"
#include "study/certify/certificate.h"

namespace lcpbench {

/// A problem and its proof, as one line of JSON without the newline: complete, so that others can check the proof
/// without lcpbench. study/check_certificates.py does; docs/explanation/certificates.md describes the members.
///
/// A scene is written as the contact problem that the proof is about. Members that the certificate does not have are
/// null.
/// @pre the certificate is not open.
std::string proof_document(const Problem& problem, const Certificate& certificate);

/// The text compressed in the format of zlib (RFC 1950).
std::string deflate(std::string_view text);

/// The inverse of deflate(). @throws InputError unless the bytes are one complete zlib stream
std::string inflate(std::string_view bytes);

/// The entries of an exact vector as fractions in lowest terms: "-17/3", "2".
std::vector<std::string> fractions(const ExactVector& vector);

}  // namespace lcpbench
