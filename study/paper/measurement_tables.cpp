#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/paper/tables.h"

namespace lcpbench::paper {
namespace {

using Json = nlohmann::ordered_json;

struct Span {
  PooledMean best{};
  PooledMean all{};
};

/// The two numbers of an experiment: at the best parameters, and over all of them.
struct Part {
  PooledMean Span::*ours;
  PublishedSpread PublishedMeasurement::*published;
};
constexpr Part kParts[] = {{&Span::best, &PublishedMeasurement::best}, {&Span::all, &PublishedMeasurement::all}};

Span span_of(const Grid& grid, Quantity quantity, Measure measure) {
  return {at_best(grid, quantity, measure), over_all(grid, quantity, measure)};
}

std::optional<PublishedMeasurement> published_span(Kind kind, const Experiment& experiment,
                                                   std::optional<Family> family, Quantity quantity) {
  if (!family) return std::nullopt;
  if (quantity == Quantity::kViolation) return published_violation(kind, experiment.name, *family);
  return published_time(kind, experiment.name, *family, quantity == Quantity::kTimeSolved);
}

std::vector<const Experiment*> experiment_six() {
  std::vector<const Experiment*> six;
  for (const Experiment& experiment : experiments()) {
    if (experiment.regularized) six.push_back(&experiment);
  }
  return six;
}

const char* rows_words(Quantity quantity) { return quantity == Quantity::kTimeAll ? "all" : "solved"; }

Entry spread_entry(const Spread& spread) {
  if (spread.count == 0) return {kAbsent, "none"};
  return {spread_text(spread.mean, spread.sigma, spread.max), fmt::format("n = {}", spread.count)};
}

void add_condition_columns(Layout& layout) {
  for (const Experiment* experiment : experiment_six()) {
    layout.columns.push_back(std::string(experiment->condition) + ", best");
    layout.columns.push_back(std::string(experiment->condition) + ", all parameters");
  }
}

/// With every digit that the paper prints.
std::string printed(const PublishedSpread& spread) {
  if (std::isnan(spread.mean)) return kAbsent;
  return fmt::format("{:.6g} ({:.6g}) {:.6g}", spread.mean, spread.sigma, spread.max);
}

/// Adds a row: whose numbers, where they come from, and entry_of(experiment, part) for each condition.
template <class EntryOf>
void add_row(Layout& layout, const std::string& name, const std::string& source, Quantity quantity, EntryOf entry_of) {
  std::vector<Entry> row{{name, ""}, {source, ""}, {rows_words(quantity), ""}};
  for (const Experiment* experiment : experiment_six()) {
    for (const Part& part : kParts) row.push_back(entry_of(*experiment, part));
  }
  layout.rows.push_back(std::move(row));
}

/// "multiple, our verdict"; times of all problems depend on the reading alone.
std::string source_words(const std::string& reading, Quantity quantity, Measure measure) {
  return quantity == Quantity::kTimeAll ? reading : reading + ", " + words_for(measure);
}

bool has_reading(const std::vector<Grid>& grids, Kind kind, const std::string& label, const std::string& reading) {
  const auto six = experiment_six();
  return std::any_of(six.begin(), six.end(), [&](const Experiment* experiment) {
    return find_grid(grids, kind, *experiment, reading, label) != nullptr;
  });
}

/// Mean (sigma) max of Experiment 6, in the paper's order: per solver the published rows, then ours.
Layout spreads_layout(const Summary& summary, const std::vector<Grid>& grids, Kind kind,
                      const std::vector<Quantity>& quantities, const std::string& caption) {
  Layout layout{caption, {"Solver", "Source", "Problems"}, 3, {}};
  add_condition_columns(layout);
  std::optional<Family> last;
  for (const Contestant& contestant : contestants(grids, kind, is_experiment_six, published_families(kind))) {
    if (contestant.family && contestant.family != last) {
      last = contestant.family;
      for (const Quantity quantity : quantities) {
        if (!published_span(kind, *experiment_six().front(), last, quantity)) continue;
        add_row(layout, name_of(*last), "published", quantity,
                [&](const Experiment& experiment, const Part& part) -> Entry {
                  const auto published = published_span(kind, experiment, last, quantity);
                  return {published ? printed((*published).*part.published) : kAbsent, ""};
                });
      }
    }
    if (contestant.label.empty()) {
      std::vector<Entry> row{{name_of(*contestant.family), ""}, {why_not_run(summary, *contestant.family), ""}};
      row.resize(layout.columns.size());
      layout.rows.push_back(std::move(row));
      continue;
    }
    for (const char* reading : kReadings) {
      if (!has_reading(grids, kind, contestant.label, reading)) continue;
      for (const Quantity quantity : quantities) {
        for (const Measure measure : kCounts) {
          // "Best" depends on the measure also for the times of all problems: the other rows would differ there alone,
          // and stand in the file of all measurements.
          if (quantity == Quantity::kTimeAll && measure != Measure::kCriterion) continue;
          add_row(layout, code(contestant.label), source_words(reading, quantity, measure), quantity,
                  [&](const Experiment& experiment, const Part& part) -> Entry {
                    const Grid* grid = find_grid(grids, kind, experiment, reading, contestant.label);
                    if (grid == nullptr) return {"not run", ""};
                    if (grid->refused() > 0) return refused_entry(*grid);
                    return spread_entry((span_of(*grid, quantity, measure).*part.ours).values);
                  });
        }
      }
    }
  }
  return layout;
}

/// A ratio of two rows of the time tables.
struct RatioPair {
  Kind numerator_kind;
  Contestant numerator;
  Kind denominator_kind;
  Contestant denominator;
};

std::string name_of_side(Kind kind, const Contestant& side, bool with_kind) {
  const std::string name = side.label.empty() ? name_of(*side.family) : code(side.label);
  return with_kind ? std::string(name_of(kind)) + " " + name : name;
}

/// The same solver with friction over without; then all others over each that stands for the paper's Lemke.
std::vector<RatioPair> ratio_pairs(const std::vector<Grid>& grids, Kind kind) {
  const std::vector<Contestant> here = contestants(grids, kind, is_experiment_six, published_families(kind));
  std::vector<RatioPair> pairs;
  for (const Contestant& numerator : here) {
    for (const Contestant& denominator : here) {
      if (denominator.family == Family::kLemke && numerator.family != Family::kLemke)
        pairs.push_back({kind, numerator, kind, denominator});
    }
  }
  if (kind == Kind::kCopositive) {
    for (const Contestant& contestant : here) pairs.push_back({kind, contestant, Kind::kMonotone, contestant});
  }
  return pairs;
}

Entry published_ratio(const RatioPair& pair, const Experiment& experiment, Quantity quantity, const Part& part) {
  const auto top = published_span(pair.numerator_kind, experiment, pair.numerator.family, quantity);
  const auto bottom = published_span(pair.denominator_kind, experiment, pair.denominator.family, quantity);
  if (!top || !bottom) return {kAbsent, ""};
  return {number(((*top).*part.published).mean / ((*bottom).*part.published).mean), ""};
}

Entry our_ratio(const std::vector<Grid>& grids, const RatioPair& pair, const Experiment& experiment,
                const std::string& reading, Quantity quantity, Measure measure, const Part& part) {
  const Grid* top = find_grid(grids, pair.numerator_kind, experiment, reading, pair.numerator.label);
  const Grid* bottom = find_grid(grids, pair.denominator_kind, experiment, reading, pair.denominator.label);
  if (top == nullptr || bottom == nullptr) return {"not run", ""};
  for (const Grid* side : {top, bottom}) {
    if (side->refused() > 0) return refused_entry(*side);
  }
  const RatioOfMeans ratio{span_of(*top, quantity, measure).*part.ours, span_of(*bottom, quantity, measure).*part.ours};
  if (std::isnan(ratio.value())) return {kAbsent, ""};
  return {number(ratio.value()), number(ratio.interval().low) + "–" + number(ratio.interval().high)};
}

void add_ratio_rows(const std::vector<Grid>& grids, const RatioPair& pair, Layout& layout) {
  const bool across = pair.numerator_kind != pair.denominator_kind;
  const std::string name = name_of_side(pair.numerator_kind, pair.numerator, across) + " / " +
                           name_of_side(pair.denominator_kind, pair.denominator, across);
  for (const Quantity quantity : {Quantity::kTimeSolved, Quantity::kTimeAll}) {
    if (pair.numerator.family && pair.denominator.family) {
      add_row(layout, name, "published", quantity, [&](const Experiment& experiment, const Part& part) {
        return published_ratio(pair, experiment, quantity, part);
      });
    }
    for (const char* reading : kReadings) {
      const bool run = has_reading(grids, pair.numerator_kind, pair.numerator.label, reading) &&
                       has_reading(grids, pair.denominator_kind, pair.denominator.label, reading);
      if (!run) continue;
      for (const Measure measure : kCounts) {
        if (quantity == Quantity::kTimeAll && measure != Measure::kCriterion) continue;
        add_row(layout, name, source_words(reading, quantity, measure), quantity,
                [&](const Experiment& experiment, const Part& part) {
                  return our_ratio(grids, pair, experiment, reading, quantity, measure, part);
                });
      }
    }
  }
}

Layout ratios_layout(const std::vector<Grid>& grids, Kind kind) {
  Layout layout{"Ratios of mean times: what is compared with the paper", {"Ratio", "Source", "Problems"}, 3, {}};
  add_condition_columns(layout);
  for (const RatioPair& pair : ratio_pairs(grids, kind)) add_ratio_rows(grids, pair, layout);
  return layout;
}

Json spread_json(const Spread& spread) {
  return {{"count", spread.count}, {"mean", spread.mean}, {"sigma", spread.sigma}, {"max", spread.max}};
}

Json published_json(const std::optional<PublishedMeasurement>& published, PublishedSpread PublishedMeasurement::*part) {
  const double none = Proportion{}.value();
  const PublishedSpread spread = published ? (*published).*part : PublishedSpread{none, none, none};
  return {{"mean", spread.mean}, {"sigma", spread.sigma}, {"max", spread.max}};
}

const char* quantity_name(Quantity quantity) {
  switch (quantity) {
    case Quantity::kTimeSolved: return "time_of_solved_s";
    case Quantity::kTimeAll: return "time_of_all_s";
    case Quantity::kViolation: return "violation_of_solved_m_per_s";
  }
  return "";
}

Json measurement_record(const Summary& summary, const std::string& table, Kind kind, const Experiment& experiment,
                        const std::string& reading, const Contestant& contestant, const Grid* grid, Quantity quantity,
                        Measure measure) {
  const Span span = grid == nullptr ? Span{pooled_mean({}), pooled_mean({})} : span_of(*grid, quantity, measure);
  const auto published = published_span(kind, experiment, contestant.family, quantity);
  return {{"table", table},
          {"kind", name_of(kind)},
          {"experiment", experiment.name},
          {"redundancy", reading_words(experiment, reading)},
          {"paper_solver", contestant.family ? name_of(*contestant.family) : ""},
          {"solver", contestant.label},
          {"set", grid == nullptr ? "" : summary.sets[grid->set].name},
          {"not_run", why_no_numbers(summary, contestant, grid)},
          {"quantity", quantity_name(quantity)},
          {"solved_by", name_of(measure)},
          {"best_settings", grid == nullptr ? "" : settings_of(summary, range_of(*grid, measure).chosen)},
          {"best", spread_json(span.best.values)},
          {"all", spread_json(span.all.values)},
          {"published_best", published_json(published, &PublishedMeasurement::best)},
          {"published_all", published_json(published, &PublishedMeasurement::all)}};
}

/// Records of the experiments that `picks` takes; where we ran nothing, only of Experiment 6, which the paper prints.
Json measurement_records(const Summary& summary, const std::vector<Grid>& grids, const std::string& table, Kind kind,
                         const Picks& picks, const std::vector<Quantity>& quantities) {
  Json records = Json::array();
  for (const Experiment& experiment : experiments()) {
    if (!picks(experiment)) continue;
    const Picks same = [&experiment](const Experiment& other) { return &other == &experiment; };
    const auto families = experiment.regularized ? published_families(kind) : std::vector<Family>{};
    for (const Contestant& contestant : contestants(grids, kind, same, families)) {
      for (const std::string& reading : readings_of(experiment)) {
        const Grid* grid = find_grid(grids, kind, experiment, reading, contestant.label);
        for (const Quantity quantity : quantities) {
          for (const Measure measure : kCounts) {
            records.push_back(
                measurement_record(summary, table, kind, experiment, reading, contestant, grid, quantity, measure));
          }
        }
      }
    }
  }
  return records;
}

Json measurement_example(const Summary& summary) {
  return measurement_record(summary, "", Kind::kMonotone, experiments().front(), "", {Family::kLemke, ""}, nullptr,
                            Quantity::kTimeAll, Measure::kCriterion);
}

constexpr const char* kBestNote =
    "Best: the parameterisation that solves the most even trials (the first of equals, in the order of settings), "
    "measured on the odd trials. All parameters: every trial of every parameterisation pooled.";

}  // namespace

Table times_table(const Summary& summary, const std::vector<Grid>& grids, Kind kind) {
  const std::vector<Quantity> quantities{Quantity::kTimeSolved, Quantity::kTimeAll};
  Table table;
  table.id = kind == Kind::kMonotone ? "IV.3" : "IV.4";
  table.title = std::string("Running time of Experiment 6, ") + name_of(kind) + " problems [s]";
  table.layouts = {ratios_layout(grids, kind),
                   spreads_layout(summary, grids, kind, quantities, "Mean (sigma) maximum, in the paper’s layout")};
  table.notes = {kSolvedNote, kBestNote,
                 "Seconds of 2012 and of this machine stand in the same layout and are not compared: only the ratios "
                 "between solvers are. Interval of a ratio: 95 %, delta method on its logarithm, the two means taken "
                 "as independent, each known as well as its problems allow, however many parameterisations met them.",
                 "The paper’s Lemke is `regularized{test=tried}`: its test is the published one. `regularized` tests "
                 "on the problem itself. Times are set-up plus solve, CPU. Parameterisations that answer a problem "
                 "alike share a time, the mean of theirs."};
  table.query = measurements_query();
  table.records = measurement_records(summary, grids, table.id, kind, is_experiment_six, quantities);
  table.example = measurement_example(summary);
  return table;
}

Table violations_table(const Summary& summary, const std::vector<Grid>& grids, Kind kind) {
  const std::vector<Quantity> quantities{Quantity::kViolation};
  Table table;
  table.id = kind == Kind::kMonotone ? "IV.5" : "IV.6";
  table.title =
      std::string("Normal constraint violation of solved problems of Experiment 6, ") + name_of(kind) + " [m/s]";
  table.layouts = {spreads_layout(summary, grids, kind, quantities, "Mean (sigma) maximum")};
  table.notes = {kSolvedNote, kBestNote,
                 "By the criterion no violation can exceed 1e-3 m/s: a larger answer does not count as solved."};
  table.query = measurements_query();
  table.records = measurement_records(summary, grids, table.id, kind, is_experiment_six, quantities);
  table.example = measurement_example(summary);
  return table;
}

Table measurements_table(const Summary& summary, const std::vector<Grid>& grids) {
  Table table;
  table.id = "measurements";
  table.title = "Times and violations of every experiment";
  table.query = measurements_query();
  table.records = Json::array();
  for (const Kind kind : kKinds) {
    const Json records = measurement_records(summary, grids, "", kind, [](const Experiment&) { return true; },
                                             {Quantity::kTimeSolved, Quantity::kTimeAll, Quantity::kViolation});
    for (const Json& record : records) table.records.push_back(record);
  }
  table.example = measurement_example(summary);
  return table;
}

}  // namespace lcpbench::paper
