#include "study/paper/published.h"

#include <algorithm>
#include <cmath>

#include "study/statistics/statistics.h"

namespace lcpbench::paper {

namespace {

constexpr PublishedSpread kNotPrinted{kNoNumber, kNoNumber, kNoNumber};

constexpr Kind kMono = Kind::kMonotone;
constexpr Kind kCop = Kind::kCopositive;
constexpr Family kLemke = Family::kLemke;
constexpr Family kPath = Family::kPath;
constexpr Family kIp = Family::kInteriorPoint;

constexpr Experiment kExperiments[] = {
    {"exp1", "1"},
    {"exp2", "2", true},
    {"exp3", "3"},
    {"exp4", "4", true},
    {"exp5-1e5", "5, 1e5", true, false, "1e5"},
    {"exp5-1e8", "5, 1e8", true, false, "1e8"},
    {"exp5-1e10", "5, 1e10", true, false, "1e10"},
    {"exp6-1e5", "6, 1e5", true, true, "1e5"},
    {"exp6-1e8", "6, 1e8", true, true, "1e8"},
    {"exp6-1e10", "6, 1e10", true, true, "1e10"},
    {"extra100", "ceilings 100", true, false, "1e10"},
};

// Percentages, as printed.
constexpr PublishedRate kRates[] = {
    {kMono, "exp1", kLemke, 92.71, 97.59, 100.0},
    {kMono, "exp1", kPath, 97.48, 98.68, 99.27},
    {kMono, "exp1", kIp, 99.90, 100.0, 100.0},
    {kMono, "exp2", kLemke, 79.73, 93.13, 100.0},
    {kMono, "exp2", kPath, 93.92, 94.80, 97.28},
    {kMono, "exp2", kIp, 96.74, 96.75, 96.77},
    {kMono, "exp3", kLemke, 62.90, 63.57, 64.09},
    {kMono, "exp3", kPath, 61.81, 63.47, 63.93},
    {kMono, "exp3", kIp, 63.70, 63.71, 63.72},
    {kMono, "exp4", kLemke, 55.83, 67.55, 73.25},
    {kMono, "exp4", kPath, 67.91, 68.95, 72.56},
    {kMono, "exp4", kIp, 65.49, 65.61, 65.67},
    {kMono, "exp5-1e5", kLemke, 69.89, 88.91, 100.0},
    {kMono, "exp5-1e5", kPath, 94.07, 95.30, 99.20},
    {kMono, "exp5-1e5", kIp, 87.34, 87.54, 87.65},
    {kMono, "exp5-1e8", kLemke, 59.35, 84.74, 99.99},
    {kMono, "exp5-1e8", kPath, 94.03, 95.51, 99.19},
    {kMono, "exp5-1e8", kIp, 74.86, 75.05, 75.15},
    {kMono, "exp5-1e10", kLemke, 54.05, 81.57, 99.94},
    {kMono, "exp5-1e10", kPath, 91.72, 92.99, 96.99},
    {kMono, "exp5-1e10", kIp, 70.41, 70.61, 70.74},
    {kMono, "exp6-1e5", kLemke, 94.13, 98.87, 100.0},
    {kMono, "exp6-1e5", kPath, 98.82, 99.79, 99.92},
    {kMono, "exp6-1e5", kIp, 88.26, 88.35, 88.41},
    {kMono, "exp6-1e8", kLemke, 78.85, 95.93, 100.0},
    {kMono, "exp6-1e8", kPath, 98.58, 99.66, 99.87},
    {kMono, "exp6-1e8", kIp, 75.69, 75.91, 75.97},
    {kMono, "exp6-1e10", kLemke, 71.10, 92.87, 99.99},
    {kMono, "exp6-1e10", kPath, 96.81, 97.94, 98.17},
    {kMono, "exp6-1e10", kIp, 71.30, 71.49, 71.60},
    {kCop, "exp1", kLemke, 77.09, 91.08, 100.0},
    {kCop, "exp1", kPath, 67.21, 67.71, 67.82},
    {kCop, "exp2", kLemke, 53.35, 82.14, 99.91},
    {kCop, "exp2", kPath, 65.18, 66.29, 66.57},
    {kCop, "exp3", kLemke, 34.42, 36.38, 37.54},
    {kCop, "exp3", kPath, 27.07, 27.17, 27.20},
    {kCop, "exp4", kLemke, 26.99, 37.61, 43.16},
    {kCop, "exp4", kPath, 31.15, 31.30, 31.45},
    {kCop, "exp5-1e5", kLemke, kNoNumber, 80.98, 99.94},
    {kCop, "exp5-1e5", kPath, kNoNumber, 67.66, 67.72},
    {kCop, "exp5-1e8", kLemke, kNoNumber, 75.45, 99.84},
    {kCop, "exp5-1e8", kPath, kNoNumber, 68.02, 68.14},
    {kCop, "exp5-1e10", kLemke, kNoNumber, 70.88, 99.72},
    {kCop, "exp5-1e10", kPath, kNoNumber, 62.20, 62.44},
    {kCop, "exp6-1e5", kLemke, kNoNumber, 95.99, 100.0},
    {kCop, "exp6-1e5", kPath, kNoNumber, 67.62, 67.64},
    {kCop, "exp6-1e8", kLemke, kNoNumber, 91.32, 99.97},
    {kCop, "exp6-1e8", kPath, kNoNumber, 67.90, 67.93},
    {kCop, "exp6-1e10", kLemke, kNoNumber, 85.97, 99.87},
    {kCop, "exp6-1e10", kPath, kNoNumber, 63.38, 63.70},
    {kCop, "extra100", kLemke, kNoNumber, kNoNumber, 91.77},
};

struct PathRow {
  std::string_view experiment;
  PathMeasured percent;
};

// PATH 4.7.03 (libpath47.so, of the hash c5d2202157f3d24b that tables show) through adapters/path, x86-64, 2,000 trials
// of seed 1, the nine cells of the sweep `paper`. Percentages. Experiment 6 has the problems of Experiment 5.
constexpr PathMeasured kPath1e5{{51.35, 79.5, 100}, {100, 100, 100}};
constexpr PathMeasured kPath1e8{{52.05, 75.044, 100}, {100, 100, 100}};
constexpr PathMeasured kPath1e10{{54.4, 73.417, 99.25}, {99.5, 99.5, 99.5}};
constexpr PathRow kPathRows[] = {
    {"exp1", {{24, 69.467, 99.85}, {99.95, 99.95, 99.95}}},
    {"exp2", {{43.9, 79.211, 99.95}, {99.95, 99.95, 99.95}}},
    {"exp3", {{17.9, 46.467, 62.85}, {62.9, 62.9, 62.9}}},
    {"exp4", {{40, 64.867, 77.75}, {77.75, 77.75, 77.75}}},
    {"exp5-1e5", kPath1e5},
    {"exp5-1e8", kPath1e8},
    {"exp5-1e10", kPath1e10},
    {"exp6-1e5", kPath1e5},
    {"exp6-1e8", kPath1e8},
    {"exp6-1e10", kPath1e10},
};

struct Measured {
  Kind kind;
  std::string_view experiment;
  Family family;
  bool solved_only;
  PublishedMeasurement values;
};

constexpr Measured kTimes[] = {
    {kMono, "exp6-1e5", kLemke, true, {{1.40e-4, 0.001, 0.03}, {3.93e-4, 0.004, 0.64}}},
    {kMono, "exp6-1e8", kLemke, true, {{1.90e-4, 0.001, 0.02}, {4.63e-4, 0.006, 0.78}}},
    {kMono, "exp6-1e10", kLemke, true, {{1.88e-4, 0.001, 0.01}, {4.05e-4, 0.003, 0.34}}},
    {kMono, "exp6-1e5", kLemke, false, {{1.40e-4, 0.001, 0.03}, {4.20e-4, 0.004, 0.64}}},
    {kMono, "exp6-1e8", kLemke, false, {{1.88e-4, 0.001, 0.01}, {5.28e-4, 0.006, 0.78}}},
    {kMono, "exp6-1e10", kLemke, false, {{1.88e-4, 0.001, 0.01}, {5.50e-4, 0.004, 0.44}}},
    {kMono, "exp6-1e5", kPath, true, {{8.67e-4, 0.003, 0.05}, {1.92e-3, 0.006, 0.10}}},
    {kMono, "exp6-1e8", kPath, true, {{1.07e-3, 0.003, 0.06}, {2.16e-3, 0.007, 0.09}}},
    {kMono, "exp6-1e10", kPath, true, {{1.76e-3, 0.006, 0.11}, {2.37e-3, 0.007, 0.12}}},
    {kMono, "exp6-1e5", kPath, false, {{8.67e-4, 0.003, 0.05}, {1.92e-3, 0.006, 0.10}}},
    {kMono, "exp6-1e8", kPath, false, {{1.08e-3, 0.003, 0.06}, {2.38e-3, 0.008, 0.12}}},
    {kMono, "exp6-1e10", kPath, false, {{3.42e-3, 0.014, 0.15}, {4.53e-3, 0.016, 0.16}}},
    {kMono, "exp6-1e5", kIp, true, {{0.413, 1.185, 20.12}, {0.411, 1.186, 20.26}}},
    {kMono, "exp6-1e8", kIp, true, {{0.384, 0.819, 13.93}, {0.370, 0.815, 14.29}}},
    {kMono, "exp6-1e10", kIp, true, {{0.312, 0.735, 17.89}, {0.297, 0.731, 17.93}}},
    {kMono, "exp6-1e5", kIp, false, {{1.09, 3.291, 25.66}, {1.09, 3.290, 25.84}}},
    {kMono, "exp6-1e8", kIp, false, {{2.59, 5.067, 28.22}, {2.58, 5.068, 28.26}}},
    {kMono, "exp6-1e10", kIp, false, {{3.13, 5.521, 27.21}, {3.12, 5.524, 27.27}}},
    {kCop, "exp6-1e5", kLemke, true, {{0.594, 2.018, 47.54}, {1.41, 15.212, 1781.61}}},
    {kCop, "exp6-1e8", kLemke, true, {{0.667, 1.249, 7.09}, {1.61, 7.149, 262.66}}},
    {kCop, "exp6-1e10", kLemke, true, {{0.516, 1.167, 8.35}, {1.24, 7.266, 346.54}}},
    {kCop, "exp6-1e5", kLemke, false, {{0.653, 2.209, 47.54}, {1.80, 15.961, 1781.61}}},
    {kCop, "exp6-1e8", kLemke, false, {{0.902, 2.541, 28.84}, {2.61, 9.620, 262.66}}},
    {kCop, "exp6-1e10", kLemke, false, {{1.02, 5.576, 111.53}, {2.48, 11.006, 346.54}}},
    {kCop, "exp6-1e5", kPath, true, {{1.47e-2, 0.043, 0.82}, {1.66e-2, 0.059, 2.94}}},
    {kCop, "exp6-1e8", kPath, true, {{5.29e-2, 0.468, 7.78}, {5.07e-2, 0.437, 11.35}}},
    {kCop, "exp6-1e10", kPath, true, {{2.38e-2, 0.173, 2.79}, {3.51e-2, 0.423, 20.02}}},
    {kCop, "exp6-1e5", kPath, false, {{3.65e-2, 0.285, 6.08}, {3.92e-2, 0.290, 6.23}}},
    {kCop, "exp6-1e8", kPath, false, {{8.88e-2, 0.570, 7.78}, {0.119, 0.918, 27.79}}},
    {kCop, "exp6-1e10", kPath, false, {{0.221, 1.867, 34.32}, {0.334, 3.076, 81.01}}},
};

constexpr Measured kViolations[] = {
    {kMono, "exp6-1e5", kLemke, true, {{7.13e-10, 2.89e-8, 1.72e-6}, {1.72e-7, 1.01e-5, 9.67e-4}}},
    {kMono, "exp6-1e8", kLemke, true, {{9.75e-9, 3.74e-7, 2.27e-5}, {5.33e-7, 1.14e-5, 9.82e-4}}},
    {kMono, "exp6-1e10", kLemke, true, {{4.39e-7, 1.10e-5, 6.70e-4}, {1.35e-6, 2.26e-5, 9.61e-4}}},
    {kMono, "exp6-1e5", kPath, true, {{7.50e-8, 1.77e-6, 1.12e-4}, {4.15e-7, 1.09e-5, 7.60e-4}}},
    {kMono, "exp6-1e8", kPath, true, {{6.06e-8, 2.66e-7, 1.42e-5}, {5.84e-7, 1.31e-5, 7.44e-4}}},
    {kMono, "exp6-1e10", kPath, true, {{4.27e-7, 1.44e-5, 6.70e-4}, {9.28e-7, 2.09e-5, 9.07e-4}}},
    {kMono, "exp6-1e5", kIp, true, {{3.57e-7, 8.83e-6, 2.84e-4}, kNotPrinted}},
    {kMono, "exp6-1e8", kIp, true, {{8.23e-7, 1.90e-5, 9.47e-4}, kNotPrinted}},
    {kMono, "exp6-1e10", kIp, true, {{1.91e-5, 8.22e-5, 9.95e-4}, kNotPrinted}},
    {kCop, "exp6-1e5", kLemke, true, {{4.69e-6, 4.51e-5, 8.58e-4}, {2.56e-6, 3.01e-5, 9.08e-4}}},
    {kCop, "exp6-1e8", kLemke, true, {{4.72e-6, 5.68e-5, 9.81e-4}, {2.77e-6, 3.50e-5, 9.81e-4}}},
    {kCop, "exp6-1e10", kLemke, true, {{4.64e-7, 3.23e-6, 4.85e-5}, {4.44e-6, 4.91e-5, 9.55e-4}}},
    {kCop, "exp6-1e5", kPath, true, {{3.79e-8, 1.09e-7, 9.93e-7}, {8.79e-8, 4.52e-6, 4.22e-4}}},
    {kCop, "exp6-1e8", kPath, true, {{5.84e-8, 1.35e-7, 7.50e-7}, {1.66e-7, 4.79e-6, 2.58e-4}}},
    {kCop, "exp6-1e10", kPath, true, {{8.04e-8, 1.77e-7, 1.23e-6}, {4.70e-7, 1.59e-5, 9.62e-4}}},
};

std::optional<PublishedMeasurement> find_measurement(std::span<const Measured> rows, Kind kind,
                                                     std::string_view experiment, Family family, bool solved_only) {
  for (const Measured& row : rows) {
    if (row.kind == kind && row.experiment == experiment && row.family == family && row.solved_only == solved_only) {
      return row.values;
    }
  }
  return std::nullopt;
}

// The generator's sizes, docs/reference/generators.md.
constexpr int kFewestCoordinates = 6;
constexpr int kMostCoordinates = 15;
constexpr int kFewestContacts = 2;
constexpr int kMostContacts = 20;
constexpr int kLowestRank = 6;

/// Mean of `chance(contacts, coordinates, rank)` over the sizes.
template <class Chance>
double mean_over_sizes(Chance chance) {
  double total = 0;
  for (int coordinates = kFewestCoordinates; coordinates <= kMostCoordinates; ++coordinates) {
    const int ranks = coordinates - kLowestRank + 1;
    for (int contacts = kFewestContacts; contacts <= kMostContacts; ++contacts) {
      for (int rank = kLowestRank; rank <= coordinates; ++rank) total += chance(contacts, coordinates, rank) / ranks;
    }
  }
  return total / ((kMostCoordinates - kFewestCoordinates + 1) * (kMostContacts - kFewestContacts + 1));
}

}  // namespace

const char* name_of(Kind kind) { return kind == Kind::kMonotone ? "monotone" : "copositive"; }

const char* name_of(Family family) {
  switch (family) {
    case Family::kLemke: return "Lemke";
    case Family::kPath: return "PATH";
    case Family::kInteriorPoint: return "IP";
  }
  return "";
}

std::span<const Experiment> experiments() { return kExperiments; }

const Experiment* find_experiment(std::string_view name) {
  const auto found = std::find_if(std::begin(kExperiments), std::end(kExperiments),
                                  [name](const Experiment& experiment) { return experiment.name == name; });
  return found == std::end(kExperiments) ? nullptr : found;
}

std::optional<PublishedRate> published_rate(Kind kind, std::string_view experiment, Family family) {
  for (PublishedRate row : kRates) {
    if (row.kind != kind || row.experiment != experiment || row.family != family) continue;
    row.worst /= 100;
    row.average /= 100;
    row.best /= 100;
    return row;
  }
  return std::nullopt;
}

std::optional<PathMeasured> path_measured(Kind kind, std::string_view experiment) {
  if (kind != Kind::kMonotone) return std::nullopt;
  for (const auto& [name, percent] : kPathRows) {
    if (name != experiment) continue;
    const auto shares = [](const ShareRange& range) {
      return ShareRange{range.worst / 100, range.average / 100, range.best / 100};
    };
    return PathMeasured{shares(percent.claimed), shares(percent.any)};
  }
  return std::nullopt;
}

std::optional<PublishedMeasurement> published_time(Kind kind, std::string_view experiment, Family family,
                                                   bool solved_only) {
  return find_measurement(kTimes, kind, experiment, family, solved_only);
}

std::optional<PublishedMeasurement> published_violation(Kind kind, std::string_view experiment, Family family) {
  return find_measurement(kViolations, kind, experiment, family, true);
}

double wendel(int count, int dimension) {
  double binomial = 1;
  double sum = 0;
  for (int i = 0; i < dimension && i < count; ++i) {
    sum += binomial;
    binomial = binomial * (count - 1 - i) / (i + 1);
  }
  return std::ldexp(sum, 1 - count);
}

double solvable_chance(int contacts, int coordinates, int rank) {
  if (rank >= coordinates) return 1;
  return (wendel(contacts, rank) + wendel(contacts, rank + 1)) / 2;
}

double solvable_share_of_exp3() { return mean_over_sizes(solvable_chance); }

double solvable_share_of_exp4() {
  return mean_over_sizes([](int contacts, int coordinates, int rank) {
    double total = 0;
    for (int independent = 1; independent <= contacts; ++independent) {
      total += solvable_chance(independent, coordinates, rank);
    }
    return total / contacts;
  });
}

}  // namespace lcpbench::paper
