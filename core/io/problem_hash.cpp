#include <array>
#include <bit>
#include <memory>
#include <new>

#include <xxhash.h>

#include "core/io/problem_io.h"

// The input is a stream of 64-bit words, least significant byte first. A problem and its inertia begin with a tag,
// lists and matrices with their sizes, so that no two problems share a stream. Matrices go column by column as
// (row, value) of the entries that are not +0.0: dense and sparse storage of the same numbers hash alike, as do inertia
// blocks and the block diagonal matrix, because a problem file does not tell them apart either. Last come offsets,
// compliances and tangential offsets, each list with a tag and only if one of its values is not zero; its size follows
// from the contacts; then the bounds of a mixed LCP, or the bounded rows of a contact problem, if it has any.

namespace lcpbench {
namespace {

enum class Tag : std::uint64_t {
  kLcp = 1,
  kContact = 2,
  kScene = 3,
  kInertia = 4,
  kFactors = 5,
  kInverse = 6,
  kOffset = 7,
  kNormalCompliance = 8,
  kTangentialCompliance = 9,
  kTangentialOffset = 10,
  kBounds = 11,
  kRows = 12,
};

class WordHash {
 public:
  WordHash() : state_(XXH3_createState(), XXH3_freeState) {
    if (!state_) throw std::bad_alloc();
    XXH3_128bits_reset(state_.get());
  }

  void word(std::uint64_t word) {
    std::array<unsigned char, 8> bytes;
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<unsigned char>(word >> (8 * i));
    XXH3_128bits_update(state_.get(), bytes.data(), bytes.size());
  }
  void tag(Tag tag) { word(static_cast<std::uint64_t>(tag)); }
  void index(Index value) { word(static_cast<std::uint64_t>(value)); }
  void real(double value) { word(std::bit_cast<std::uint64_t>(value)); }

  std::string hexadecimal() const {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state_.get()));
    std::string text;
    for (const unsigned char byte : canonical.digest) {
      text += "0123456789abcdef"[byte >> 4];
      text += "0123456789abcdef"[byte & 15];
    }
    return text;
  }

 private:
  std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state_;
};

void add(WordHash& hash, const Vector& values) {
  hash.index(values.size());
  for (const double value : values) hash.real(value);
}

void add(WordHash& hash, const Eigen::Vector3d& values) {
  for (const double value : values) hash.real(value);
}

/// One entry of a column, unless it is the +0.0 that sparse storage leaves out.
void add_entry(WordHash& hash, Index row, double value) {
  if (std::bit_cast<std::uint64_t>(value) == 0) return;
  hash.index(row);
  hash.real(value);
}

/// Ends a column: no row has this number.
constexpr Index kColumnEnd = -1;

void add_columns(WordHash& hash, const Matrix& matrix, Index first_row) {
  for (Index column = 0; column < matrix.cols(); ++column) {
    for (Index row = 0; row < matrix.rows(); ++row) add_entry(hash, first_row + row, matrix(row, column));
    hash.index(kColumnEnd);
  }
}

void add(WordHash& hash, const Matrix& matrix) {
  hash.index(matrix.rows());
  hash.index(matrix.cols());
  add_columns(hash, matrix, 0);
}

void add(WordHash& hash, const SparseMatrix& matrix) {
  hash.index(matrix.rows());
  hash.index(matrix.cols());
  for (Index column = 0; column < matrix.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator it(matrix, column); it; ++it) add_entry(hash, it.row(), it.value());
    hash.index(kColumnEnd);
  }
}

void add(WordHash& hash, const Inertia& inertia) {
  const auto* factors = std::get_if<FactoredInertia>(&inertia);
  const Tag tag = std::holds_alternative<InverseInertia>(inertia) ? Tag::kInverse : Tag::kInertia;
  hash.tag(factors != nullptr ? Tag::kFactors : tag);
  hash.index(dimension(inertia));
  hash.index(factors != nullptr ? factors->X.cols() : dimension(inertia));
  for_each_matrix(inertia, [&](const Matrix& matrix, Index first) { add_columns(hash, matrix, first); });
  if (factors != nullptr) add(hash, factors->alpha);
}

template <class ValueOf>
void add_optional(WordHash& hash, Tag tag, Index count, ValueOf&& value_of) {
  bool any = false;
  for (Index i = 0; i < count; ++i) any = any || value_of(i) != 0;
  if (!any) return;
  hash.tag(tag);
  for (Index i = 0; i < count; ++i) hash.real(value_of(i) + 0.0);  // a negative zero is zero
}

void add(WordHash& hash, const LcpBounds& bounds) {
  for (Index i = 0; i < bounds.lower.size(); ++i) {
    const int of = bounds.friction_of[static_cast<std::size_t>(i)];
    hash.index(of);
    hash.real((of >= 0 ? bounds.mu(i) : bounds.lower(i)) + 0.0);
    if (of < 0) hash.real(bounds.upper(i) + 0.0);
  }
}

/// Their names are no data.
void add(WordHash& hash, const BoundedRows& rows) {
  hash.tag(Tag::kRows);
  std::visit([&](const auto& matrix) { add(hash, matrix); }, rows.R);
  add(hash, rows.bounds);
  for (const char is_angle : rows.is_angle) hash.index(is_angle != 0 ? 1 : 0);
  add_optional(hash, Tag::kOffset, rows.b.size(), rows.b);
  add_optional(hash, Tag::kNormalCompliance, rows.compliance.size(), rows.compliance);
}

void add(WordHash& hash, const ContactProblem& problem) {
  hash.tag(Tag::kContact);
  add(hash, problem.v);
  std::visit([&](const auto& matrix) { add(hash, matrix); }, problem.N);
  std::visit([&](const auto& matrix) { add(hash, matrix); }, problem.D);
  hash.index(problem.nc());
  for (Index i = 0; i < problem.nc(); ++i) {
    const int edges = problem.edges[static_cast<std::size_t>(i)];
    hash.index(edges);
    if (edges > 0) hash.real(problem.mu(i));  // without friction mu is no data
  }
  add(hash, problem.inertia);
  add_optional(hash, Tag::kOffset, problem.nc(), [&](Index i) { return problem.offset(i); });
  add_optional(hash, Tag::kNormalCompliance, problem.compliance_n.size(), problem.compliance_n);
  add_optional(hash, Tag::kTangentialCompliance, problem.compliance_t.size(), problem.compliance_t);
  add_optional(hash, Tag::kTangentialOffset, problem.offset_t.size(), problem.offset_t);
  if (problem.has_rows()) add(hash, problem.rows);
}

void add(WordHash& hash, const RigidScene& scene) {
  hash.tag(Tag::kScene);
  hash.index(static_cast<Index>(scene.bodies.size()));
  for (const RigidBody& body : scene.bodies) {
    hash.real(body.mass);
    for (const double entry : body.inertia.reshaped()) hash.real(entry);
    add(hash, body.position);
    add(hash, body.linear_velocity);
    add(hash, body.angular_velocity);
  }
  hash.index(static_cast<Index>(scene.contacts.size()));
  for (const RigidContact& contact : scene.contacts) {
    hash.index(contact.body_a);
    hash.index(contact.body_b);
    add(hash, contact.point);
    add(hash, contact.normal);
    hash.index(contact.edges);
    if (contact.edges == 0) continue;  // no friction: tangent and mu are no data
    add(hash, contact.tangent);
    hash.real(contact.mu);
  }
  const auto contact = [&](Index i) -> const RigidContact& { return scene.contacts[static_cast<std::size_t>(i)]; };
  const auto count = static_cast<Index>(scene.contacts.size());
  add_optional(hash, Tag::kOffset, count, [&](Index i) { return contact(i).b; });
  add_optional(hash, Tag::kNormalCompliance, count, [&](Index i) { return contact(i).compliance_n; });
  add_optional(hash, Tag::kTangentialCompliance, count, [&](Index i) { return contact(i).compliance_t; });
  add_optional(hash, Tag::kTangentialOffset, 2 * count, [&](Index i) { return contact(i / 2).offset_t(i % 2); });
}

void add(WordHash& hash, const Lcp& lcp) {
  hash.tag(Tag::kLcp);
  add(hash, lcp.M);
  add(hash, lcp.q);
  if (!lcp.is_mixed()) return;
  hash.tag(Tag::kBounds);
  add(hash, lcp.bounds);
}

}  // namespace

std::string problem_hash(const Problem& problem) {
  WordHash hash;
  if (problem.kind() == ProblemKind::kScene) {
    add(hash, *problem.scene());
  } else if (problem.kind() == ProblemKind::kContact) {
    add(hash, *problem.contact());
  } else {
    add(hash, problem.lcp());
  }
  return hash.hexadecimal();
}

}  // namespace lcpbench
