#include "study/commands/solve_total.h"

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/statistics/statistics.h"

namespace lcpbench {

void SolveTotal::add(const std::string& solver, const std::string& label, const std::string& file, Claim claim,
                     Verdict verdict, double error, double time_s) {
  auto row = std::ranges::find_if(rows_, [&](const Row& each) { return each.solver == solver && each.label == label; });
  if (row == rows_.end()) row = rows_.insert(row, Row{.solver = solver, .label = label});
  if (claim == Claim::kUnsupported) return;
  ++row->taken;
  row->times.push_back(time_s);
  row->solved += verdict == Verdict::kSolved;
  row->unsolvable += verdict == Verdict::kUnsolvable;
  row->wrong += verdict == Verdict::kWrong;
  row->missed += verdict == Verdict::kMissed || verdict == Verdict::kOpen;
  if (verdict == Verdict::kSolved || verdict == Verdict::kUnsolvable) return;
  const report::Failure failure{verdict == Verdict::kWrong, error};
  if (!row->worst_file.empty() && !failure.worse_than(row->worst)) return;
  row->worst = failure;
  row->worst_file = file;
}

std::string SolveTotal::text(int width) const {
  if (problems_ < 2 || rows_.empty()) return "";
  std::vector<Row> rows = rows_;
  for (Row& row : rows) std::sort(row.times.begin(), row.times.end());
  const auto time = [](const Row& row) { return row.times.empty() ? kInfinity : median(row.times); };
  std::ranges::stable_sort(rows, {}, [&](const Row& row) { return std::tuple(-row.solved, row.wrong, time(row)); });
  TextTable table({{counted_noun(static_cast<std::size_t>(problems_), "problem"), TextTable::Align::kLeft, 0, 14},
                   {"solved"},
                   {"unsolvable", TextTable::Align::kRight, 2},
                   {"wrong"},
                   {"not solved"},
                   {"not taken"},
                   {"median time", TextTable::Align::kRight, 1}});
  std::string commands;
  for (const Row& row : rows) {
    table.add_row({row.label, format_count(row.solved), format_count(row.unsolvable),
                   format_count(row.wrong), format_count(row.missed), format_count(problems_ - row.taken),
                   format_seconds(time(row))});
    if (row.worst_file.empty()) continue;
    commands += report::command_text(
        fmt::format("lcpbench solve {} --solver {}", shell_word(file_argument(row.worst_file)),
                    shell_word(row.solver)),
        row.worst.text(), width);
  }
  return table.text(width) +
         (commands.empty() ? "" : "each solver's worst problem:\n" + commands);
}

}  // namespace lcpbench
