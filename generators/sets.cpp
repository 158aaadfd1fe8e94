#include "generators/sets.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <utility>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "core/suggestion.h"
#include "generators/changed.h"
#include "generators/hard/hard.h"
#include "generators/made/made.h"
#include "generators/paper/paper.h"
#include "generators/planted.h"
#include "generators/rest/rest.h"
#include "generators/rigid/rigid.h"
#include "generators/scenes/scenes.h"
#include "generators/to_problem.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFilePrefix = "file:";
constexpr const char* kChanged = "changed";
constexpr const char* kPaperSource =
    "Drumwright and Shell 2012, Extensive analysis of linear complementarity problem (LCP) solver performance on "
    "randomly generated rigid body contact problems";

std::uint64_t checked_trial(const std::string& set, std::int64_t trial, std::optional<std::int64_t> count) {
  if (trial < 0) throw InputError(set + ": trial " + std::to_string(trial) + ": expected 0 or more");
  if (count && trial >= *count) {
    throw InputError(set + ": trial " + std::to_string(trial) + ": the set has " + std::to_string(*count));
  }
  return static_cast<std::uint64_t>(trial);
}

std::string problem_name(const std::string& set, std::uint64_t seed, std::int64_t trial) {
  return set + " seed " + std::to_string(seed) + " trial " + std::to_string(trial);
}

Problem make_problem(const PaperSet& set, const PaperReading& reading, std::uint64_t seed, std::uint64_t trial,
                     std::string name) {
  const MatrixFormation formation{.plain_inverse = reading.inverse == InverseReading::kPlain,
                                  .cone_diagonal = reading.cone_diagonal};
  return {std::move(name), to_contact_problem(draw_paper(set, reading, seed, trial)), formation};
}

Problem make_problem(const RigidSet& set, const RigidReading& reading, std::uint64_t seed, std::uint64_t trial,
                     std::string name) {
  const RigidSample sample = draw_rigid(set, reading, seed, trial);
  if (sample.edges > 4) return {std::move(name), to_contact_problem(sample)};  // a scene has no such pyramid
  return {std::move(name), to_scene(sample)};
}

Problem make_problem(const MadeSet& set, const MadeReading& reading, std::uint64_t seed, std::uint64_t trial,
                     std::string name) {
  return {std::move(name), to_contact_problem(draw_made(set, reading, seed, trial))};
}

Problem make_problem(const RestSet& set, const RestReading& reading, std::uint64_t seed, std::uint64_t trial,
                     std::string name) {
  return {std::move(name), to_contact_problem(draw_rest(set, reading, seed, trial))};
}

Problem make_problem(const PlantedSet& set, const PlantedReading& reading, std::uint64_t seed, std::uint64_t trial,
                     std::string name) {
  const PlantedSample sample = draw_planted(set, reading, seed, trial);
  if (reading.form == PlantedForm::kLcp) return {std::move(name), to_lcp(sample)};
  return {std::move(name), to_contact_problem(sample)};
}

template <class Set>
class RandomSet final : public ProblemSet {
 public:
  RandomSet(const Set& set, const Options& options)
      : set_(set),
        reading_(set.parse(set.name, options)),
        name_(Spec{set.name, set.changed(set.name, options)}.text()) {}

  std::string name() const override { return name_; }
  Problem generate(std::uint64_t seed, std::int64_t trial) const override {
    const std::uint64_t index = checked_trial(name_, trial, std::nullopt);
    return make_problem(set_, reading_, seed, index, problem_name(name_, seed, trial));
  }

 private:
  const Set& set_;
  decltype(std::declval<Set>().parse("", {})) reading_;
  std::string name_;
};

/// A problem that a formula gives: one problem, the same for every seed.
class HardProblemSet final : public ProblemSet {
 public:
  HardProblemSet(const HardSet& set, const Options& options)
      : name_(Spec{set.name, set.changed(set.name, options)}.text()),
        problem_(to_problem(set.make(set.name, options), name_)) {}

  std::string name() const override { return name_; }
  Problem generate(std::uint64_t, std::int64_t trial) const override {
    checked_trial(name_, trial, count());
    return problem_;
  }
  std::optional<std::int64_t> count() const override { return 1; }

 private:
  static Problem to_problem(const HardCase& hard, const std::string& name) {
    if (hard.contact) return {name, to_contact_problem(*hard.contact)};
    return {name, to_lcp(hard)};
  }

  std::string name_;
  Problem problem_;
};

class ChangedSet final : public ProblemSet {
 public:
  explicit ChangedSet(const Options& options) : settings_(parse_settings<ChangedSettings>(kChanged, options)) {
    set_ = open_set(settings_.of);
    settings_.of = set_->name();
    name_ = Spec{kChanged, changed_settings(settings_)}.text();
  }

  std::string name() const override { return name_; }
  Problem generate(std::uint64_t seed, std::int64_t trial) const override {
    checked_trial(name_, trial, count());
    const DrawnChange change(settings_.by, settings_.of, seed, trial, settings_.draw);
    return change.apply(set_->generate(seed, trial), problem_name(name_, seed, trial));
  }
  std::optional<std::int64_t> count() const override { return set_->count(); }
  std::string note() const override { return set_->note(); }

 private:
  ChangedSettings settings_;
  std::unique_ptr<ProblemSet> set_;
  std::string name_;
};

// ---- files ----

// A folder may hold other files too. The second file of a Matrix Market pair is read with the first.
bool is_problem_file(const fs::path& path) {
  const std::string name = path.filename().string();
  if (name.starts_with('.')) return false;
  return name.ends_with(".json") || name.ends_with(".dat") || name.ends_with(".txt") || name.ends_with(".M.mtx");
}

std::vector<fs::path> problem_files(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (const auto step = scenes_step(path.string())) {
    ScenesFile(step->first).index_of(step->second);  // throws where there is none
    return {path};
  }
  if (!fs::exists(status)) throw InputError(path.string() + ": no such file or folder");
  if (!fs::is_directory(status)) return {path};
  std::vector<fs::path> files;
  fs::directory_iterator entries(path, error);
  if (error) throw InputError(path.string() + ": cannot be listed: " + error.message());
  for (const fs::directory_entry& entry : entries) {
    if (!is_problem_file(entry.path())) continue;
    if (!entry.exists(error)) throw InputError(entry.path().string() + ": a link to no file, or out of reach");
    if (entry.is_regular_file(error)) files.push_back(entry.path());
  }
  if (files.empty()) throw InputError(path.string() + ": no problem file (.json, .dat, .txt, .M.mtx) in this folder");
  std::sort(files.begin(), files.end());
  return files;
}

TimeStep time_step(SceneStep step) {
  TimeStep result{std::move(step.problem), {}, std::move(step.notes)};
  for (const std::string& id : step.contact_ids) result.contact_ids.push_back(contact_id(id));
  return result;
}

class FileSet final : public ProblemSet {
 public:
  explicit FileSet(const std::string& path) : name_(std::string(kFilePrefix) + path), files_(problem_files(path)) {}

  std::string name() const override { return name_; }
  Problem generate(std::uint64_t, std::int64_t trial) const override {
    return read_problem(files_[checked_trial(name_, trial, count())]);
  }
  TimeStep step(std::uint64_t seed, std::int64_t trial) const override {
    const auto captured = scenes_step(files_[checked_trial(name_, trial, count())].string());
    if (!captured) return ProblemSet::step(seed, trial);
    const ScenesFile scenes(captured->first);
    return time_step(scenes.read(scenes.index_of(captured->second)));
  }
  std::optional<std::int64_t> count() const override { return static_cast<std::int64_t>(files_.size()); }

 private:
  std::string name_;
  std::vector<fs::path> files_;
};

/// Captured steps: trial k is the k-th step of the file.
class ScenesSet final : public ProblemSet {
 public:
  ScenesSet(std::string name, std::shared_ptr<const ScenesFile> scenes)
      : name_(std::move(name)), scenes_(std::move(scenes)) {}
  ScenesSet(const CollectedScene& scene, const Options& options) : ScenesSet(scene.name, open_collected(scene)) {
    if (options.empty()) return;
    throw InputError(scene.name + ": unknown option '" + options.front().first + "': the set has none");
  }

  std::string name() const override { return name_; }
  Problem generate(std::uint64_t, std::int64_t trial) const override {
    return scenes_->read(checked_trial(name_, trial, count())).problem;
  }
  TimeStep step(std::uint64_t, std::int64_t trial) const override {
    return time_step(scenes_->read(checked_trial(name_, trial, count())));
  }
  bool follows(std::int64_t trial) const override {
    const std::uint64_t index = checked_trial(name_, trial, count());
    return index > 0 && scenes_->step_number(index) == scenes_->step_number(index - 1) + 1;
  }
  std::optional<std::int64_t> count() const override { return static_cast<std::int64_t>(scenes_->count()); }
  std::string engine() const override { return scenes_->header().engine_label(); }
  std::string note() const override { return scenes_->truncation(); }

 private:
  std::string name_;
  std::shared_ptr<const ScenesFile> scenes_;
};

std::unique_ptr<ProblemSet> open_files(const std::string& path) {
  if (!is_scenes_file(path)) return std::make_unique<FileSet>(path);
  return std::make_unique<ScenesSet>(std::string(kFilePrefix) + path, std::make_shared<ScenesFile>(path));
}

bool is_file_set(std::string_view text) { return text.starts_with(kFilePrefix); }

// ---- the list ----

std::string size_text(const PaperFeatures& features) {
  const std::string ngc = "ngc 6.." + std::to_string(features.ngc_max);
  const std::string nc = "nc 2.." + std::to_string(features.nc_max);
  if (!features.frictional) return ngc + ", " + nc + ", n = nc";
  return ngc + ", " + nc + ", edges 4..24, n = nc (edges + 2), at most " + std::to_string(26 * features.nc_max);
}

SetInfo describe(const PaperSet& set) {
  const std::string summary = (set.features.frictional ? "frictional: " : "frictionless: ") + set.summary;
  return {set.name, size_text(set.features), kPaperSource, summary, set.options()};
}

SetInfo describe(const RigidSet& set) {
  const bool frictional = set.features.frictional;
  return {set.name,
          std::string("1..4 bodies (ngc 6..24), nc 2..20, ") +
              (frictional ? "n = nc (edges + 2), at most 120 with 4 edges" : "n = nc"),
          "this project's: rigid bodies in place of the random matrices of " + std::string(kPaperSource),
          (frictional ? "frictional: " : "frictionless: ") + set.summary, set.options()};
}

SetInfo describe(const MadeSet& set) {
  return {set.name, "nc about 10.." + std::to_string(set.features.nc_max), "this project's",
          (set.features.held_out ? "held out of fits: " : "for fits: ") + set.summary, set.options()};
}

SetInfo describe(const RestSet& set) {
  return {set.name, "nc 3..200", "this project's", "rest by construction: " + set.summary, set.options()};
}

SetInfo describe(const PlantedSet& set) {
  return {set.name, "n 1..20, condition at most 1e4",
          "this project's; planting after Cottle, Pang and Stone 1992, The linear complementarity problem",
          "frictionless: " + set.summary, set.options()};
}

SetInfo describe(const HardSet& set) {
  return {set.name, set.size, set.source, set.summary + "; hard: " + set.hard, set.options()};
}

SetInfo describe(const CollectedScene& collected) {
  const ScenesFile& scenes = *open_collected(collected);
  const ScenesHeader& header = scenes.header();
  std::string summary = collected.name.starts_with(kHeldOutScenes) ? "held out of fits: " : "";
  summary += "captured: " + header.scene;
  if (header.step_length) summary += ", steps of " + format_real(*header.step_length) + " s";
  if (!header.loop.empty()) {
    summary += header.loop == "engine" ? ", moved on by the engine's solver" : ", moved on by " + header.loop;
  }
  return {collected.name,
          std::to_string(scenes.count()) + " captured steps",
          header.engine + " " + header.engine_version,
          summary,
          {}};
}

/// A set that has a name: how it is described and how it is opened.
struct NamedSet {
  std::string name;
  std::function<SetInfo()> describe;  ///< opens the captured steps
  std::function<std::unique_ptr<ProblemSet>(const Options&)> open;
};

template <class Opened, class Set>
void add_sets(const std::vector<Set>& sets, std::vector<NamedSet>& all) {
  for (const Set& set : sets) {
    all.push_back({set.name, [&set] { return describe(set); },
                   [&set](const Options& options) { return std::make_unique<Opened>(set, options); }});
  }
}

SetInfo describe_changed() {
  return {kChanged, "as in SET", "this project's",
          "the problems of another set, changed in a known way: changed{of=SET,by=order}",
          describe_settings<ChangedSettings>()};
}

/// In the order in which they are listed.
const std::vector<NamedSet>& named_sets() {
  static const std::vector<NamedSet> sets = [] {
    std::vector<NamedSet> all;
    add_sets<RandomSet<PaperSet>>(paper_sets(), all);
    add_sets<RandomSet<RigidSet>>(rigid_sets(), all);
    add_sets<RandomSet<MadeSet>>(made_sets(), all);
    add_sets<RandomSet<RestSet>>(rest_sets(), all);
    add_sets<RandomSet<PlantedSet>>(planted_sets(), all);
    add_sets<HardProblemSet>(hard_sets(), all);
    add_sets<ScenesSet>(collected_scenes(), all);
    all.push_back({kChanged, describe_changed,
                   [](const Options& options) { return std::make_unique<ChangedSet>(options); }});
    return all;
  }();
  return sets;
}

InputError no_such_set(const std::string& what, const std::string& name) {
  std::vector<std::string> known;
  for (const NamedSet& set : named_sets()) known.push_back(set.name);
  return InputError(what + " '" + name + "'" + did_you_mean(name, known) + "; `lcpbench sets` lists them");
}

}  // namespace

std::vector<SetInfo> list_sets() {
  std::vector<SetInfo> infos;
  for (const NamedSet& set : named_sets()) infos.push_back(set.describe());
  return infos;
}

std::unique_ptr<ProblemSet> open_set(const std::string& text) {
  if (is_file_set(text)) return open_files(text.substr(kFilePrefix.size()));
  const Spec spec = parse_spec(text);
  for (const NamedSet& set : named_sets()) {
    if (set.name == spec.name) return set.open(spec.options);
  }
  throw no_such_set("unknown problem set", spec.name);
}

bool glob_matches(std::string_view pattern, std::string_view text) {
  constexpr auto kNone = std::string_view::npos;
  std::size_t at = 0;
  std::size_t i = 0;
  std::size_t star = kNone;  // the last one met, which takes one character more at each retry
  std::size_t retry = 0;
  while (i < text.size()) {
    if (at < pattern.size() && pattern[at] == '*') {
      star = at++;
      retry = i;
    } else if (at < pattern.size() && (pattern[at] == '?' || pattern[at] == text[i])) {
      ++at;
      ++i;
    } else if (star != kNone) {
      at = star + 1;
      i = ++retry;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', at) == kNone;
}

std::vector<std::string> expand_sets(const std::string& pattern) {
  if (is_file_set(pattern)) return {open_set(pattern)->name()};
  const Spec spec = parse_spec(pattern);
  std::vector<std::string> names;
  if (spec.name == kChanged) {  // of may be a pattern
    const std::string of = parse_settings<ChangedSettings>(kChanged, spec.options).of;
    for (const std::string& name : expand_sets(of)) {
      Options options = spec.options;
      std::erase_if(options, [](const auto& option) { return option.first == "of"; });
      options.emplace_back("of", name);
      names.push_back(ChangedSet(options).name());
    }
    return names;
  }
  for (const NamedSet& set : named_sets()) {
    if (glob_matches(spec.name, set.name)) names.push_back(set.open(spec.options)->name());
  }
  if (names.empty()) throw no_such_set("no problem set matches", spec.name);
  return names;
}

}  // namespace lcpbench
