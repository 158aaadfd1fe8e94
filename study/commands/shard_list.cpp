#include "study/commands/shard_list.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "study/commands/commands.h"
#include "study/output/json_output.h"
#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/run/shards.h"
#include "study/store/store.h"

namespace lcpbench {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMegabyte = 1 << 20;
constexpr double kMemoryMargin = 1.5;  // over the pilot's peak: larger problems may come

std::int64_t cells_in(const Study& study, const std::string& pattern, std::int64_t shard) {
  const std::size_t place = pattern.find("{}");
  if (place == std::string::npos) return 0;
  std::string file = pattern;
  file.replace(place, 2, std::to_string(shard));
  if (!std::filesystem::exists(file)) return 0;
  Store store = Store::open_for_reading(file);
  return done_cells(study, store.database());
}

/// "1-3,7": numbers as `sbatch --array` takes them.
std::string ranges(const std::vector<std::int64_t>& numbers) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ",", numbers[i]);
    if (last > i) text += fmt::format("-{}", numbers[last]);
    i = last + 1;
  }
  return text;
}

struct List {
  std::vector<ShardEstimate> shards;
  std::vector<std::int64_t> done;        ///< cells, by shard
  std::vector<std::int64_t> unfinished;  ///< from 1
  bool measured = false;
  std::int64_t minutes = 0;    ///< that the dearest unfinished shard takes at most; 0: not known
  std::int64_t megabytes = 0;  ///< 0: not known
};

List make_list(const Study& study, const ShardListOptions& options) {
  List list;
  list.shards = estimate_shards(study, options.shards);
  list.measured = !study.costs.cells.empty();
  double longest = 0;
  for (std::int64_t i = 0; i < options.shards; ++i) {
    const ShardEstimate& shard = list.shards[static_cast<std::size_t>(i)];
    list.done.push_back(std::min(shard.cells, cells_in(study, options.stores, i + 1)));
    if (list.done.back() == shard.cells) continue;
    list.unfinished.push_back(i + 1);
    longest = std::max(longest, shard.processor_s + shard.error_s);
  }
  if (list.measured) list.minutes = 1 + static_cast<std::int64_t>(std::ceil(longest / 60 / options.jobs));
  const double threads = std::max(1.0, static_cast<double>(options.jobs) / study.costs.jobs);
  list.megabytes = static_cast<std::int64_t>(std::ceil(kMemoryMargin * threads * study.costs.memory_bytes / kMegabyte));
  return list;
}

Json to_json(const List& list, const Study& study, const ShardListOptions& options) {
  const auto known = [](bool is_known, auto value) { return is_known ? Json(value) : Json(); };
  Json shards = Json::array();
  for (std::size_t i = 0; i < list.shards.size(); ++i) {
    const ShardEstimate& shard = list.shards[i];
    shards.push_back({{"shard", fmt::format("{}/{}", i + 1, options.shards)},
                      {"problems", shard.problems},
                      {"cells", shard.cells},
                      {"done", list.done[i]},
                      {"processor_s", known(list.measured, shard.processor_s)},
                      {"error_s", known(list.measured, shard.error_s)},
                      {"cells_not_measured", shard.not_measured}});
  }
  return {{"array", ranges(list.unfinished)},
          {"minutes", known(list.measured, list.minutes)},
          {"megabytes", known(list.megabytes > 0, list.megabytes)},
          {"jobs", options.jobs},
          {"overhead", known(study.costs.overhead > 0, study.costs.overhead)},
          {"shards", std::move(shards)}};
}

std::string cost_text(double seconds, double error) {
  return fmt::format("{} +- {}", format_seconds(seconds), format_seconds(error));
}

std::string to_text(const List& list, const Study& study, const ShardListOptions& options) {
  ShardEstimate all;
  for (const ShardEstimate& shard : list.shards) {
    all.problems += shard.problems;
    all.cells += shard.cells;
    all.processor_s += shard.processor_s;
    all.not_measured += shard.not_measured;
  }
  const auto [least, most] =
      std::minmax_element(list.shards.begin(), list.shards.end(),
                          [](const auto& a, const auto& b) { return a.processor_s < b.processor_s; });
  std::string text = fmt::format("{} of {} problems, {} cells\n",
                                 counted_noun(list.shards.size(), "shard"), format_count(all.problems),
                                 format_count(all.cells));
  if (list.measured) {
    text += fmt::format("processor time: {} in all; the cheapest shard {}, the dearest {} (two standard deviations)\n",
                        format_seconds(all.processor_s), cost_text(least->processor_s, least->error_s),
                        cost_text(most->processor_s, most->error_s));
    if (study.costs.overhead == 0) {
      text += "the run that was measured did not end: this is the time of solvers and verification alone\n";
    }
    if (all.not_measured > 0) {
      text += fmt::format("{} cells are not in it: nobody measured their solver on their set\n",
                          format_count(all.not_measured));
    }
    text += fmt::format("time limit of a shard with {}: {} minutes\n",
                        counted_noun(static_cast<std::size_t>(options.jobs), "thread"), list.minutes);
    if (list.megabytes > 0) text += fmt::format("memory of a shard: {} MB\n", format_count(list.megabytes));
  } else {
    text += "their cost is not known: measure a small run of the plan, and give its store as --costs\n";
  }
  return text + fmt::format("shards to run: {}\n", list.unfinished.empty() ? "none" : ranges(list.unfinished));
}

std::string every_shard(const List& list) {
  TextTable table({{"shard"}, {"problems"}, {"cells"}, {"done"}, {"processor time"}});
  for (std::size_t i = 0; i < list.shards.size(); ++i) {
    const ShardEstimate& shard = list.shards[i];
    table.add_row({std::to_string(i + 1), format_count(shard.problems), format_count(shard.cells),
                   format_count(list.done[i]),
                   list.measured ? cost_text(shard.processor_s, shard.error_s) : "not known"});
  }
  return table.text() + "\n";
}

}  // namespace

int list_shards(const Study& study, const ShardListOptions& options) {
  const List list = make_list(study, options);
  if (options.json) {
    print_json(to_json(list, study, options));
  } else {
    say(stdout, "{}{}", options.every ? every_shard(list) : "", to_text(list, study, options));
  }
  return kExitDone;
}

}  // namespace lcpbench
