// Prints one hash for each problem set under each reading: over every bit of its first trials. With a file as argument
// it compares instead, and fails on any difference. Built from the generators' sources by several compilers at several
// levels of optimisation: the problems must not depend on either.

#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/generators/golden_cases.h"

namespace lcpbench::golden {
namespace {

void add(const std::vector<double>& values, Hash& hash) {
  hash.add_size(values.size());
  for (const double value : values) hash.add(value);
}

void add(const ColumnMajor<double>& values, Hash& hash) {
  hash.add_size(values.rows);
  hash.add_size(values.cols);
  for (const double value : values.data) hash.add(value);
}

void add(const Triple& values, Hash& hash) {
  for (const double value : values) hash.add(value);
}

void add(const PaperSample& sample, Hash& hash) {
  add(sample.v, hash);
  add(sample.N, hash);
  add(sample.D, hash);
  hash.add_size(sample.edges.size());
  for (const int edges : sample.edges) hash.add_size(static_cast<std::size_t>(edges));
  add(sample.mu, hash);
  hash.add_size(static_cast<std::size_t>(sample.form));
  if (sample.form == InertiaForm::kFactored) {
    add(sample.X, hash);
    add(sample.alpha, hash);
  } else {
    add(sample.G, hash);
  }
}

// One column of the contact problem: a push along `direction` at the contact's point.
void add_column(const RigidSample& sample, const RigidContactSample& contact, const Triple& direction, double factor,
                ColumnMajor<double>& columns, std::size_t column) {
  for (std::size_t b = 0; b < sample.bodies.size(); ++b) {
    const int body = static_cast<int>(b);
    const double sign = factor * ((contact.body_a == body ? 1 : 0) - (contact.body_b == body ? 1 : 0));
    Triple arm;
    for (std::size_t i = 0; i < 3; ++i) arm[i] = contact.point[i] - sample.bodies[b].position[i];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const std::size_t k = (i + 2) % 3;
      // + 0.0: no negative zeros
      columns(6 * b + i, column) = sign * direction[i] + 0.0;
      columns(6 * b + 3 + i, column) = sign * (arm[j] * direction[k] - arm[k] * direction[j]) + 0.0;
    }
  }
}

// With more edges than a scene has the problem is a contact problem: its numbers are hashed, not the scene's.
void add_contact_problem(const RigidSample& sample, Hash& hash) {
  const std::size_t ngc = 6 * sample.bodies.size();
  const std::size_t nc = sample.contacts.size();
  const auto edges = static_cast<std::size_t>(sample.edges);
  std::vector<double> v;
  for (const RigidBodySample& body : sample.bodies) {
    v.insert(v.end(), body.linear_velocity.begin(), body.linear_velocity.end());
    v.insert(v.end(), body.angular_velocity.begin(), body.angular_velocity.end());
  }
  ColumnMajor<double> N(ngc, nc);
  ColumnMajor<double> D(ngc, nc * edges);
  std::vector<double> mu;
  for (std::size_t c = 0; c < nc; ++c) {
    const RigidContactSample& contact = sample.contacts[c];
    add_column(sample, contact, contact.normal, 1, N, c);
    const std::vector<Triple> directions = friction_directions(contact, static_cast<PyramidEdges>(sample.edges));
    for (std::size_t t = 0; t < directions.size(); ++t) {
      add_column(sample, contact, directions[t], 1, D, c * edges + t);
      add_column(sample, contact, directions[t], -1, D, c * edges + directions.size() + t);
    }
    mu.push_back(contact.mu);
  }
  add(v, hash);
  add(N, hash);
  add(D, hash);
  hash.add_size(nc);
  for (std::size_t c = 0; c < nc; ++c) hash.add_size(edges);
  add(mu, hash);
  hash.add_size(3);
  for (const RigidBodySample& body : sample.bodies) {
    ColumnMajor<double> mass(3, 3);
    for (std::size_t i = 0; i < 3; ++i) mass(i, i) = body.mass;
    add(mass, hash);
    add(body.inertia, hash);
  }
}

void add(const RigidSample& sample, Hash& hash) {
  if (sample.edges > 4) return add_contact_problem(sample, hash);
  hash.add_size(sample.bodies.size());
  for (const RigidBodySample& body : sample.bodies) {
    hash.add(body.mass);
    add(body.inertia, hash);
    add(body.position, hash);
    add(body.linear_velocity, hash);
    add(body.angular_velocity, hash);
  }
  hash.add_size(sample.contacts.size());
  for (const RigidContactSample& contact : sample.contacts) {
    hash.add_size(static_cast<std::size_t>(contact.body_a));
    hash.add_size(static_cast<std::size_t>(contact.body_b + 1));
    add(contact.point, hash);
    add(contact.normal, hash);
    if (sample.edges == 0) continue;
    add(contact.tangent, hash);
    hash.add(contact.mu);
  }
}

void add(const PlantedSample& sample, PlantedForm form, Hash& hash) {
  if (form == PlantedForm::kLcp) {
    add(sample.M, hash);
    add(sample.q, hash);
    return;
  }
  const std::size_t n = sample.q.size();
  ColumnMajor<double> identity(n, n);
  for (std::size_t i = 0; i < n; ++i) identity(i, i) = 1;
  PaperSample contact;  // the same numbers as a contact problem
  contact.v = sample.q;
  contact.N = identity;
  contact.D = ColumnMajor<double>(n, 0);
  contact.edges.assign(n, 0);
  contact.mu.assign(n, 0.0);
  contact.form = InertiaForm::kInverse;
  contact.G = sample.M;
  add(contact, hash);
}

PaperSample draw(const PaperSet& set, const PaperReading& reading, std::uint64_t trial) {
  return draw_paper(set, reading, kSeed, trial);
}

RigidSample draw(const RigidSet& set, const RigidReading& reading, std::uint64_t trial) {
  return draw_rigid(set, reading, kSeed, trial);
}

void add(const std::vector<MadeSample::Column>& columns, Hash& hash) {
  hash.add_size(columns.size());
  for (const MadeSample::Column& column : columns) {
    hash.add_size(column.size());
    for (const auto& [row, entry] : column) {
      hash.add_size(row);
      hash.add(entry);
    }
  }
}

void add_contacts(const MadeSample& sample, Hash& hash) {
  add(sample.N, hash);
  add(sample.D, hash);
  for (const int edges : sample.edges) hash.add_size(static_cast<std::size_t>(edges));
  add(sample.mu, hash);
  add(sample.b, hash);
}

std::string made_lines() {
  std::string text;
  for (const Case<MadeSet>& one : made_cases()) {
    Hash hash;
    for (std::uint64_t trial = 0; trial < kMadeTrials; ++trial) {
      const MadeSample sample = draw_made(*one.set, one.set->parse(one.set->name, one.options), kSeed, trial);
      add(sample.v, hash);
      for (const ColumnMajor<double>& block : sample.blocks) add(block, hash);
      add_contacts(sample, hash);
    }
    text += hash.text() + " " + one.name() + "\n";
  }
  return text;
}

// Of the inertia the entries that are not zero: a problem may have it whole.
std::string rest_lines() {
  std::string text;
  for (const Case<RestSet>& one : rest_cases()) {
    Hash hash;
    for (std::uint64_t trial = 0; trial < kRestTrials; ++trial) {
      const MadeSample sample = draw_rest(*one.set, one.set->parse(one.set->name, one.options), kSeed, trial);
      add(sample.v, hash);
      for (const ColumnMajor<double>& block : sample.blocks) {
        for (const double entry : block.data) {
          if (entry != 0) hash.add(entry);
        }
      }
      add_contacts(sample, hash);
    }
    text += hash.text() + " " + one.name() + "\n";
  }
  return text;
}

struct PlantedDraw {
  PlantedSample sample;
  PlantedForm form = PlantedForm::kContact;
};

void add(const PlantedDraw& draw, Hash& hash) { add(draw.sample, draw.form, hash); }

PlantedDraw draw(const PlantedSet& set, const PlantedReading& reading, std::uint64_t trial) {
  return {draw_planted(set, reading, kSeed, trial), reading.form};
}

void add(const HardCase& problem, Hash& hash) {
  if (problem.contact) return add(*problem.contact, hash);
  add(problem.M, hash);
  add(problem.q, hash);
}

std::string hard_lines() {
  std::string text;
  for (const Case<HardSet>& one : cases(hard_sets())) {
    Hash hash;
    add(one.set->make(one.set->name, one.options), hash);
    text += hash.text() + " " + one.name() + "\n";
  }
  return text;
}

template <class Set>
std::string lines(const std::vector<Set>& sets) {
  std::string text;
  for (const Case<Set>& one : cases(sets)) {
    const auto reading = one.set->parse(one.set->name, one.options);
    Hash hash;
    for (std::uint64_t trial = 0; trial < kTrials; ++trial) add(draw(*one.set, reading, trial), hash);
    text += hash.text() + " " + one.name() + "\n";
  }
  return text;
}

int compare(const std::string& actual, const std::string& expected) {
  if (actual == expected) return 0;
  std::fprintf(stderr, "the problems have changed; expected:\n%s\nfound:\n%s", expected.c_str(), actual.c_str());
  return 1;
}

int run(int argc, char** argv) {
  const std::string actual = lines(paper_sets()) + lines(rigid_sets()) + lines(planted_sets()) + hard_lines() +
                             made_lines() + rest_lines();
  if (argc < 2) return std::fputs(actual.c_str(), stdout) < 0 ? 1 : 0;
  std::ifstream file(argv[1]);
  if (!file) {
    std::fprintf(stderr, "%s: cannot be read\n", argv[1]);
    return 2;
  }
  return compare(actual, std::string(std::istreambuf_iterator<char>(file), {}));
}

}  // namespace
}  // namespace lcpbench::golden

int main(int argc, char** argv) {
  try {
    return lcpbench::golden::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
