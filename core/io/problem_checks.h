#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/contact_problem.h"
#include "core/error.h"
#include "core/lcp.h"
#include "core/scene.h"

namespace lcpbench {

/// Largest problem file that is read [bytes]: 2 GiB.
inline constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 31;

/// Most numbers (and matrix rows) that one problem may hold, 2^26: a dense M of order 8191, 512 MiB of doubles.
inline constexpr std::size_t kMaxNumbers = std::size_t{1} << 26;

/// Largest order of a dense LCP within kMaxNumbers.
inline constexpr Index kMaxDenseOrder = 8191;

/// Longest name of a problem [bytes of UTF-8].
inline constexpr std::size_t kMaxNameBytes = 1000;

/// An InputError "origin: message".
InputError input_error(std::string_view origin, std::string_view message);

/// `text` in single quotes, shortened to 60 bytes: for words of a file that an error repeats.
std::string in_quotes(std::string_view text);

/// "mu[3]": the entry of a field as errors name it.
std::string entry_name(std::string_view field, std::size_t i);

/// "1 row", "3 rows"; "1 entry", "3 entries".
std::string count_of(Index count, const std::string& singular);

// Each check throws an InputError that names `origin` (the file), the field and the cause. Rows, columns, entries,
// contacts and bodies are counted from 0, as JSON arrays are.

/// Not empty, at most kMaxNameBytes of well-formed UTF-8, no control characters.
void check_name(std::string_view name, const std::string& origin);

/// The name of a problem whose format carries none: the file's name without folder and the extensions .M.mtx, .q.mtx,
/// .dat, .txt; shortened, and with '?' for what check_name would refuse.
std::string problem_name_of_file(const std::string& file);

/// M square of q's size; every number finite but bounds that are none; lower <= upper; friction of another row, which
/// has a lower bound >= 0; mu >= 0.
void check_lcp(const Lcp& lcp, const std::string& origin);

/// Sizes agree; every number finite; edges even and >= 0; mu and compliances >= 0; no mu, compliance_t or offset_t
/// without edges; the columns of D in exact +- pairs; bounds of rows as in check_lcp(), with lower <= 0 <= upper and
/// not both 0; G exactly symmetric and positive definite (Cholesky); Ginv exactly symmetric and positive semidefinite
/// (to rounding); alpha > 0. O(ngc^3).
void check_contact(const ContactProblem& problem, const std::string& origin);

/// Masses > 0; inertias exactly symmetric and positive definite; existing, distinct bodies; unit normals and, where
/// edges is 4, unit tangents orthogonal to them (to 1e-6: directions are taken as they are, and six digits are what
/// single-precision engines keep); mu and compliances as in check_contact(); finite lever arms. O(bodies + contacts).
void check_scene(const RigidScene& scene, const std::string& origin);

}  // namespace lcpbench
