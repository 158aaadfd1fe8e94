#include "study/commands/problem_files.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <utility>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "generators/scenes/scenes.h"
#include "generators/sets.h"
#include "study/commands/commands.h"
#include "study/evaluation/bounded_row_states.h"

namespace lcpbench {
namespace {

/// Says on a terminal what takes seconds where there are a million contacts.
auto read_visibly(const std::string& name, auto&& read) {
  ProgressLine line;
  if (line.is_on_terminal()) line.show("reading " + name);
  return interruptibly(read);
}

/// "SET#12" as a set and a number; nullopt for what names a file, or no set.
std::optional<std::pair<std::string, std::int64_t>> trial_of_set(const std::string& name) {
  const std::size_t mark = name.rfind('#');
  if (mark == std::string::npos || std::filesystem::exists(name)) return std::nullopt;
  std::int64_t trial = 0;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data() + mark + 1, end, trial);
  if (error != std::errc() || stop != end || trial < 0) return std::nullopt;
  const std::string set = name.substr(0, mark);
  try {
    expand_sets(set.substr(0, set.find('{')));
  } catch (const InputError&) {
    return std::nullopt;
  }
  return std::pair(set, trial);
}

}  // namespace

std::optional<NamedStep> named_step(const std::string& name) {
  if (const auto of_set = trial_of_set(name)) {
    const auto collected = std::ranges::find(collected_scenes(), of_set->first, &CollectedScene::name);
    if (collected == collected_scenes().end()) return std::nullopt;
    return NamedStep{open_collected(*collected), of_set->second};
  }
  static std::map<std::string, std::shared_ptr<const ScenesFile>> opened;
  const auto place = scenes_step(name);
  if (!place) return std::nullopt;
  std::shared_ptr<const ScenesFile>& scenes = opened[place->first];
  if (scenes == nullptr) scenes = std::make_shared<ScenesFile>(place->first);
  return NamedStep{scenes, place->second};
}

Problem read_named_problem(const std::string& name) {
  constexpr std::uint64_t kSeed = 1;
  if (const auto step = named_step(name)) return step->read().problem;
  if (const auto of_set = trial_of_set(name)) return open_set(of_set->first)->generate(kSeed, of_set->second);
  return read_problem(name);
}

int examine_problem_files(const std::vector<std::string>& files, bool json, const Examine& examine) {
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  Json rows = Json::array();
  bool complete = true;
  const auto guarded = [&](auto&& act) {
    try {
      act();
    } catch (const InputError& error) {
      complete = false;
      say(stderr, "lcpbench: {}\n", error.what());
    }
    std::fflush(stdout);  // an interrupt while the next is read loses nothing
  };
  const auto examine_steps = [&](const std::string& file) {
    const ScenesFile scenes = interruptibly([&] { return ScenesFile(file); });
    if (!scenes.truncation().empty()) say(stderr, "lcpbench: {}\n", printable(scenes.truncation()));
    for (std::size_t i = 0; i < scenes.count() && *stop == 0; ++i) {
      guarded([&] {
        const std::string name = fmt::format("{}#{}", file, scenes.step_number(i));
        examine(read_visibly(name, [&] { return scenes.read(i); }).problem, name, rows);
      });
    }
  };
  for (const std::string& file : files) {
    if (*stop != 0) break;
    guarded([&] {
      if (is_scenes_file(file)) return examine_steps(file);
      examine(read_visibly(file, [&] { return read_named_problem(file); }), file, rows);
    });
  }
  if (json) print_json(rows);
  if (*stop != 0) return kExitInterrupted;
  return complete ? kExitDone : kExitBadInput;
}

std::vector<std::string> contact_names(const std::string& file) {
  const auto step = named_step(file);
  return step ? step->read().contact_ids : std::vector<std::string>();
}

Spec judged_as_solved(Spec spec, const Problem& problem, const std::string& file) {
  const ContactProblem* contact = problem.contact();
  const auto names_model = [](const auto& option) { return option.first == "model"; };
  if (spec.name != "engine" || contact == nullptr || contact->compliance_t.size() == 0) return spec;
  if (std::ranges::any_of(spec.options, names_model)) return spec;
  const auto step = named_step(file);
  if (!step || step->scenes->header().engine != "MuJoCo") return spec;
  spec.options.emplace_back("model", to_string(FrictionModel::kConvex));
  return spec;
}

Json errors_json(const Problem& problem, const Errors& errors) {
  Json json = Json::object();
  for (const Metric& metric : kMetrics) json[metric.name] = json_number(errors.*metric.value);
  json["worst_row"] = errors.worst.row < 0 ? Json() : Json(errors.worst.row);
  json["worst_bounded_row"] = nullptr;
  if (const auto& [row, residual] = errors.worst_bounded_row; row >= 0) {
    json["worst_bounded_row"] = {{"row", row},
                                 {"residual", json_number(residual)},
                                 {"unit", velocity_unit(problem.contact()->rows, row)}};
  }
  return json;
}

std::string few_numbers(const Vector& numbers) {
  constexpr Index kMost = 12;
  return numbers.size() <= kMost ? fmt::format("{:.6g}", fmt::join(numbers, " ")) : "";
}

std::string problem_summary_text(const Problem& problem, const std::string& file) {
  std::string text = fmt::format("{}: {}, n {}", printable(file), to_string(problem.kind()), problem.size());
  if (const ContactProblem* contact = problem.contact()) {
    text += fmt::format(", {}, {}, {}", counted_noun(static_cast<std::size_t>(contact->ngc()), "coordinate"),
                        counted_noun(static_cast<std::size_t>(contact->nc()), "contact"),
                        counted_noun(static_cast<std::size_t>(cols(contact->D)), "friction edge"));
    if (contact->has_rows()) {
      text += ", " + counted_noun(static_cast<std::size_t>(contact->rows.size()), "bounded row");
    }
  } else if (const LcpBounds& bounds = problem.lcp().bounds; problem.lcp().is_mixed()) {
    std::size_t free = 0, friction = 0;
    for (Index i = 0; i < problem.size(); ++i) {
      if (bounds.is_free(i)) ++free;
      if (bounds.friction_of[static_cast<std::size_t>(i)] >= 0) ++friction;
    }
    text += fmt::format(", mixed: {}, {}", counted_noun(free, "free unknown"), counted_noun(friction, "friction row"));
    if (friction > 0) text += " (box friction, a model of its own)";
  }
  return text;
}

}  // namespace lcpbench
