#include "generators/paper/paper.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/error.h"

namespace lcpbench {
namespace {

using GridArray = ColumnMajor<std::int64_t>;

constexpr std::int64_t kLargestCeiling = 200;
constexpr std::int64_t kSmallestRank = 6;
constexpr std::int64_t kLargestMultiple = 5;
constexpr std::int64_t kLargestCoefficient = 2;

double from_grid(std::int64_t steps) { return static_cast<double>(steps) * kGridStep; }

std::vector<double> from_grid(const std::vector<std::int64_t>& steps) {
  std::vector<double> values(steps.size());
  std::transform(steps.begin(), steps.end(), values.begin(), [](std::int64_t k) { return from_grid(k); });
  return values;
}

ColumnMajor<double> from_grid(const GridArray& steps) {
  ColumnMajor<double> values(steps.rows, steps.cols);
  values.data = from_grid(steps.data);
  return values;
}

GridArray signed_array(DrawSequence& draws, std::size_t rows, std::size_t cols) {
  GridArray array(rows, cols);
  for (std::int64_t& entry : array.data) entry = draws.signed_grid();
  return array;
}

struct Dimensions {
  std::size_t ngc = 0;
  std::size_t nc = 0;
  std::size_t redundant = 0;
  std::size_t rank = 0;
};

std::int64_t draw_rank(const TrialKey& key, std::int64_t ngc, RankReading reading) {
  const std::int64_t high = reading == RankReading::kBelowFull ? ngc - 1 : ngc;
  const std::int64_t low = reading == RankReading::kFromOne ? 1 : std::min(kSmallestRank, high);
  return DrawSequence(key, Purpose::kInertiaRank).integer(low, high);
}

Dimensions draw_dimensions(const TrialKey& key, const PaperFeatures& features, const PaperReading& reading) {
  const std::pair coordinates{std::int64_t{6}, reading.ngc_max};
  const std::pair contacts{std::int64_t{2}, reading.nc_max};
  const bool swapped = reading.sizes == SizeReading::kSwapped;
  const auto draw = [&](Purpose purpose, std::pair<std::int64_t, std::int64_t> range) {
    return DrawSequence(key, purpose).integer(range.first, range.second);
  };
  const std::int64_t ngc = draw(Purpose::kCoordinateCount, swapped ? contacts : coordinates);
  const std::int64_t nc = draw(Purpose::kContactCount, swapped ? coordinates : contacts);
  const std::int64_t redundant = features.redundant ? draw(Purpose::kRedundantCount, {0, nc - 1}) : 0;
  const std::int64_t rank = features.reduced ? draw_rank(key, ngc, reading.rank) : ngc;
  return {static_cast<std::size_t>(ngc), static_cast<std::size_t>(nc), static_cast<std::size_t>(redundant),
          static_cast<std::size_t>(rank)};
}

// The contacts in an order whose last `redundant` ones are to depend on the ones before.
std::vector<std::size_t> place_contacts(const TrialKey& key, const Dimensions& sizes, Placement placement) {
  std::vector<std::size_t> order(sizes.nc);
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (placement == Placement::kRandom) {
    DrawSequence draws(key, Purpose::kRedundancyPlaces);
    shuffle(order, draws);
  }
  const auto first_dependent = order.end() - static_cast<std::ptrdiff_t>(sizes.redundant);
  std::sort(order.begin(), first_dependent);
  std::sort(first_dependent, order.end());
  return order;
}

Dependence draw_multiple(std::size_t contact, const std::vector<std::size_t>& independent, DrawSequence& sources,
                         DrawSequence& factors) {
  const auto last = static_cast<std::int64_t>(independent.size()) - 1;
  return {contact,
          {independent[static_cast<std::size_t>(sources.integer(0, last))]},
          {factors.integer(1, kLargestMultiple)}};
}

// A combination that is zero throughout would be a contact without effect; it is drawn again.
Dependence draw_combination(std::size_t contact, const std::vector<std::size_t>& independent, DrawSequence& factors) {
  Dependence dependence{contact, {}, {}};
  while (dependence.sources.empty()) {
    for (const std::size_t source : independent) {
      const std::int64_t factor = factors.integer(-kLargestCoefficient, kLargestCoefficient);
      if (factor == 0) continue;
      dependence.sources.push_back(source);
      dependence.factors.push_back(factor);
    }
  }
  return dependence;
}

std::vector<Dependence> draw_dependences(const TrialKey& key, const Dimensions& sizes, const PaperReading& reading) {
  const std::vector<std::size_t> order = place_contacts(key, sizes, reading.placement);
  const auto first_dependent = order.end() - static_cast<std::ptrdiff_t>(sizes.redundant);
  const std::vector<std::size_t> independent(order.begin(), first_dependent);
  DrawSequence sources(key, Purpose::kRedundancySources);
  DrawSequence factors(key, Purpose::kRedundancyFactors);
  std::vector<Dependence> dependences;
  for (auto contact = first_dependent; contact != order.end(); ++contact) {
    dependences.push_back(reading.redundancy == Redundancy::kMultiple
                              ? draw_multiple(*contact, independent, sources, factors)
                              : draw_combination(*contact, independent, factors));
  }
  return dependences;
}

void replace_column(GridArray& array, std::size_t column, const Dependence& dependence) {
  for (std::size_t row = 0; row < array.rows; ++row) {
    std::int64_t sum = 0;
    for (std::size_t s = 0; s < dependence.sources.size(); ++s) {
      sum += dependence.factors[s] * array(row, dependence.sources[s]);
    }
    array(row, column) = sum;
  }
}

ColumnMajor<double> draw_normals(const TrialKey& key, const Dimensions& sizes,
                                 const std::vector<Dependence>& dependences) {
  DrawSequence draws(key, Purpose::kNormals);
  GridArray N = signed_array(draws, sizes.ngc, sizes.nc);
  for (const Dependence& dependence : dependences) replace_column(N, dependence.contact, dependence);
  return from_grid(N);
}

std::vector<int> draw_edges(const TrialKey& key, const Dimensions& sizes, EdgeReading reading,
                            const std::vector<Dependence>& dependences) {
  DrawSequence draws(key, Purpose::kEdgeCount);
  std::vector<int> edges(sizes.nc, 2 * static_cast<int>(draws.integer(2, 12)));
  if (reading == EdgeReading::kShared) return edges;
  for (std::size_t i = 1; i < sizes.nc; ++i) edges[i] = 2 * static_cast<int>(draws.integer(2, 12));
  // Each column of a dependent contact needs its counterpart in every contact that it depends on.
  for (const Dependence& dependence : dependences) {
    int fewest = edges[dependence.sources.front()];
    for (const std::size_t source : dependence.sources) fewest = std::min(fewest, edges[source]);
    edges[dependence.contact] = fewest;
  }
  return edges;
}

// The first half of a dependent contact's columns, each made of the columns at the same place in its sources.
GridArray combine(const std::vector<GridArray>& halves, const Dependence& dependence, std::size_t half_edges) {
  GridArray half(halves[dependence.sources.front()].rows, half_edges);
  for (std::size_t s = 0; s < dependence.sources.size(); ++s) {
    const GridArray& source = halves[dependence.sources[s]];
    for (std::size_t i = 0; i < half.data.size(); ++i) half.data[i] += dependence.factors[s] * source.data[i];
  }
  return half;
}

ColumnMajor<double> draw_tangents(const TrialKey& key, const Dimensions& sizes, const std::vector<int>& edges,
                                  const std::vector<Dependence>& dependences) {
  DrawSequence draws(key, Purpose::kTangents);
  std::vector<GridArray> halves;
  for (const int count : edges) halves.push_back(signed_array(draws, sizes.ngc, static_cast<std::size_t>(count / 2)));
  for (const Dependence& dependence : dependences) {
    halves[dependence.contact] = combine(halves, dependence, halves[dependence.contact].cols);
  }
  GridArray D(sizes.ngc, 0);
  for (const GridArray& half : halves) {
    D.data.insert(D.data.end(), half.data.begin(), half.data.end());
    std::transform(half.data.begin(), half.data.end(), std::back_inserter(D.data), std::negate<>());
    D.cols += 2 * half.cols;
  }
  return from_grid(D);
}

// Sum of twelve uniform numbers, centred: mean 0, variance 1, nearly normal, and on the grid.
std::int64_t draw_bell(DrawSequence& draws) {
  std::int64_t sum = -6 * (std::int64_t{1} << kGridBits);
  for (int i = 0; i < 12; ++i) sum += draws.unit_grid();
  return sum;
}

double draw_entry(DrawSequence& draws, VectorDistribution distribution) {
  switch (distribution) {
    case VectorDistribution::kPositive: return from_grid(draws.unit_grid());
    case VectorDistribution::kBell: return from_grid(draw_bell(draws));
    case VectorDistribution::kUniform: break;
  }
  return from_grid(draws.signed_grid());
}

double draw_weight(DrawSequence& draws, WeightDistribution distribution) {
  switch (distribution) {
    case WeightDistribution::kOne: return 1.0;
    case WeightDistribution::kWide: return from_grid(std::int64_t{1} << (kGridBits + draws.integer(-10, 10)));
    case WeightDistribution::kUniform: break;
  }
  return from_grid(draws.unit_grid() + 1);
}

struct Factors {
  ColumnMajor<double> X;
  std::vector<double> alpha;
};

Factors draw_factors(const TrialKey& key, const Dimensions& sizes, const PaperReading& reading, std::uint64_t attempt) {
  DrawSequence vectors(key, Purpose::kInertiaVectors, attempt);
  DrawSequence weights(key, Purpose::kInertiaWeights, attempt);
  Factors factors{ColumnMajor<double>(sizes.ngc, sizes.rank), std::vector<double>(sizes.rank)};
  for (double& entry : factors.X.data) entry = draw_entry(vectors, reading.x);
  for (double& weight : factors.alpha) weight = draw_weight(weights, reading.alpha);
  return factors;
}

// Scales each column of X by sqrt(alpha), so that X diag(alpha) X' = Y Y'.
ColumnMajor<double> square_root(Factors factors) {
  for (std::size_t k = 0; k < factors.X.cols; ++k) {
    const double scale = std::sqrt(factors.alpha[k]);
    for (std::size_t i = 0; i < factors.X.rows; ++i) factors.X(i, k) *= scale;
  }
  return std::move(factors.X);
}

ColumnMajor<double> draw_full_rank_inertia(const TrialKey& key, const Dimensions& sizes, const PaperReading& reading,
                                           double condition) {
  for (std::uint64_t attempt = 0;; ++attempt) {
    Factors factors = draw_factors(key, sizes, reading, attempt);
    ColumnMajor<double> G = weighted_outer_sum(factors.X, factors.alpha);
    if (!safely_positive_definite(G)) continue;
    if (condition == 0) return G;
    const Eigensystem spectrum = spectrum_of_square(square_root(std::move(factors)));
    return weighted_outer_sum(spectrum.vectors, map_spectrum(spectrum.values, condition, reading.spectrum));
  }
}

void draw_inertia(const TrialKey& key, const Dimensions& sizes, const PaperSet& set, const PaperReading& reading,
                  PaperSample& sample) {
  if (!set.features.reduced) {
    sample.form = InertiaForm::kDense;
    sample.G =
        draw_full_rank_inertia(key, sizes, reading, set.features.conditioned ? set.condition : reading.condition);
  } else {
    Factors factors = draw_factors(key, sizes, reading, 0);
    sample.form = InertiaForm::kFactored;
    sample.X = std::move(factors.X);
    sample.alpha = std::move(factors.alpha);
  }
  if (reading.matrix == MatrixReading::kPseudoInverse) return;
  if (set.features.reduced) sample.G = weighted_outer_sum(std::exchange(sample.X, {}), std::exchange(sample.alpha, {}));
  sample.form = InertiaForm::kInverse;
}

// The options of a set are those readings that its features make matter.
template <PaperFeatures kFeatures>
struct PaperSettings {
  PaperReading reading{.ngc_max = kFeatures.ngc_max, .nc_max = kFeatures.nc_max};
  static constexpr bool kDialled = !kFeatures.reduced && !kFeatures.conditioned;

  void visit(auto&& field) {
    if constexpr (kFeatures.redundant) visit_redundancy(field);
    if constexpr (kFeatures.frictional) visit_friction(field);
    if constexpr (kFeatures.reduced) {
      field("rank", reading.rank,
            Choices<RankReading>{{{"6..ngc", RankReading::kUpToFull},
                                  {"6..ngc-1", RankReading::kBelowFull},
                                  {"1..ngc", RankReading::kFromOne}}},
            "the range that the rank of the inertia is drawn from");
      field("inverse", reading.inverse,
            Choices<InverseReading>{{{"svd", InverseReading::kSvd}, {"plain", InverseReading::kPlain}}},
            "how M is formed for solvers that take (q, M): by the pseudo-inverse of the inertia, or by plain elimination "
            "as if its rank were full");
    }
    if constexpr (kFeatures.conditioned) {
      field("spectrum", reading.spectrum,
            Choices<SpectrumMap>{{{"loglinear", SpectrumMap::kLogLinear},
                                  {"linear", SpectrumMap::kLinear},
                                  {"geometric", SpectrumMap::kGeometric}}},
            "how the eigenvalues of the inertia are mapped into [1, condition]");
    }
    if constexpr (kDialled) {
      field("condition", reading.condition, RealRange{.min = 0, .max = 1e12},
            "condition number that the eigenvalues of the inertia are brought to, 1 or more; 0: as drawn");
    }
    visit_inertia(field);
    field("ngc_max", reading.ngc_max, IntegerRange{6, kLargestCeiling}, "ceiling of the number of coordinates");
    field("nc_max", reading.nc_max, IntegerRange{2, kLargestCeiling}, "ceiling of the number of contacts");
  }

 private:
  void visit_redundancy(auto&& field) {
    field("redundancy", reading.redundancy,
          Choices<Redundancy>{{{"multiple", Redundancy::kMultiple}, {"combination", Redundancy::kCombination}}},
          "a dependent contact is 1..5 times one independent one, or a {-2..2} combination of all of them");
    field("placement", reading.placement,
          Choices<Placement>{{{"last", Placement::kLast}, {"random", Placement::kRandom}}},
          "where the dependent contacts stand among the others");
  }
  void visit_friction(auto&& field) {
    field("sizes", reading.sizes,
          Choices<SizeReading>{{{"text", SizeReading::kText}, {"swapped", SizeReading::kSwapped}}},
          "ranges of ngc and nc as in the paper's text, or exchanged as in the printed lines of Algorithm IV.1");
    field("edges", reading.edges,
          Choices<EdgeReading>{{{"shared", EdgeReading::kShared}, {"per_contact", EdgeReading::kPerContact}}},
          "one number of cone edges for all contacts, or one drawn for each");
    field("cone_diagonal", reading.cone_diagonal, RealRange{.min = 0, .max = 1},
          "for solvers that take (q, M): stands on the diagonal of M's cone rows, which is zero; a dial that shows how "
          "sensitive a solver is, no reading of the paper");
  }
  void visit_inertia(auto&& field) {
    field("matrix", reading.matrix,
          Choices<MatrixReading>{
              {{"pseudoinverse", MatrixReading::kPseudoInverse}, {"literal", MatrixReading::kLiteral}}},
          "M = N' G* N with the (pseudo-)inverse, or M = N' G N as printed");
    field("alpha", reading.alpha,
          Choices<WeightDistribution>{{{"uniform", WeightDistribution::kUniform},
                                       {"one", WeightDistribution::kOne},
                                       {"wide", WeightDistribution::kWide}}},
          "weights of the rank-one updates: U(0,1], 1, or 2^U{-10..10}");
    field("x", reading.x,
          Choices<VectorDistribution>{{{"uniform", VectorDistribution::kUniform},
                                       {"positive", VectorDistribution::kPositive},
                                       {"bell", VectorDistribution::kBell}}},
          "entries of the rank-one updates: U(-1,1), U(0,1), or a sum of twelve uniform numbers");
  }
};

template <PaperFeatures kFeatures>
PaperSet make_set(std::string name, std::string stream, std::string summary, double condition = 0) {
  using Settings = PaperSettings<kFeatures>;
  PaperSet set{std::move(name), std::move(stream), std::move(summary), kFeatures, condition};
  read_options_as<Settings>(set);
  set.parse = [](std::string_view owner, const Options& options) {
    const PaperReading reading = parse_settings<Settings>(owner, options).reading;
    if (reading.condition > 0 && reading.condition < 1) {
      throw InputError(std::string(owner) + ": condition=" + format_real(reading.condition) + " is below 1");
    }
    return reading;
  };
  return set;
}

template <bool kFrictional>
void append_sets(const std::string& kind, std::vector<PaperSet>& sets) {
  const auto add = [&]<PaperFeatures kFeatures>(const std::string& name, const std::string& summary) {
    sets.push_back(make_set<kFeatures>(kind + name, kind + name, summary));
  };
  add.template operator()<PaperFeatures{.frictional = kFrictional}>("exp1", "full-rank inertia, independent contacts");
  add.template operator()<PaperFeatures{.frictional = kFrictional, .redundant = true}>(
      "exp2", "full-rank inertia, redundant contacts");
  add.template operator()<PaperFeatures{.frictional = kFrictional, .reduced = true}>(
      "exp3", "inertia of reduced rank, independent contacts");
  add.template operator()<PaperFeatures{.frictional = kFrictional, .redundant = true, .reduced = true}>(
      "exp4", "inertia of reduced rank, redundant contacts");

  constexpr PaperFeatures kConditioned{.frictional = kFrictional, .redundant = true, .conditioned = true};
  for_each_conditioned_experiment(kind, kind, [&](auto&&... arguments) {
    sets.push_back(make_set<kConditioned>(std::forward<decltype(arguments)>(arguments)...));
  });
  constexpr PaperFeatures kLarge{
      .frictional = kFrictional, .redundant = true, .conditioned = true, .ngc_max = 100, .nc_max = 100};
  sets.push_back(
      make_set<kLarge>(kind + "extra100", kind + "extra100", "as exp5-1e10 with both ceilings at 100", 1e10));
}

}  // namespace

const std::vector<PaperSet>& paper_sets() {
  static const std::vector<PaperSet> sets = [] {
    std::vector<PaperSet> all;
    append_sets<false>("paper/monotone/", all);
    append_sets<true>("paper/copositive/", all);
    return all;
  }();
  return sets;
}

PaperSample draw_paper(const PaperSet& set, const PaperReading& reading, std::uint64_t seed, std::uint64_t trial) {
  const TrialKey key{stream_id(set.stream), seed, trial};
  const Dimensions sizes = draw_dimensions(key, set.features, reading);
  PaperSample sample;
  sample.dependences = draw_dependences(key, sizes, reading);

  DrawSequence velocities(key, Purpose::kVelocity);
  sample.v = from_grid(signed_array(velocities, sizes.ngc, 1).data);
  sample.N = draw_normals(key, sizes, sample.dependences);
  draw_inertia(key, sizes, set, reading, sample);

  sample.edges.assign(sizes.nc, 0);
  sample.mu.assign(sizes.nc, 0.0);
  sample.D = ColumnMajor<double>(sizes.ngc, 0);
  if (!set.features.frictional) return sample;
  sample.edges = draw_edges(key, sizes, reading.edges, sample.dependences);
  sample.D = draw_tangents(key, sizes, sample.edges, sample.dependences);
  DrawSequence frictions(key, Purpose::kFriction);
  for (double& mu : sample.mu) mu = from_grid(frictions.unit_grid());
  return sample;
}

}  // namespace lcpbench
