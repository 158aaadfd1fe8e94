#include "study/paper/tables.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "study/paper/queries.h"

namespace lcpbench::paper {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kAbsent = "–";

/// How the two measures are called in the tables.
const char* words_for(Measure measure) { return measure == Measure::kCriterion ? "paper’s criterion" : "our verdict"; }

bool compared_with_paper(const Grid& grid, Kind kind) {
  return grid.problems.kind == kind && grid.problems.other_readings().empty();
}

std::string reading_words(const Experiment& experiment, const std::string& reading) {
  return experiment.redundant ? reading : kAbsent;
}

/// A solver of a table: one of the paper's, and the label of ours ("" where the store has none of it).
struct Contestant {
  std::optional<Family> family;
  std::string label;
};

using Picks = std::function<bool(const Experiment&)>;

/// The solvers of a table: for each of the paper's that it has, ours of that family, or one empty label; then the rest.
std::vector<Contestant> contestants(const std::vector<Grid>& grids, Kind kind, const Picks& picks,
                                    const std::vector<Family>& published) {
  std::vector<Contestant> ours;
  for (const Grid& grid : grids) {
    if (!compared_with_paper(grid, kind) || !picks(*grid.problems.experiment)) continue;
    const bool known =
        std::any_of(ours.begin(), ours.end(), [&](const Contestant& c) { return c.label == grid.label; });
    if (!known) ours.push_back({family_of(grid.solver), grid.label});
  }
  std::stable_sort(ours.begin(), ours.end(),
                   [](const Contestant& a, const Contestant& b) { return natural_less(a.label, b.label); });
  std::vector<Contestant> ordered;
  for (const Family family : published) {
    const std::size_t before = ordered.size();
    for (const Contestant& contestant : ours) {
      if (contestant.family == family) ordered.push_back(contestant);
    }
    if (ordered.size() == before) ordered.push_back({family, ""});
  }
  for (const Contestant& contestant : ours) {
    const bool placed =
        contestant.family && std::find(published.begin(), published.end(), *contestant.family) != published.end();
    if (!placed) ordered.push_back(contestant);
  }
  return ordered;
}

std::vector<Family> published_families(Kind kind) {
  std::vector<Family> families;
  for (const Family family : kFamilies) {
    if (published_rate(kind, "exp1", family)) families.push_back(family);
  }
  return families;
}

// --- solution frequency ---

std::string triple(double worst, double average, double best) {
  return points(worst) + " / " + points(average) + " / " + points(best);
}

Entry published_entry(Kind kind, const Experiment& experiment, Family family) {
  const std::optional<PublishedRate> rate = published_rate(kind, experiment.name, family);
  return rate ? Entry{triple(rate->worst, rate->average, rate->best), ""} : Entry{kAbsent, ""};
}

Entry range_entry(const GridRange& range) {
  if (range.best_cell == nullptr) return {kAbsent, "no problem is known to be solvable"};
  return {triple(range.worst.value(), range.average.value(), range.best.value()),
          fmt::format("worst {}; best {}; n = {:.0f}", points(range.worst.interval()), points(range.best.interval()),
                      range.average.trials)};
}

/// What stands instead of a number where a solver refused some of the problems: a refusal is no failure to solve, and
/// a share of the rest is not comparable.
Entry refused_entry(const Grid& grid) {
  const std::string text = grid.refusal();
  const std::size_t colon = text.find(": ");
  return {text.substr(0, colon), colon == std::string::npos ? "" : text.substr(colon + 2)};
}

/// A column of the rates: what the paper prints of a solver, or one of ours.
struct RateColumn {
  Contestant contestant;
  bool published = false;
};

/// Before the first of ours of each of the paper's solvers stands what the paper prints of it.
std::vector<RateColumn> rate_columns(const std::vector<Contestant>& contestants, Kind kind) {
  std::vector<RateColumn> columns;
  std::optional<Family> last;
  for (const Contestant& contestant : contestants) {
    const bool printed = contestant.family && published_rate(kind, "exp1", *contestant.family);
    if (printed && contestant.family != last) columns.push_back({contestant, true});
    if (printed) last = contestant.family;
    columns.push_back({contestant, false});
  }
  return columns;
}

std::string column_title(const RateColumn& column) {
  if (column.published) return std::string(name_of(*column.contestant.family)) + ", published";
  if (column.contestant.label.empty()) return std::string(name_of(*column.contestant.family)) + ", ours";
  return code(column.contestant.label);
}

/// Worst / average / best: per experiment and reading one row for each measure, or one that says that nothing was run;
/// a column per solver.
class RatesLayout {
 public:
  RatesLayout(const Summary& summary, const std::vector<Grid>& grids, Kind kind, const Picks& picks)
      : summary_(summary),
        grids_(grids),
        kind_(kind),
        columns_(rate_columns(contestants(grids, kind, picks, published_families(kind)), kind)) {}

  Layout build(const std::string& caption, const Picks& picks) {
    layout_ = {caption, {"Experiment", "Redundancy", "Solved by"}, 3, {}};
    for (const RateColumn& column : columns_) layout_.columns.push_back(column_title(column));
    for (const Experiment& experiment : experiments()) {
      if (picks(experiment)) add_experiment(experiment);
    }
    return std::move(layout_);
  }

 private:
  void add_experiment(const Experiment& experiment) {
    bool first = true;
    for (const std::string& reading : readings_of(experiment)) {
      if (!was_run(experiment, reading)) {
        add_row(experiment, reading, std::nullopt, first);
        first = false;
        continue;
      }
      for (const Measure measure : kMeasures) {
        add_row(experiment, reading, measure, first);
        first = false;
      }
    }
  }

  bool was_run(const Experiment& experiment, const std::string& reading) const {
    return std::any_of(columns_.begin(), columns_.end(), [&](const RateColumn& column) {
      return find_grid(grids_, kind_, experiment, reading, column.contestant.label) != nullptr;
    });
  }

  void add_row(const Experiment& experiment, const std::string& reading, std::optional<Measure> measure,
               bool with_published) {
    std::vector<Entry> row{{std::string(experiment.title), ""},
                           {reading_words(experiment, reading), ""},
                           {measure ? words_for(*measure) : kAbsent, ""}};
    for (const RateColumn& column : columns_) {
      if (column.published) {
        row.push_back(with_published ? published_entry(kind_, experiment, *column.contestant.family) : Entry{});
        continue;
      }
      const Grid* grid = find_grid(grids_, kind_, experiment, reading, column.contestant.label);
      if (grid == nullptr || !measure) {
        row.push_back(not_run(column.contestant));
      } else {
        row.push_back(grid->refused() > 0 ? refused_entry(*grid) : range_entry(range_of(*grid, *measure)));
      }
    }
    layout_.rows.push_back(std::move(row));
  }

  /// The reason stands once, in the table's first row.
  Entry not_run(const Contestant& contestant) const {
    const bool explain = contestant.label.empty() && layout_.rows.empty();
    return {explain ? why_not_run(summary_, *contestant.family) : "not run", ""};
  }

  const Summary& summary_;
  const std::vector<Grid>& grids_;
  Kind kind_;
  std::vector<RateColumn> columns_;
  Layout layout_;
};

Layout rates_layout(const Summary& summary, const std::vector<Grid>& grids, Kind kind, const std::string& caption,
                    const Picks& picks) {
  return RatesLayout(summary, grids, kind, picks).build(caption, picks);
}

/// The parameterisation that the even trials choose, and what it does on the odd ones.
Layout chosen_layout(const Summary& summary, const std::vector<Grid>& grids, Kind kind) {
  Layout layout{"Best parameterisation: chosen on the even trials, its rate on the odd ones",
                {"Experiment", "Redundancy", "Solver", "Solved by", "Parameterisation", "Even trials", "Odd trials"},
                5,
                {}};
  for (const Grid& grid : grids) {
    if (!compared_with_paper(grid, kind) || grid.refused() > 0) continue;
    for (const Measure measure : kMeasures) {
      const GridRange range = range_of(grid, measure);
      if (range.chosen == nullptr) continue;
      layout.rows.push_back({{std::string(grid.problems.experiment->title), ""},
                             {reading_words(*grid.problems.experiment, grid.problems.redundancy()), ""},
                             {code(grid.label), ""},
                             {words_for(measure), ""},
                             {code(settings_of(summary, range.chosen)), ""},
                             {points(range.chosen_even.value()), ""},
                             {points(range.held_out.value()), points(range.held_out.interval())}});
    }
  }
  return layout;
}

/// How far a solver's rate depends on its parameters.
Layout robustness_layout(const std::vector<Grid>& grids, Kind kind) {
  Layout layout{"Dependence on the parameters: range (best − worst) and standard deviation of the rates [points]",
                {"Experiment", "Redundancy", "Solver", "Solved by", "Parameterisations", "Range", "Sigma"},
                4,
                {}};
  for (const Grid& grid : grids) {
    if (!compared_with_paper(grid, kind) || grid.refused() > 0) continue;
    for (const Measure measure : kMeasures) {
      const GridRange range = range_of(grid, measure);
      if (range.best_cell == nullptr) continue;
      layout.rows.push_back({{std::string(grid.problems.experiment->title), ""},
                             {reading_words(*grid.problems.experiment, grid.problems.redundancy()), ""},
                             {code(grid.label), ""},
                             {words_for(measure), ""},
                             {std::to_string(grid.cells.size()), ""},
                             {points(range.best.value() - range.worst.value()), ""},
                             {points(range.sigma), ""}});
    }
  }
  return layout;
}

Json range_json(const Summary& summary, const GridRange& range) {
  return {{"worst", share_json(range.worst)},
          {"average", number_json(range.average.value())},
          {"best", share_json(range.best)},
          {"sigma", number_json(range.sigma)},
          {"worst_settings", settings_of(summary, range.worst_cell)},
          {"best_settings", settings_of(summary, range.best_cell)},
          {"chosen_on_even", settings_of(summary, range.chosen)},
          {"even", number_json(range.chosen_even.value())},
          {"held_out", share_json(range.held_out)}};
}

/// "" for a whole grid; else why it is absent, or what it refused.
std::string why_no_numbers(const Summary& summary, const Contestant& contestant, const Grid* grid) {
  if (grid != nullptr) return grid->refusal();
  return contestant.label.empty() ? why_not_run(summary, *contestant.family) : "not run";
}

Json rates_record(const Summary& summary, const std::string& table, Kind kind, const Experiment& experiment,
                  const std::string& reading, const Contestant& contestant, const Grid* grid) {
  const std::optional<PublishedRate> published =
      contestant.family ? published_rate(kind, experiment.name, *contestant.family) : std::nullopt;
  const double none = Proportion{}.value();
  Json record{{"table", table},
              {"kind", name_of(kind)},
              {"experiment", experiment.name},
              {"redundancy", reading_words(experiment, reading)},
              {"paper_solver", contestant.family ? name_of(*contestant.family) : ""},
              {"solver", contestant.label},
              {"set", grid == nullptr ? "" : summary.sets[grid->set].name},
              {"not_run", why_no_numbers(summary, contestant, grid)},
              {"parameterisations", grid == nullptr ? 0 : grid->cells.size()}};
  record["trials"] = number_json(grid == nullptr ? none : range_of(*grid, Measure::kCriterion).average.trials);
  record["published"] = {{"worst", number_json(published ? published->worst : none)},
                         {"average", number_json(published ? published->average : none)},
                         {"best", number_json(published ? published->best : none)}};
  for (const Measure measure : kMeasures) {
    record[name_of(measure)] = range_json(summary, grid == nullptr ? GridRange{} : range_of(*grid, measure));
  }
  return record;
}

// --- times and violations ---

struct Span {
  PooledMean best{};
  PooledMean all{};
};

Span span_of(const Grid& grid, Quantity quantity, Measure measure) {
  return {at_best(grid, quantity, measure), over_all(grid, quantity, measure)};
}

std::optional<PublishedMeasurement> published_span(Kind kind, const Experiment& experiment,
                                                   std::optional<Family> family, Quantity quantity) {
  if (!family) return std::nullopt;
  if (quantity == Quantity::kViolation) return published_violation(kind, experiment.name, *family);
  return published_time(kind, experiment.name, *family, quantity == Quantity::kTimeSolved);
}

bool is_experiment_six(const Experiment& experiment) { return experiment.regularized; }

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

std::vector<Entry> published_row(Kind kind, Family family, Quantity quantity) {
  std::vector<Entry> row{{name_of(family), ""}, {"published", ""}, {rows_words(quantity), ""}};
  for (const Experiment* experiment : experiment_six()) {
    const auto published = published_span(kind, *experiment, family, quantity);
    row.push_back({published ? printed(published->best) : kAbsent, ""});
    row.push_back({published ? printed(published->all) : kAbsent, ""});
  }
  return row;
}

std::vector<Entry> our_row(const std::vector<Grid>& grids, Kind kind, const std::string& label,
                           const std::string& reading, Quantity quantity, Measure measure) {
  const std::string source = quantity == Quantity::kTimeAll ? reading : reading + ", " + words_for(measure);
  std::vector<Entry> row{{code(label), ""}, {source, ""}, {rows_words(quantity), ""}};
  for (const Experiment* experiment : experiment_six()) {
    const Grid* grid = find_grid(grids, kind, *experiment, reading, label);
    const Span span = grid == nullptr ? Span{} : span_of(*grid, quantity, measure);
    for (const Spread& part : {span.best.values, span.all.values}) {
      if (grid == nullptr) {
        row.push_back({"not run", ""});
      } else {
        row.push_back(grid->refused() > 0 ? refused_entry(*grid) : spread_entry(part));
      }
    }
  }
  return row;
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
        if (published_span(kind, *experiment_six().front(), last, quantity)) {
          layout.rows.push_back(published_row(kind, *last, quantity));
        }
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
        for (const Measure measure : kMeasures) {
          // "Best" depends on the measure also for the times of all problems: the row by verdict would differ there
          // alone, and stands in the file of all measurements.
          if (quantity == Quantity::kTimeAll && measure == Measure::kVerdict) continue;
          layout.rows.push_back(our_row(grids, kind, contestant.label, reading, quantity, measure));
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

Entry published_ratio(const RatioPair& pair, const Experiment& experiment, Quantity quantity,
                      PublishedSpread PublishedMeasurement::*part) {
  const auto top = published_span(pair.numerator_kind, experiment, pair.numerator.family, quantity);
  const auto bottom = published_span(pair.denominator_kind, experiment, pair.denominator.family, quantity);
  if (!top || !bottom) return {kAbsent, ""};
  return {number(((*top).*part).mean / ((*bottom).*part).mean), ""};
}

Entry our_ratio(const std::vector<Grid>& grids, const RatioPair& pair, const Experiment& experiment,
                const std::string& reading, Quantity quantity, Measure measure, PooledMean Span::*part) {
  const Grid* top = find_grid(grids, pair.numerator_kind, experiment, reading, pair.numerator.label);
  const Grid* bottom = find_grid(grids, pair.denominator_kind, experiment, reading, pair.denominator.label);
  if (top == nullptr || bottom == nullptr) return {"not run", ""};
  for (const Grid* side : {top, bottom}) {
    if (side->refused() > 0) return refused_entry(*side);
  }
  const RatioOfMeans ratio{span_of(*top, quantity, measure).*part, span_of(*bottom, quantity, measure).*part};
  if (std::isnan(ratio.value())) return {kAbsent, ""};
  return {number(ratio.value()), number(ratio.interval().low) + "–" + number(ratio.interval().high)};
}

void add_ratio_rows(const std::vector<Grid>& grids, const RatioPair& pair, Layout& layout) {
  const bool across = pair.numerator_kind != pair.denominator_kind;
  const std::string name = name_of_side(pair.numerator_kind, pair.numerator, across) + " / " +
                           name_of_side(pair.denominator_kind, pair.denominator, across);
  for (const Quantity quantity : {Quantity::kTimeSolved, Quantity::kTimeAll}) {
    std::vector<Entry> published{{name, ""}, {"published", ""}, {rows_words(quantity), ""}};
    for (const Experiment* experiment : experiment_six()) {
      published.push_back(published_ratio(pair, *experiment, quantity, &PublishedMeasurement::best));
      published.push_back(published_ratio(pair, *experiment, quantity, &PublishedMeasurement::all));
    }
    if (pair.numerator.family && pair.denominator.family) layout.rows.push_back(std::move(published));
    for (const char* reading : kReadings) {
      const bool run = has_reading(grids, pair.numerator_kind, pair.numerator.label, reading) &&
                       has_reading(grids, pair.denominator_kind, pair.denominator.label, reading);
      if (!run) continue;
      for (const Measure measure : kMeasures) {
        if (quantity == Quantity::kTimeAll && measure == Measure::kVerdict) continue;
        const std::string source =
            quantity == Quantity::kTimeAll ? reading : std::string(reading) + ", " + words_for(measure);
        std::vector<Entry> row{{name, ""}, {source, ""}, {rows_words(quantity), ""}};
        for (const Experiment* experiment : experiment_six()) {
          row.push_back(our_ratio(grids, pair, *experiment, reading, quantity, measure, &Span::best));
          row.push_back(our_ratio(grids, pair, *experiment, reading, quantity, measure, &Span::all));
        }
        layout.rows.push_back(std::move(row));
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
  return {{"count", spread.count},
          {"mean", number_json(spread.mean)},
          {"sigma", number_json(spread.sigma)},
          {"max", number_json(spread.max)}};
}

Json published_json(const std::optional<PublishedMeasurement>& published, PublishedSpread PublishedMeasurement::*part) {
  const double none = Proportion{}.value();
  const PublishedSpread spread = published ? (*published).*part : PublishedSpread{none, none, none};
  return {{"mean", number_json(spread.mean)}, {"sigma", number_json(spread.sigma)}, {"max", number_json(spread.max)}};
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
          for (const Measure measure : kMeasures) {
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

constexpr const char* kSolvedNote =
    "Solved by the paper’s criterion: claimed solved, normal violation below 1e-3 m/s and work gain below 1e-3 J; of "
    "all "
    "trials. By our verdict: every condition holds to 1e-4 relative; of the trials not proven unsolvable.";
constexpr const char* kBestNote =
    "Best: the parameterisation that solves the most even trials (the first of equals, in the order of settings), "
    "measured "
    "on the odd trials. All parameters: every trial of every parameterisation pooled.";

}  // namespace

std::string code(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '`' || c == '\n' || c == '\r'; }, '\'');
  return "`" + text + "`";
}

std::string points(double share) {
  if (std::isnan(share)) return kAbsent;
  const double value = 100 * share;
  if (value == 0 || value == 100) return fmt::format("{:.0f}", value);
  const std::string text = fmt::format("{:.2f}", value);
  if (text == "100.00") return ">99.99";
  if (text == "0.00") return "<0.01";
  return text;
}

std::string points(const Interval& interval) { return points(interval.low) + "–" + points(interval.high); }

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : kAbsent; }

std::string spread_text(double mean, double sigma, double max) {
  return number(mean) + " (" + number(sigma) + ") " + number(max);
}

Json number_json(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json share_json(const Proportion& share) {
  return {{"share", number_json(share.value())},
          {"low", number_json(share.interval().low)},
          {"high", number_json(share.interval().high)},
          {"of", number_json(share.trials > 0 ? share.trials : Proportion{}.value())}};
}

Table rates_table(const Summary& summary, const std::vector<Grid>& grids, Kind kind) {
  Table table;
  table.id = kind == Kind::kMonotone ? "IV.1" : "IV.2";
  table.title = std::string("Solution frequency, ") + name_of(kind) + " problems [%]";
  const auto plain = [](const Experiment& experiment) { return !experiment.regularized; };
  table.layouts = {
      rates_layout(summary, grids, kind, "Worst / average / best over the parameters. Experiments 1 to 5", plain),
      rates_layout(summary, grids, kind, "Worst / average / best over the parameters. Experiment 6, regularised",
                   is_experiment_six),
      chosen_layout(summary, grids, kind), robustness_layout(grids, kind)};
  table.notes = {
      kSolvedNote,
      "Small numbers: Wilson 95 % intervals of the shares of the worst and of the best cell, and the trials of each "
      "cell. "
      "They hold for a cell named beforehand. The best of many cells flatters and the worst belittles, so the third "
      "table "
      "chooses the best on the even trials and gives its interval on the odd ones, where no choice was made.",
      "In Experiment 6 the paper’s Lemke is `regularized{test=tried}`, whose test of an answer is the published one; "
      "`regularized` tests the answer on the problem itself. Redundancy: `multiple`, a redundant contact is a multiple "
      "of "
      "one other; `combination`, of all independent ones (`docs/reference/generators.md`)."};
  table.query = rates_query(kind);
  table.records = Json::array();
  for (const Experiment& experiment : experiments()) {
    const Picks same_part = [&experiment](const Experiment& other) {
      return other.regularized == experiment.regularized;
    };
    for (const Contestant& contestant : contestants(grids, kind, same_part, published_families(kind))) {
      for (const std::string& reading : readings_of(experiment)) {
        const Grid* grid = find_grid(grids, kind, experiment, reading, contestant.label);
        table.records.push_back(rates_record(summary, table.id, kind, experiment, reading, contestant, grid));
      }
    }
  }
  table.example = rates_record(summary, "", kind, experiments().front(), "", {Family::kLemke, ""}, nullptr);
  return table;
}

Table times_table(const Summary& summary, const std::vector<Grid>& grids, Kind kind) {
  const std::vector<Quantity> quantities{Quantity::kTimeSolved, Quantity::kTimeAll};
  Table table;
  table.id = kind == Kind::kMonotone ? "IV.3" : "IV.4";
  table.title = std::string("Running time of Experiment 6, ") + name_of(kind) + " problems [s]";
  table.layouts = {ratios_layout(grids, kind),
                   spreads_layout(summary, grids, kind, quantities, "Mean (sigma) maximum, in the paper’s layout")};
  table.notes = {kSolvedNote, kBestNote,
                 "Seconds of 2012 and of this machine stand in the same layout and are not compared: only the ratios "
                 "between solvers "
                 "are. Interval of a ratio: 95 %, delta method on its logarithm, the two means taken as independent, "
                 "each known as "
                 "well as its problems allow, however many parameterisations met them.",
                 "The paper’s Lemke is `regularized{test=tried}`: its test is the published one. `regularized` tests "
                 "on the problem "
                 "itself. Times are set-up plus solve, CPU. Parameterisations that answer a problem alike share a "
                 "time, the mean of theirs."};
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
