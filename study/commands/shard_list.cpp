#include "study/commands/shard_list.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include <fmt/format.h>

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

std::int64_t cells_in(const Study& study, std::string file, std::int64_t shard) {
  const std::size_t place = file.find("{}");
  if (place == std::string::npos) return 0;
  file.replace(place, 2, std::to_string(shard));
  return std::filesystem::exists(file) ? done_cells(study, Store::open_for_reading(file).database()) : 0;
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

std::string cost_text(const ShardEstimate& shard) {
  return fmt::format("{} +- {}", format_seconds(shard.processor_s), format_seconds(shard.error_s));
}

}  // namespace

void list_shards(const Study& study, std::int64_t shards, const std::string& stores, int jobs, bool json, bool every) {
  const std::vector<ShardEstimate> estimates = estimate_shards(study, shards);
  Json rows = Json::array();
  TextTable table({{"shard"}, {"cells"}, {"done"}, {"processor time"}});
  std::vector<std::int64_t> unfinished;
  std::int64_t cells = 0;
  double processor_s = 0;
  double longest_s = 0;
  for (const ShardEstimate& shard : estimates) {
    const std::int64_t number = std::ssize(rows) + 1;
    const std::int64_t done = std::min(shard.cells, cells_in(study, stores, number));
    rows.push_back({{"cells", shard.cells},
                    {"done", done},
                    {"processor_s", shard.processor_s},
                    {"error_s", shard.error_s}});
    table.add_row({std::to_string(number), format_count(shard.cells), format_count(done), cost_text(shard)});
    cells += shard.cells;
    processor_s += shard.processor_s;
    if (done == shard.cells) continue;
    unfinished.push_back(number);
    longest_s = std::max(longest_s, shard.processor_s + shard.error_s);
  }
  const auto minutes = 1 + static_cast<std::int64_t>(std::ceil(longest_s / 60 / jobs));
  const double threads = std::max(1.0, static_cast<double>(jobs) / study.costs.jobs);
  const auto megabytes =
      static_cast<std::int64_t>(std::ceil(kMemoryMargin * threads * study.costs.memory_bytes / kMegabyte));
  if (json) {
    print_json(Json{
        {"array", ranges(unfinished)}, {"minutes", minutes}, {"megabytes", megabytes}, {"shards", std::move(rows)}});
    return;
  }
  const auto [least, most] = std::minmax_element(
      estimates.begin(), estimates.end(), [](const auto& a, const auto& b) { return a.processor_s < b.processor_s; });
  say(stdout,
      "{}{} of {} cells\n"
      "processor time: {} in all; the cheapest shard {}, the dearest {} (two standard deviations)\n"
      "time limit of a shard with {}: {} minutes\n"
      "memory of a shard: {} MB\n"
      "shards to run: {}\n",
      every ? table.text() + "\n" : "", counted_noun(estimates.size(), "shard"), format_count(cells),
      format_seconds(processor_s), cost_text(*least), cost_text(*most),
      counted_noun(static_cast<std::size_t>(jobs), "thread"), minutes, format_count(megabytes),
      unfinished.empty() ? "none" : ranges(unfinished));
}

}  // namespace lcpbench
