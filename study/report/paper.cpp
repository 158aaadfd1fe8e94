#include "study/report/paper.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "study/output/csv.h"
#include "study/paper/tables.h"
#include "study/report/figures.h"
#include "study/report/page.h"
#include "study/report/paper_writer.h"
#include "study/report/tables.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

using paper::Claim;
using paper::Comparison;
using paper::Entry;
using paper::Layout;
using paper::points;
using paper::Stance;

constexpr const char* kSource =
    "Published figures: E. Drumwright and D. A. Shell, “Extensive analysis of linear complementarity problem (LCP) "
    "solver performance on randomly generated rigid body contact problems”, IROS 2012.";

/// A member's distinct values over all runs, in the order of their first use.
std::string distinct_members(const Summary& summary, const char* name) {
  std::vector<std::string> values;
  for (const std::string& value : recorded_values(summary, name)) values.push_back(paper::code(value));
  return fmt::format("{}", fmt::join(values, ", "));
}

/// A command with the absolute paths in it cut down to their last part: folders of one machine repeat nothing
/// elsewhere.
std::string without_folders(const std::string& command) {
  const auto begins = [&command](std::size_t at) {
    return at == 0 || std::string_view(" '\"=:,").find(command[at - 1]) != std::string_view::npos;
  };
  std::string text;
  for (std::size_t at = 0; at < command.size(); ++at) {
    if (command[at] == '/' && begins(at)) {
      const bool quoted = at > 0 && (command[at - 1] == '\'' || command[at - 1] == '"');
      const std::size_t end = quoted ? command.find(command[at - 1], at) : command.find_first_of(" '\",{}", at);
      const std::size_t last = command.rfind('/', std::min(end, command.size()) - 1);
      at = last + 1;
      if (at >= command.size()) break;
    }
    text += command[at];
  }
  return text;
}

std::string provenance_line(const Summary& summary) {
  if (summary.runs.empty()) return "The store records no run.";
  const RunSummary& run = summary.runs.back();
  return fmt::format(
      "Runs in the store: {}, of lcpbench {} at commits {}, on processors {} at instruction-set levels {}, compilers "
      "{}, seeds {}. The latest, of {}, was: {}.",
      summary.runs.size(), distinct_members(summary, "lcpbench"), distinct_members(summary, "commit"),
      distinct_members(summary, "processor"), distinct_members(summary, "isa"), distinct_members(summary, "compiler"),
      distinct_members(summary, "seed"), paper::code(run.started),
      paper::code(without_folders(recorded_value(run, "command"))));
}

// --- claims ---

std::string quantity_text(const Comparison& comparison, double value) {
  if (!comparison.share) return paper::number(value);
  return std::isfinite(value) ? fmt::format("{:.2f}", 100 * value) : "–";
}

std::string interval_text(const Comparison& comparison) {
  if (!comparison.interval) return "no interval";
  const Interval interval = comparison.interval(paper::kZ95);
  return quantity_text(comparison, interval.low) + " to " + quantity_text(comparison, interval.high);
}

std::string bound_text(const Comparison& comparison) {
  if (comparison.within) {
    return "between " + quantity_text(comparison, comparison.bound) + " and " +
           quantity_text(comparison, *comparison.within);
  }
  return std::string(comparison.above ? "above " : "below ") + quantity_text(comparison, comparison.bound);
}

Layout comparisons_layout(const std::string& caption, const std::vector<Comparison>& comparisons) {
  Layout layout{caption, {"Compared", "Of", "Value", "Claimed", "Says"}, 2, {}};
  for (const Comparison& comparison : comparisons) {
    layout.rows.push_back({{comparison.what, comparison.detail},
                           {comparison.scope, ""},
                           {quantity_text(comparison, comparison.value), interval_text(comparison)},
                           {bound_text(comparison), ""},
                           {name_of(comparison.stance), ""}});
  }
  return layout;
}

/// Of the comparisons with a stance the one nearest to its bound, or the one farthest; nullptr for none.
const Comparison* extreme(const std::vector<Comparison>& comparisons, Stance stance, bool nearest) {
  const auto distance = [](const Comparison& c) {
    const auto from = [&c](double bound) {
      return c.share ? std::abs(c.value - bound) : std::abs(std::log(c.value / bound));
    };
    return c.within ? std::min(from(c.bound), from(*c.within)) : from(c.bound);
  };
  const Comparison* found = nullptr;
  for (const Comparison& comparison : comparisons) {
    if (comparison.stance != stance) continue;
    const bool better = found == nullptr ||
                        (nearest ? distance(comparison) < distance(*found) : distance(comparison) > distance(*found));
    if (better) found = &comparison;
  }
  return found;
}

std::string comparison_line(const Comparison& comparison) {
  return comparison.what + " (" + comparison.scope + "): " + quantity_text(comparison, comparison.value) + " [" +
         interval_text(comparison) + "], claimed " + bound_text(comparison);
}

std::size_t count(const std::vector<Comparison>& comparisons, Stance stance) {
  return static_cast<std::size_t>(std::count_if(comparisons.begin(), comparisons.end(),
                                                [stance](const Comparison& c) { return c.stance == stance; }));
}

Entry evidence_entry(const Claim& claim) {
  if (claim.comparisons.empty()) return {"needs " + claim.needs, ""};
  std::string text =
      fmt::format("{} of {} comparisons support it, {} oppose it.", count(claim.comparisons, Stance::kSupports),
                  claim.comparisons.size(), count(claim.comparisons, Stance::kOpposes));
  if (claim.word == paper::Word::kExplained) text += " " + claim.cause;
  std::string detail;
  if (const Comparison* weakest = extreme(claim.comparisons, Stance::kSupports, true)) {
    detail = "Weakest support: " + comparison_line(*weakest) + ".";
  }
  if (const Comparison* strongest = extreme(claim.comparisons, Stance::kOpposes, false)) {
    detail += (detail.empty() ? "" : " ") + std::string("Strongest against: ") + comparison_line(*strongest) + ".";
  }
  return {text, detail};
}

void write_claims(PaperWriter& writer, const Summary& summary, const PaperStudy& study) {
  writer.heading(1, "paper-claims", "The paper’s claims");
  writer.paragraph(
      "Each claim is tested by the rule that stands with it, on this store. A comparison supports or opposes its claim "
      "when its whole interval lies on one side of the bound (inside or outside of two bounds), at a level that keeps "
      "the chance of any wrong one within a claim below 5 % (Bonferroni). `confirmed`: some support, none opposes; "
      "`confirmed in part`: both; `contradicted`: some oppose, none supports; `explained`: confirmed as the paper "
      "measured, and every test of a named cause supports it; `undecided`: too few trials to tell. A claim whose rule "
      "says on every set is `confirmed` only when all comparisons support it; when none opposes, it is `confirmed in "
      "part` as long as at least half support it, else `undecided`.");
  writer.paragraph(
      "Values are shares and their differences in per cent, times and violations as ratios; in small print 95 % "
      "intervals. Parameterisations met the same problems, so a mean over them is taken to be known only as well as "
      "one value per problem allows. The terms of a difference are compared as independent samples although they "
      "mostly met the same problems: that makes intervals of differences wider than need be. It can make those of sums "
      "of like terms too narrow, which “far more” and the closed gap contain. Numbers: `tables/claims-paper.csv`.");
  for (const paper::Grid& grid : study.grids) {
    if (grid.refused() > 0) {
      writer.paragraph("Left out of every claim, because a refusal is no failure to solve: " + paper::code(grid.label) +
                       " on " + paper::code(summary.sets[grid.set].name) + ", " + grid.refusal() + ".");
    }
  }
  Layout layout{"Claims", {"Claim", "Result", "Evidence"}, 1, {}};
  for (const Claim& claim : study.claims) {
    layout.rows.push_back({{claim.statement, ""}, {name_of(claim.word), ""}, evidence_entry(claim)});
  }
  writer.table(layout);
  writer.query(paper::totals_query());
  for (const Claim& claim : study.claims) {
    writer.open(std::string(name_of(claim.word)) + ": " + claim.statement);
    writer.paragraph("Rule: " + claim.rule);
    if (claim.comparisons.empty()) writer.paragraph("Not tested: needs " + claim.needs + ".");
    if (!claim.comparisons.empty()) writer.table(comparisons_layout("Comparisons", claim.comparisons));
    if (!claim.explanation.empty()) writer.table(comparisons_layout("Cause: " + claim.cause, claim.explanation));
    if (!claim.beyond.empty()) {
      writer.table(comparisons_layout("Beside the claim, without part in its result", claim.beyond));
    }
    writer.close();
  }
}

// --- readings and what is not reproduced ---

Entry effect_entry(const paper::Proportion& with, const paper::Proportion& without) {
  const paper::LinearCombination change = paper::difference(with, without);
  if (std::isnan(change.value())) return {"–", ""};
  const Interval interval = change.interval();
  return {fmt::format("{:+.2f}", 100 * change.value()),
          fmt::format("{:+.2f} to {:+.2f}; {} → {}", 100 * interval.low, 100 * interval.high, points(without.value()),
                      points(with.value()))};
}

Layout readings_layout(const Summary& summary, const PaperStudy& study) {
  Layout layout{
      "Change of the share solved against the same set at its defaults [points], with 95 % interval; from → to",
      {"Set", "Solver", "Solved by", "Worst", "Average", "Best", "Best, held out"},
      3,
      {}};
  for (const paper::ReadingEffect& effect : study.readings) {
    layout.rows.push_back({{paper::code(summary.sets[effect.reading->set].name), ""},
                           {paper::code(effect.reading->label), ""},
                           {name_of(effect.measure), ""},
                           effect_entry(effect.with.worst, effect.without.worst),
                           effect_entry(effect.with.average, effect.without.average),
                           effect_entry(effect.with.best, effect.without.best),
                           effect_entry(effect.with.held_out, effect.without.held_out)});
  }
  return layout;
}

Layout missed_layout(const Summary& summary, const PaperStudy& study) {
  Layout layout{"Published numbers that are not reproduced",
                {"Set", "Paper’s solver", "Ours", "Number", "Published", "Ours [%]", "Difference [points]", "Known"},
                4,
                {}};
  for (const paper::Reproduction& row : study.reproductions) {
    if (row.agreement != paper::Agreement::kDiffers) continue;
    layout.rows.push_back({{paper::code(summary.sets[row.grid->set].name), ""},
                           {name_of(row.family), ""},
                           {paper::code(row.grid->label), ""},
                           {row.statistic, ""},
                           {points(row.published), ""},
                           {points(row.ours), ""},
                           {fmt::format("{:+.2f}", 100 * (row.ours - row.published)),
                            fmt::format("{:+.2f} to {:+.2f}", 100 * row.difference.low, 100 * row.difference.high)},
                           {row.explanation, ""}});
  }
  return layout;
}

void write_readings(PaperWriter& writer, const Summary& summary, const PaperStudy& study) {
  writer.heading(1, "paper-readings", "Open readings, and what is not reproduced");
  writer.paragraph(
      "The paper leaves details of its generators open. Each reading is an option of a set "
      "(`docs/reference/generators.md`); here is what it changes. Numbers: `tables/readings.csv`.");
  if (study.readings.empty()) writer.paragraph("No sweep on a set with an option off its default is in this store.");
  if (!study.readings.empty()) writer.table(readings_layout(summary, study));
  for (const paper::Family family : paper::kFamilies) {
    const bool run = std::any_of(study.grids.begin(), study.grids.end(),
                                 [family](const paper::Grid& grid) { return paper::family_of(grid.solver) == family; });
    if (!run) {
      writer.paragraph(std::string("Nothing of the paper’s ") + name_of(family) +
                       " is reproduced here: " + paper::why_not_run(summary, family) + ".");
    }
  }
  const auto rows_that = [&study](paper::Agreement agreement) {
    return std::count_if(study.reproductions.begin(), study.reproductions.end(),
                         [agreement](const paper::Reproduction& row) { return row.agreement == agreement; });
  };
  const auto missed = rows_that(paper::Agreement::kDiffers);
  writer.paragraph(fmt::format(
      "Published worst, average and best shares against ours by the paper’s criterion: {} of {} differ by more than "
      "{:.0f} point beyond the 95 % interval of the difference, in which both are samples, the paper’s of {:.0f} "
      "trials. {} more have too few trials to tell (half of the interval exceeds {:.0f} points). All are in "
      "`tables/reproduction.csv`.",
      missed, missed + rows_that(paper::Agreement::kReproduced), 100 * paper::kReproductionMargin,
      paper::kPublishedTrials, rows_that(paper::Agreement::kTooFewTrials), 100 * paper::kReproductionWidth));
  for (const paper::Grid& grid : study.grids) {
    const bool listed =
        std::any_of(study.reproductions.begin(), study.reproductions.end(), [&grid](const paper::Reproduction& row) {
          return row.grid == &grid && row.agreement == paper::Agreement::kRefused;
        });
    if (listed) {
      writer.paragraph("Not compared: " + paper::code(grid.label) + " on " + paper::code(summary.sets[grid.set].name) +
                       ", " + grid.refusal() + ".");
    }
  }
  if (missed > 0) {
    writer.open(fmt::format("The {} that differ", missed));
    writer.table(missed_layout(summary, study));
    writer.close();
  }
  writer.query(paper::rates_query(paper::Kind::kMonotone));
}

// --- tables and maps ---

void write_tables(PaperWriter& writer, const PaperStudy& study) {
  writer.heading(1, "paper-tables", "The paper’s tables");
  writer.paragraph(std::string(kSource) + " Ours stand beside them, both readings of redundancy.");
  for (const paper::Table& table : study.tables) {
    if (table.layouts.empty()) continue;
    writer.heading(2, "", "Table " + table.id + ": " + table.title);
    for (std::size_t i = 0; i < table.layouts.size(); ++i) {
      const bool first = i == 0;
      if (!first) writer.open(table.layouts[i].caption);
      writer.table(table.layouts[i]);
      if (!first) writer.close();
    }
    for (const std::string& note : table.notes) writer.paragraph(note);
    writer.paragraph("Unrounded: `tables/paper-" + table.id + ".csv`.");
    writer.query(table.query);
  }
  writer.paragraph("Times and violations of all experiments: `tables/paper-measurements.csv`.");
}

void write_maps(PaperWriter& writer, const Summary& summary, const PaperStudy& study) {
  if (study.maps.empty()) return;
  writer.heading(1, "tolerance-maps", "Tolerance maps");
  writer.paragraph(
      "The share solved over the two tolerances of Lemke’s algorithm, a field for each of the paper’s "
      "parameterisations. Numbers with intervals: `tables/tolerance-map.csv`.");
  for (const DrawnMap& drawn : study.maps) {
    writer.open(paper::code(summary.sets[drawn.map.grid->set].name) + ", " + paper::code(drawn.map.grid->label));
    writer.figure(drawn.file, drawn.figure);
    writer.close();
  }
  writer.query(paper::cells_query());
}

void write_study(PaperWriter& writer, const Summary& summary, const PaperStudy& study) {
  write_tables(writer, study);
  write_claims(writer, summary, study);
  write_readings(writer, summary, study);
  write_maps(writer, summary, study);
}

std::vector<DrawnMap> draw_maps(const Summary& summary, const std::vector<paper::Grid>& grids) {
  std::vector<DrawnMap> drawn;
  std::set<std::string> taken;
  for (paper::ToleranceMap& map : paper::tolerance_maps(summary, grids)) {
    const std::string stem = file_stem(summary.sets[map.grid->set].name + " " + map.grid->label);
    Figure figure = tolerance_figure(summary, map);
    drawn.push_back({std::move(map), figure_file("tolerance-" + stem, ".svg", taken), std::move(figure)});
  }
  return drawn;
}

}  // namespace

PaperStudy paper_study(const Summary& summary) {
  PaperStudy study;
  study.grids = paper::grids(summary);
  if (study.empty()) return study;
  for (const auto& table : {paper::rates_table, paper::times_table, paper::violations_table}) {
    for (const paper::Kind kind : paper::kKinds) study.tables.push_back(table(summary, study.grids, kind));
  }
  study.tables.push_back(paper::measurements_table(summary, study.grids));
  study.claims = paper::test_claims(summary, study.grids);
  study.readings = paper::reading_effects(study.grids);
  study.reproductions = paper::reproductions(study.grids);
  study.maps = draw_maps(summary, study.grids);
  return study;
}

std::string paper_sections(const Summary& summary, const PaperStudy& study) {
  if (study.empty()) return "";
  PaperWriter writer(PaperWriter::Format::kHtml);
  write_study(writer, summary, study);
  return "<section id=\"paper\">\n" + writer.text() + "</details>\n</section>\n";
}

std::map<std::string, std::string> paper_files(const Summary& summary, const PaperStudy& study) {
  std::map<std::string, std::string> files;
  if (study.empty()) return files;
  for (const paper::Table& table : study.tables) {
    files["tables/paper-" + table.id + ".csv"] = csv_table(table.example, table.records);
  }
  files["tables/claims-paper.csv"] = csv_table(paper::claims_json({Claim{}}).at(0), paper::claims_json(study.claims));
  files["tables/readings.csv"] = csv_table(paper::readings_example(), paper::readings_json(summary, study.readings));
  files["tables/reproduction.csv"] =
      csv_table(paper::reproductions_example(), paper::reproductions_json(summary, study.reproductions));
  std::vector<paper::ToleranceMap> maps;
  for (const DrawnMap& drawn : study.maps) {
    maps.push_back(drawn.map);
    files[drawn.file] = drawn.figure.svg;
  }
  files["tables/tolerance-map.csv"] =
      csv_table(paper::tolerance_maps_example(), paper::tolerance_maps_json(summary, maps));
  PaperWriter writer(PaperWriter::Format::kMarkdown);
  writer.heading(0, "", "The study of Drumwright and Shell (2012), repeated");
  writer.paragraph(provenance_line(summary));
  write_study(writer, summary, study);
  files["paper.md"] = writer.text();
  return files;
}

}  // namespace lcpbench::report
