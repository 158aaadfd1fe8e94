#include "study/report/text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/output/text_table.h"

namespace lcpbench::report {

namespace {

constexpr std::size_t kSetsOnTheTerminal = 4;
constexpr const char* kUnknown =
    "How much of its plan this store covers is not known: a run in it recorded no plan, as runs of earlier versions "
    "did not.";

std::string cells_text(const Coverage& coverage) {
  return fmt::format("{} of {} cells", format_count(coverage.done), format_count(coverage.planned));
}

/// "these 3 sets are thin"
std::string thin_words(std::size_t thin, std::size_t sets) {
  return thin == sets && sets > 1 ? fmt::format("all {} sets are thin", sets)
         : thin == 1              ? "this set is thin"
                                  : fmt::format("these {} sets are thin", thin);
}

std::string left_out_text(const Coverage& coverage) {
  std::string text;
  for (const auto& [line, missing] : coverage.left_out) {
    text += fmt::format("{} planned cells are missing, and not failures, since a run left out {}\n",
                        format_count(missing), line);
  }
  return text;
}

}  // namespace

std::string plan_share_text(double share) {
  if (std::isnan(share)) return "–";
  const auto whole = static_cast<int>(std::floor(100 * share));
  return whole == 0 && share > 0 ? "<1 %" : fmt::format("{} %", whole);
}

std::string coverage_text(const Coverage& coverage) {
  if (!coverage.known) return std::string(kUnknown) + "\n";
  if (!coverage.incomplete()) return "";
  std::string text =
      fmt::format("INCOMPLETE: {} of the plan ({})", plan_share_text(coverage.share()), cells_text(coverage));
  const std::string remedy =
      left_out_text(coverage) +
      "To complete it, repeat the lcpbench run that wrote it; where it was run in shards, merge their stores.\n";
  const std::vector<Coverage::Set> thin = coverage.thin_sets();
  if (thin.empty()) return text + "\n" + remedy;
  text += fmt::format("; {}:\n", thin_words(thin.size(), coverage.sets.size()));
  const std::size_t shown = thin.size() <= kSetsOnTheTerminal ? thin.size() : kSetsOnTheTerminal - 1;
  for (std::size_t i = 0; i < shown; ++i) {
    text += fmt::format("  {:>5}  {}\n", plan_share_text(thin[i].share()), mended(thin[i].name));
  }
  if (shown < thin.size()) text += fmt::format("  and {} more sets\n", thin.size() - shown);
  return text + remedy;
}

}  // namespace lcpbench::report
