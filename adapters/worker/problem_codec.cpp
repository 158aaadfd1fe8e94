#include "adapters/worker/problem_codec.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace lcpbench::worker {
namespace {

constexpr std::size_t kMaxNameBytes = 65536;

enum class MatrixStorage : std::uint64_t { kDense = 0, kSparse = 1 };

void write_sparse(const SparseMatrix& J, ByteWriter& writer) {
  if (!J.isCompressed()) {
    SparseMatrix compressed = J;
    compressed.makeCompressed();
    return write_sparse(compressed, writer);
  }
  const auto nonzeros = static_cast<std::size_t>(J.nonZeros());
  writer.integer(J.rows());
  writer.integer(J.cols());
  writer.word(nonzeros);
  writer.elements(J.outerIndexPtr(), static_cast<std::size_t>(J.cols()) + 1);
  writer.elements(J.innerIndexPtr(), nonzeros);
  writer.elements(J.valuePtr(), nonzeros);
}

void write_jacobian(const Jacobian& J, ByteWriter& writer) {
  if (const auto* dense = std::get_if<Matrix>(&J)) {
    writer.word(static_cast<std::uint64_t>(MatrixStorage::kDense));
    writer.matrix(*dense);
  } else {
    writer.word(static_cast<std::uint64_t>(MatrixStorage::kSparse));
    write_sparse(std::get<SparseMatrix>(J), writer);
  }
}

bool is_column_compressed(const std::vector<int>& outer, const std::vector<int>& inner, Index rows) {
  if (outer.front() != 0 || outer.back() != static_cast<int>(inner.size())) return false;
  if (!std::is_sorted(outer.begin(), outer.end())) return false;
  for (std::size_t column = 0; column + 1 < outer.size(); ++column) {
    for (int k = outer[column]; k < outer[column + 1]; ++k) {
      const int row = inner[static_cast<std::size_t>(k)];
      if (row < 0 || row >= rows) return false;
      if (k > outer[column] && row <= inner[static_cast<std::size_t>(k) - 1]) return false;
    }
  }
  return true;
}

SparseMatrix read_sparse(Index rows, Index cols, ByteReader& reader, const char* field) {
  reader.require_shape(rows, cols, field);
  const std::size_t nonzeros = reader.count(sizeof(int) + sizeof(double), field);
  reader.require(nonzeros <= static_cast<std::size_t>(std::numeric_limits<int>::max()) &&
                     static_cast<std::size_t>(cols) < reader.remaining() / sizeof(int),
                 std::string(field) + ": more entries than the message holds");
  if (!reader.ok()) return {};
  std::vector<int> outer(static_cast<std::size_t>(cols) + 1);
  std::vector<int> inner(nonzeros);
  std::vector<double> values(nonzeros);
  reader.elements(outer.data(), outer.size());
  reader.elements(inner.data(), inner.size());
  reader.elements(values.data(), values.size());
  reader.require(reader.ok() && is_column_compressed(outer, inner, rows),
                 std::string(field) + ": not a column-compressed matrix");
  if (!reader.ok()) return {};
  return Eigen::Map<const SparseMatrix>(rows, cols, static_cast<Index>(nonzeros), outer.data(), inner.data(),
                                        values.data());
}

Jacobian read_jacobian(Index rows, Index cols, ByteReader& reader, const char* field) {
  switch (static_cast<MatrixStorage>(reader.word())) {
    case MatrixStorage::kDense: return reader.matrix(rows, cols, field);
    case MatrixStorage::kSparse: return read_sparse(rows, cols, reader, field);
  }
  reader.fail(std::string(field) + ": neither dense nor sparse");
  return {};
}

void write_inertia(const Inertia& inertia, ByteWriter& writer) {
  writer.word(inertia.index());
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    writer.matrix(dense->G);
  } else if (const auto* blocks = std::get_if<BlockInertia>(&inertia)) {
    writer.word(blocks->blocks.size());
    for (const Matrix& block : blocks->blocks) {
      writer.integer(block.rows());
      writer.matrix(block);
    }
  } else if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    writer.vector(factors->alpha);
    writer.matrix(factors->X);
  } else {
    writer.matrix(std::get<InverseInertia>(inertia).Ginv);
  }
}

BlockInertia read_blocks(Index ngc, ByteReader& reader) {
  BlockInertia inertia;
  constexpr std::size_t kSmallestBlock = 3 * sizeof(std::int64_t);
  const std::size_t count = reader.count(kSmallestBlock, "G blocks");
  Index left = ngc;
  for (std::size_t b = 0; b < count && reader.ok(); ++b) {
    const std::int64_t rows = reader.integer();
    reader.require(rows >= 0 && rows <= left, "G blocks: do not add up to ngc rows");
    if (!reader.ok()) break;
    inertia.blocks.push_back(reader.matrix(rows, rows, "G block"));
    left -= rows;
  }
  reader.require(left == 0, "G blocks: do not add up to ngc rows");
  return inertia;
}

Inertia read_inertia(Index ngc, ByteReader& reader) {
  switch (reader.word()) {
    case 0: return DenseInertia{reader.matrix(ngc, ngc, "G")};
    case 1: return read_blocks(ngc, reader);
    case 2: {
      FactoredInertia factors;
      factors.alpha = reader.vector("alpha");
      factors.X = reader.matrix(ngc, factors.alpha.size(), "X");
      return factors;
    }
    case 3: return InverseInertia{reader.matrix(ngc, ngc, "Ginv")};
    default: reader.fail("inertia: unknown kind"); return {};
  }
}

void write_contact(const ContactProblem& contact, ByteWriter& writer) {
  writer.vector(contact.v);
  writer.vector(contact.mu);
  writer.word(contact.edges.size());
  writer.elements(contact.edges.data(), contact.edges.size());
  write_jacobian(contact.N, writer);
  write_jacobian(contact.D, writer);
  write_inertia(contact.inertia, writer);
  for (const auto* values : {&contact.b, &contact.compliance_n, &contact.compliance_t, &contact.offset_t}) {
    writer.vector(*values);
  }
}

ContactProblem read_contact(ByteReader& reader) {
  ContactProblem contact;
  contact.v = reader.vector("v");
  contact.mu = reader.vector("mu");
  contact.edges.resize(reader.count(sizeof(int), "edges"));
  reader.elements(contact.edges.data(), contact.edges.size());
  reader.require(contact.mu.size() == contact.nc(), "mu: not one entry per contact");
  Index friction = 0;
  for (const int edges : contact.edges) {
    reader.require(edges >= 0 && edges % 2 == 0, "edges: an entry is odd or negative");
    friction += edges;
  }
  if (!reader.ok()) return {};
  contact.N = read_jacobian(contact.ngc(), contact.nc(), reader, "N");
  contact.D = read_jacobian(contact.ngc(), friction, reader, "D");
  contact.inertia = read_inertia(contact.ngc(), reader);
  contact.b = reader.vector("b");
  reader.require(contact.b.size() == 0 || contact.b.size() == contact.nc(), "b: not one entry per contact");
  contact.compliance_n = reader.vector("compliance_n");
  contact.compliance_t = reader.vector("compliance_t");
  contact.offset_t = reader.vector("offset_t");
  for (const auto* values : {&contact.compliance_n, &contact.compliance_t}) {
    reader.require(values->size() == 0 || values->size() == contact.nc(), "compliance: not one entry per contact");
  }
  reader.require(contact.offset_t.size() == 0 || contact.offset_t.size() == 2 * contact.nc(),
                 "offset_t: not two entries per contact");
  return contact;
}

constexpr std::size_t kBodyBytes = 19 * sizeof(double);
constexpr std::size_t kContactBytes = 3 * sizeof(std::int64_t) + 15 * sizeof(double);

void write_scene(const RigidScene& scene, ByteWriter& writer) {
  writer.word(scene.bodies.size());
  for (const RigidBody& body : scene.bodies) {
    writer.real(body.mass);
    writer.elements(body.inertia.data(), 9);
    for (const auto* field : {&body.position, &body.linear_velocity, &body.angular_velocity}) {
      writer.elements(field->data(), 3);
    }
  }
  writer.word(scene.contacts.size());
  for (const RigidContact& contact : scene.contacts) {
    for (const int field : {contact.body_a, contact.body_b, contact.edges}) writer.integer(field);
    writer.real(contact.mu);
    for (const double value : {contact.b, contact.compliance_n, contact.compliance_t}) writer.real(value);
    writer.elements(contact.offset_t.data(), 2);
    for (const auto* field : {&contact.point, &contact.normal, &contact.tangent}) writer.elements(field->data(), 3);
  }
}

RigidScene read_scene(ByteReader& reader) {
  RigidScene scene;
  scene.bodies.resize(reader.count(kBodyBytes, "bodies"));
  for (RigidBody& body : scene.bodies) {
    body.mass = reader.real();
    reader.elements(body.inertia.data(), 9);
    for (auto* field : {&body.position, &body.linear_velocity, &body.angular_velocity}) {
      reader.elements(field->data(), 3);
    }
  }
  scene.contacts.resize(reader.count(kContactBytes, "contacts"));
  const auto bodies = static_cast<std::int64_t>(scene.bodies.size());
  for (RigidContact& contact : scene.contacts) {
    for (int* field : {&contact.body_a, &contact.body_b}) {
      const std::int64_t body = reader.integer();
      reader.require(body >= RigidContact::kWorld && body < bodies, "contacts: no such body");
      *field = reader.ok() ? static_cast<int>(body) : 0;
    }
    const std::int64_t edges = reader.integer();
    reader.require(edges == 0 || edges == 4, "contacts: edges is neither 0 nor 4");
    contact.edges = edges == 4 ? 4 : 0;
    contact.mu = reader.real();
    for (double* value : {&contact.b, &contact.compliance_n, &contact.compliance_t}) *value = reader.real();
    reader.elements(contact.offset_t.data(), 2);
    for (auto* field : {&contact.point, &contact.normal, &contact.tangent}) reader.elements(field->data(), 3);
  }
  return reader.ok() ? scene : RigidScene{};
}

}  // namespace

void write_problem(const Problem& problem, ByteWriter& writer) {
  writer.text(problem.name());
  writer.word(static_cast<std::uint64_t>(problem.kind()));
  switch (problem.kind()) {
    case ProblemKind::kLcp:
      writer.vector(problem.lcp().q);
      writer.matrix(problem.lcp().M);
      break;
    case ProblemKind::kContact:
      write_contact(*problem.contact(), writer);
      writer.word(problem.formation().plain_inverse ? 1 : 0);
      writer.real(problem.formation().cone_diagonal);
      break;
    case ProblemKind::kScene: write_scene(*problem.scene(), writer); break;
  }
}

Problem read_problem(ByteReader& reader) {
  std::string name = reader.text(kMaxNameBytes, "problem name");
  const std::uint64_t kind = reader.word();
  reader.require(kind <= static_cast<std::uint64_t>(ProblemKind::kScene), "unknown kind of problem");
  if (!reader.ok()) return {};
  switch (static_cast<ProblemKind>(kind)) {
    case ProblemKind::kLcp: {
      Lcp lcp;
      lcp.q = reader.vector("q");
      lcp.M = reader.matrix(lcp.size(), lcp.size(), "M");
      return {std::move(name), std::move(lcp)};
    }
    case ProblemKind::kContact: {
      ContactProblem contact = read_contact(reader);
      MatrixFormation formation;
      const std::uint64_t plain_inverse = reader.word();
      reader.require(plain_inverse <= 1, "formation: neither 0 nor 1");
      formation.plain_inverse = plain_inverse == 1;
      formation.cone_diagonal = reader.real();
      reader.require(formation.cone_diagonal >= 0 && formation.cone_diagonal <= 1, "formation: diagonal not in [0, 1]");
      return {std::move(name), std::move(contact), formation};
    }
    case ProblemKind::kScene: return {std::move(name), read_scene(reader)};
  }
  return {};
}

}  // namespace lcpbench::worker
