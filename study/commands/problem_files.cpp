#include "study/commands/problem_files.h"

#include <map>

#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "study/commands/commands.h"

namespace lcpbench {

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
        examine(interruptibly([&] { return scenes.read(i); }).problem,
                fmt::format("{}#{}", file, scenes.step_number(i)), rows);
      });
    }
  };
  for (const std::string& file : files) {
    if (*stop != 0) break;
    guarded([&] {
      if (is_scenes_file(file)) return examine_steps(file);
      examine(interruptibly([&] { return read_problem(file); }), file, rows);
    });
  }
  if (json) print_json(rows);
  if (*stop != 0) return kExitInterrupted;
  return complete ? kExitDone : kExitBadInput;
}

std::vector<std::string> contact_names(const std::string& file) {
  static std::map<std::string, ScenesFile> opened;
  const auto place = scenes_step(file);
  if (!place) return {};
  const ScenesFile& scenes = opened.try_emplace(place->first, place->first).first->second;
  return scenes.read(scenes.index_of(place->second)).contact_ids;
}

Json errors_json(const Errors& errors) {
  Json json = Json::object();
  for (const Metric& metric : kMetrics) json[metric.name] = json_number(errors.*metric.value);
  json["worst_row"] = errors.worst.row < 0 ? Json() : Json(errors.worst.row);
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
  }
  return text;
}

}  // namespace lcpbench
