#include "adapters/worker/problem_fields.h"

#include <algorithm>
#include <concepts>
#include <numeric>
#include <utility>

namespace lcpbench::worker {

/// A structure that is written or, where it is not const, read.
template <class Found, class Structure>
concept Is = std::same_as<std::remove_const_t<Found>, Structure>;

void fields(auto& io, Is<Lcp> auto& lcp) {
  io(lcp.q, "q");
  io(lcp.M, "M");
}

void fields(auto& io, Is<DenseInertia> auto& inertia) { io(inertia.G, "G"); }
void fields(auto& io, Is<BlockInertia> auto& inertia) { io(inertia.blocks, "G blocks"); }
void fields(auto& io, Is<FactoredInertia> auto& inertia) {
  io(inertia.alpha, "alpha");
  io(inertia.X, "X");
}
void fields(auto& io, Is<InverseInertia> auto& inertia) { io(inertia.Ginv, "Ginv"); }

void fields(auto& io, Is<ContactProblem> auto& contact) {
  io(contact.v, "v");
  io(contact.mu, "mu");
  io(contact.edges, "edges");
  io(contact.N, "N");
  io(contact.D, "D");
  io(contact.inertia, "inertia");
  io(contact.b, "b");
  io(contact.compliance_n, "compliance_n");
  io(contact.compliance_t, "compliance_t");
  io(contact.offset_t, "offset_t");
}

void fields(auto& io, Is<MatrixFormation> auto& formation) {
  io(formation.plain_inverse, "formation");
  io(formation.cone_diagonal, "formation");
}

void fields(auto& io, Is<RigidBody> auto& body) {
  io(body.mass, "bodies");
  io(body.inertia, "bodies");
  io(body.position, "bodies");
  io(body.linear_velocity, "bodies");
  io(body.angular_velocity, "bodies");
}

void fields(auto& io, Is<RigidContact> auto& contact) {
  io(contact.body_a, "contacts");
  io(contact.body_b, "contacts");
  io(contact.edges, "contacts");
  io(contact.mu, "contacts");
  io(contact.b, "contacts");
  io(contact.compliance_n, "contacts");
  io(contact.compliance_t, "contacts");
  io(contact.offset_t, "contacts");
  io(contact.point, "contacts");
  io(contact.normal, "contacts");
  io(contact.tangent, "contacts");
}

void fields(auto& io, Is<RigidScene> auto& scene) {
  io(scene.bodies, "bodies");
  io(scene.contacts, "contacts");
}

namespace {

bool is_column_compressed(const Eigen::VectorXi& outer, const Eigen::VectorXi& inner, Index rows) {
  if (outer(0) != 0 || outer(outer.size() - 1) != inner.size()) return false;
  if (!std::is_sorted(outer.begin(), outer.end())) return false;
  for (Index column = 0; column + 1 < outer.size(); ++column) {
    for (int k = outer(column); k < outer(column + 1); ++k) {
      const int before = k > outer(column) ? inner(k - 1) : -1;
      if (inner(k) <= before || inner(k) >= rows) return false;
    }
  }
  return true;
}

void require_shape(const char* field, Index found_rows, Index found_cols, Index rows, Index cols) {
  if (found_rows == rows && found_cols == cols) return;
  throw BadMessage(std::string(field) + ": " + std::to_string(found_rows) + " x " + std::to_string(found_cols) +
                   ", expected " + std::to_string(rows) + " x " + std::to_string(cols));
}

void check_inertia(const Inertia& inertia, Index ngc) {
  if (const auto* blocks = std::get_if<BlockInertia>(&inertia)) {
    Index rows = 0;
    for (const Matrix& block : blocks->blocks) {
      require_shape("G block", block.rows(), block.cols(), block.rows(), block.rows());
      rows += block.rows();
    }
    require(rows == ngc, "G blocks: do not add up to ngc rows");
  } else if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    require_shape("X", factors->X.rows(), factors->X.cols(), ngc, factors->alpha.size());
  } else {
    const auto* dense = std::get_if<DenseInertia>(&inertia);
    const Matrix& matrix = dense != nullptr ? dense->G : std::get<InverseInertia>(inertia).Ginv;
    require_shape(dense != nullptr ? "G" : "Ginv", matrix.rows(), matrix.cols(), ngc, ngc);
  }
}

void check_contact(const ContactProblem& contact) {
  const auto wrong = [](int edges) { return edges < 0 || edges % 2 != 0; };
  require(std::none_of(contact.edges.begin(), contact.edges.end(), wrong), "edges: an entry is odd or negative");
  require(contact.mu.size() == contact.nc(), "mu: not one entry per contact");
  const auto per_contact = [&](const Vector& values, Index each, const char* field) {
    require(values.size() == 0 || values.size() == each * contact.nc(), field, "not so many entries for each contact");
  };
  per_contact(contact.b, 1, "b");
  per_contact(contact.compliance_n, 1, "compliance_n");
  per_contact(contact.compliance_t, 1, "compliance_t");
  per_contact(contact.offset_t, 2, "offset_t");
  const Index friction = std::accumulate(contact.edges.begin(), contact.edges.end(), Index{0});
  require_shape("N", rows(contact.N), cols(contact.N), contact.ngc(), contact.nc());
  require_shape("D", rows(contact.D), cols(contact.D), contact.ngc(), friction);
  check_inertia(contact.inertia, contact.ngc());
}

void check_scene(const RigidScene& scene) {
  const auto bodies = static_cast<int>(scene.bodies.size());
  for (const RigidContact& contact : scene.contacts) {
    for (const int body : {contact.body_a, contact.body_b}) {
      require(body >= RigidContact::kWorld && body < bodies, "contacts: no such body");
    }
    require(contact.edges == 0 || contact.edges == 4, "contacts: edges is neither 0 nor 4");
  }
}

template <class Structure>
Structure read_fields(MessageReader& reader) {
  Structure structure;
  reader(structure, "");
  return structure;
}

}  // namespace

void MessageReader::operator()(SparseMatrix& value, const char* field) {
  Index rows = 0;
  Index cols = 0;
  Eigen::VectorXi outer;
  Eigen::VectorXi inner;
  Vector values;
  (*this)(rows, field);
  (*this)(cols, field);
  (*this)(outer, field);
  (*this)(inner, field);
  (*this)(values, field);
  require(rows >= 0 && cols >= 0 && outer.size() == cols + 1 && inner.size() == values.size() &&
              is_column_compressed(outer, inner, rows),
          field, "not a column-compressed matrix");
  value.resize(rows, cols);
  value.resizeNonZeros(inner.size());
  std::copy(outer.begin(), outer.end(), value.outerIndexPtr());
  std::copy(inner.begin(), inner.end(), value.innerIndexPtr());
  std::copy(values.begin(), values.end(), value.valuePtr());
}

void write_problem(const Problem& problem, MessageWriter& writer) {
  writer(problem.name(), "problem name");
  writer(static_cast<int>(problem.kind()), "kind");
  switch (problem.kind()) {
    case ProblemKind::kLcp: return writer(problem.lcp(), "");
    case ProblemKind::kContact: writer(*problem.contact(), ""); return writer(problem.formation(), "");
    case ProblemKind::kScene: return writer(*problem.scene(), "");
  }
}

Problem read_problem(MessageReader& reader) {
  std::string name;
  int kind = 0;
  reader(name, "problem name");
  reader(kind, "kind");
  switch (kind) {
    case static_cast<int>(ProblemKind::kLcp): {
      auto lcp = read_fields<Lcp>(reader);
      require_shape("M", lcp.M.rows(), lcp.M.cols(), lcp.size(), lcp.size());
      return {std::move(name), std::move(lcp)};
    }
    case static_cast<int>(ProblemKind::kContact): {
      auto contact = read_fields<ContactProblem>(reader);
      const auto formation = read_fields<MatrixFormation>(reader);
      check_contact(contact);
      require(formation.cone_diagonal >= 0 && formation.cone_diagonal <= 1, "formation: diagonal not in [0, 1]");
      return {std::move(name), std::move(contact), formation};
    }
    case static_cast<int>(ProblemKind::kScene): {
      auto scene = read_fields<RigidScene>(reader);
      check_scene(scene);
      return {std::move(name), std::move(scene)};
    }
    default: throw BadMessage("unknown kind of problem");
  }
}

}  // namespace lcpbench::worker
