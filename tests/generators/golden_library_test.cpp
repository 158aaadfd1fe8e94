// The library's problems, as a study sees them, are those of the committed hashes: neither the way into Eigen's types
// nor the library's own build options change a bit.

#include <fstream>
#include <map>

#include <gtest/gtest.h>

#include "generators/sets.h"
#include "tests/generators/golden_cases.h"

namespace lcpbench::golden::golden_library_test {
namespace {

template <class Array>
void add_entries(const Array& values, Hash& hash) {
  for (Index i = 0; i < values.size(); ++i) hash.add(values.data()[i]);
}

void add(const Vector& values, Hash& hash) {
  hash.add_size(static_cast<std::size_t>(values.size()));
  add_entries(values, hash);
}

void add(const Matrix& values, Hash& hash) {
  hash.add_size(static_cast<std::size_t>(values.rows()));
  hash.add_size(static_cast<std::size_t>(values.cols()));
  add_entries(values, hash);
}

void add(const ContactProblem& problem, Hash& hash) {
  add(problem.v, hash);
  add(to_dense(problem.N), hash);
  add(to_dense(problem.D), hash);
  hash.add_size(problem.edges.size());
  for (const int edges : problem.edges) hash.add_size(static_cast<std::size_t>(edges));
  add(problem.mu, hash);
  if (const auto* dense = std::get_if<DenseInertia>(&problem.inertia)) {
    hash.add_size(0);
    add(dense->G, hash);
  } else if (const auto* factors = std::get_if<FactoredInertia>(&problem.inertia)) {
    hash.add_size(1);
    add(factors->X, hash);
    add(factors->alpha, hash);
  } else if (const auto* bodies = std::get_if<BlockInertia>(&problem.inertia)) {
    hash.add_size(3);
    for (const Matrix& block : bodies->blocks) add(block, hash);
  } else {
    hash.add_size(2);
    add(std::get<InverseInertia>(problem.inertia).Ginv, hash);
  }
}

void add(const SparseMatrix& values, Hash& hash) {
  hash.add_size(static_cast<std::size_t>(values.cols()));
  for (Index j = 0; j < values.cols(); ++j) {
    hash.add_size(static_cast<std::size_t>(values.col(j).nonZeros()));
    for (SparseMatrix::InnerIterator entry(values, j); entry; ++entry) {
      hash.add_size(static_cast<std::size_t>(entry.row()));
      hash.add(entry.value());
    }
  }
}

SparseMatrix to_sparse(const Jacobian& J) {
  if (const auto* sparse = std::get_if<SparseMatrix>(&J)) return *sparse;
  return std::get<Matrix>(J).sparseView();
}

void add_inertia(const ContactProblem& problem, bool is_made, Hash& hash) {
  if (!is_made) {
    const Matrix G = dense_inertia(problem.inertia);
    for (Index k = 0; k < G.size(); ++k) {
      if (G.data()[k] != 0) hash.add(G.data()[k]);
    }
    return;
  }
  for (const Matrix& block : std::get<BlockInertia>(problem.inertia).blocks) add(block, hash);
}

void add_made_or_rest(const ContactProblem& problem, bool is_made, Hash& hash) {
  add(problem.v, hash);
  add_inertia(problem, is_made, hash);
  add(to_sparse(problem.N), hash);
  add(to_sparse(problem.D), hash);
  for (const int edges : problem.edges) hash.add_size(static_cast<std::size_t>(edges));
  add(problem.mu, hash);
  add(problem.has_offset() ? problem.b : Vector(Vector::Zero(problem.nc())), hash);
}

bool is_made(const std::string& name) { return name.starts_with("made/"); }
bool is_rest(const std::string& name) { return name.starts_with("rest/"); }

void add(const RigidScene& scene, Hash& hash) {
  hash.add_size(scene.bodies.size());
  for (const RigidBody& body : scene.bodies) {
    hash.add(body.mass);
    add(Matrix(body.inertia), hash);
    add_entries(body.position, hash);
    add_entries(body.linear_velocity, hash);
    add_entries(body.angular_velocity, hash);
  }
  hash.add_size(scene.contacts.size());
  for (const RigidContact& contact : scene.contacts) {
    hash.add_size(static_cast<std::size_t>(contact.body_a));
    hash.add_size(static_cast<std::size_t>(contact.body_b + 1));
    add_entries(contact.point, hash);
    add_entries(contact.normal, hash);
    if (contact.edges == 0) continue;
    add_entries(contact.tangent, hash);
    hash.add(contact.mu);
  }
}

void add(const Lcp& lcp, Hash& hash) {
  add(lcp.M, hash);
  add(lcp.q, hash);
}

std::map<std::string, std::string> committed_hashes() {
  std::ifstream file(GOLDEN_HASHES);
  std::map<std::string, std::string> hashes;
  std::string hash;
  std::string name;
  while (file >> hash >> name) hashes[name] = hash;
  return hashes;
}

TEST(GoldenHashesTest, TheLibraryGivesThemToo) {
  const std::map<std::string, std::string> hashes = committed_hashes();
  ASSERT_GE(hashes.size(), cases(paper_sets()).size() + cases(rigid_sets()).size() + cases(planted_sets()).size() +
                               cases(hard_sets()).size() + made_cases().size() + rest_cases().size());
  for (const auto& [name, expected] : hashes) {
    const std::unique_ptr<ProblemSet> set = open_set(name);
    EXPECT_EQ(set->name(), name);
    Hash hash;
    const std::uint64_t drawn = is_made(name) ? kMadeTrials : is_rest(name) ? kRestTrials : kTrials;
    const std::int64_t trials = set->count().value_or(static_cast<std::int64_t>(drawn));
    for (std::int64_t trial = 0; trial < trials; ++trial) {
      const Problem problem = set->generate(kSeed, trial);
      if (problem.scene() != nullptr) {
        add(*problem.scene(), hash);
      } else if (is_made(name) || is_rest(name)) {
        add_made_or_rest(*problem.contact(), is_made(name), hash);
      } else if (problem.contact() != nullptr) {
        add(*problem.contact(), hash);
      } else {
        add(problem.lcp(), hash);
      }
    }
    EXPECT_EQ(hash.text(), expected) << name;
  }
}

TEST(GoldenHashesTest, EverySetHasOne) {
  const std::map<std::string, std::string> hashes = committed_hashes();
  for (const SetInfo& set : list_sets()) {
    if (set.name.starts_with("scene/")) continue;  // committed bits, not drawn ones
    if (set.name == "changed") continue;           // tests/generators/changed_test.cpp has its bits
    const std::string name = is_made(set.name) ? set.name + "{nc_max=150}" : set.name;
    EXPECT_EQ(hashes.count(name), 1u) << set.name;
  }
}

}  // namespace
}  // namespace lcpbench::golden::golden_library_test
