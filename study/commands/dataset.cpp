#include <algorithm>
#include <fstream>

#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "core/io/whole_file.h"
#include "core/islands.h"
#include "generators/made/made.h"
#include "generators/scenes/scenes.h"
#include "generators/sets.h"
#include "study/certificates/judge.h"
#include "study/commands/commands.h"
#include "study/output/csv.h"
#include "study/run/build_info.h"
#include "study/run/open_solver.h"

namespace lcpbench {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSeed = 1;
constexpr double kTimeLimitS = 10;  // wall clock, of each solve: a few problems of the made sets would take minutes

struct DatasetArguments {
  std::string folder;
  std::string set = "*";
  std::int64_t made = 10'000;
  std::int64_t contacts = 300;
};

/// What is known of a problem without solving it.
Json features(const Problem& problem) {
  const ContactProblem& contacts = *problem.contact();
  const std::vector<Island> islands = find_islands(contacts);
  std::size_t largest = 0;
  for (const Island& island : islands) largest = std::max(largest, island.contacts.size());
  const auto rough = std::count_if(contacts.mu.begin(), contacts.mu.end(), [](double mu) { return mu > 0; });
  const auto offsets = std::count_if(contacts.b.begin(), contacts.b.end(), [](double b) { return b != 0; });
  const bool any = contacts.nc() > 0;
  return {{"name", problem.name()},
          {"hash", problem_hash(problem)},
          {"contacts", contacts.nc()},
          {"with_friction", rough},
          {"with_offset", offsets},
          {"bounded_rows", contacts.rows.size()},
          {"mu_least", any ? Json(contacts.mu.minCoeff()) : Json()},
          {"mu_largest", any ? Json(contacts.mu.maxCoeff()) : Json()},
          {"coordinates", contacts.ngc()},
          {"rows", problem.size()},
          {"islands", islands.size()},
          {"contacts_of_largest_island", largest}};
}

/// The folder's files, as they grow.
class Dataset {
 public:
  explicit Dataset(const fs::path& folder) : folder_(folder), solver_(open_solver(parse_spec("auto{impulses=even}"))) {
    for (const char* part : {"scenes", "answers"}) make_folder(folder / part);
  }

  /// Solves the problems of a scenes file that is there, and adds their rows. @returns how many there are
  void add(const std::string& set, const std::string& stem, const ScenesFile& scenes, bool held_out,
           const volatile std::sig_atomic_t* stop) {
    WholeFile out(folder_ / "answers" / (stem + ".jsonl"));
    std::ofstream file(out.draft(), std::ios::binary | std::ios::trunc);
    for (std::size_t i = 0; i < scenes.count() && *stop == 0; ++i) {
      const Problem problem = scenes.read(i).problem;
      Json row{{"set", set},
               {"file", "scenes/" + stem + ".scenes"},
               {"step", scenes.step_number(i)},
               {"held_out", held_out}};
      row.update(features(problem));
      const Json answer = solved(problem);
      for (const char* key : {"verdict", "residual", "certificate", "velocity_unique", "impulses"}) row[key] = answer[key];
      file << Json{{"step", scenes.step_number(i)}, {"answer", answer}}.dump() << '\n';
      rows_.push_back(std::move(row));
    }
    if (!file.flush()) throw InputError(out.place().string() + ": cannot be written");
    out.commit();
  }

  void write_table() const { write("features.csv", csv_table(rows_)); }
  void write(const std::string& name, std::string_view text) const {
    WholeFile out(folder_ / name);
    out.write(text);
    out.commit();
  }
  std::size_t count() const { return rows_.size(); }
  std::size_t even() const {
    return static_cast<std::size_t>(
        std::count_if(rows_.begin(), rows_.end(), [](const Json& row) { return row["impulses"] == "even"; }));
  }
  std::size_t solved() const {
    return static_cast<std::size_t>(
        std::count_if(rows_.begin(), rows_.end(), [](const Json& row) { return row["verdict"] == "solved"; }));
  }

 private:
  Json solved(const Problem& problem) {
    TimedAnswer timed;
    solver_->run(problem, {.time_limit_s = kTimeLimitS}, timed);
    Judge judge(problem, certifier_);
    const Judgement& judgement = judge.judgement(judge.judge(timed.answer));
    std::optional<Certificate> proven = judge.certificate();
    if (!proven) proven = certifier_.certify(problem);
    Vector velocity = timed.answer.velocity;
    if (velocity.size() == 0 && judgement.errors.usable)
      velocity = post_impact_velocity(*problem.contact(), timed.answer.z);
    return {{"claim", to_string(timed.answer.claim)},
            {"verdict", to_string(verdict(timed.answer.claim, judgement.errors, judge.findings().truth()))},
            {"residual", json_number(judgement.errors.velocity_residual_relative)},
            {"certificate", proven ? Json(to_string(proven->kind)) : Json()},
            {"velocity_unique", proven ? json_optional(proven->velocity_unique) : Json()},
            {"impulses", to_string(timed.answer.impulses)},
            {"z", json_vector(timed.answer.z, judgement.errors.usable)},
            {"velocity", json_vector(velocity)}};
  }

  fs::path folder_;
  std::unique_ptr<TimedSolver> solver_;
  BoundedCertifier certifier_;
  Json rows_ = Json::array();
};

constexpr std::string_view kCard = R"(# Contacts of robots and rigid bodies, with verified answers

{count} time steps of contact problems: {captured} captured from physics engines (ODE, Bullet, DART, MuJoCo), and {made}
made by lcpbench {version}, seed {seed}, with at most {contacts} contacts aimed at.

| file | has |
| --- | --- |
| `scenes/*.scenes` | the problems: JSON lines, compressed by zstd (format: docs/reference/scenes-file.md of lcpbench) |
| `answers/*.jsonl` | for each step: impulses `z` (f_N, f_D, lambda, then f_R of bounded rows) and which they are, velocity after the step, verdict |
| `features.csv` | a row for each step: sizes, friction, islands, hash of the problem, verdict, exact certificate |
| `fclib/*.hdf5` | after `python -m lcpbench.fclib scenes/*.scenes --out fclib`: the problems that Siconos' FCLIB can hold |

**Task.** Given v, J = [N D], G, mu, b: find z >= 0 with w = M z + q >= 0 and z'w = 0, that is impulses and velocity of hard
contacts with Coulomb's friction in a pyramid. Units: kg, m, s, N s.
**Answers.** By `auto{{impulses=even}}` within {limit:g} s; each is judged from the problem's data alone in 113 bits, and is solved
where its relative residual is at most 1e-4. {unsolved} are not: their `verdict` is another one.
Many impulses can give one motion. `impulses` says of each answer which it has: "even" ({even} of {count}), those that contacts
of equal, vanishing compliance would carry; "any", some that give the motion; or nothing, where the answer has none.
Learn impulses from the even ones alone.
`certificate` is what exact rational arithmetic proved of small problems.
**Splits.** `held_out` is true for sets that nothing in lcpbench was fitted to. Use them as test sets.
**Limits.** Rigid bodies, no rolling or torsional friction, compliance only where an engine's model has it. Made problems
are drawn over wide ranges and are harder than most of robotics: report captured and made steps apart.
**The same again.** `lcpbench dataset FOLDER` writes the same problems, bit for bit, on every machine; the last digits of
answers may differ.
**Licence.** Apache-2.0. Steps of humanoids come from MuJoCo's humanoid models, copyright 2021 DeepMind Technologies Limited,
Apache-2.0; those of robots from models of MuJoCo Menagerie, and each file's first line names its model's licence.
)";

int write_dataset(const DatasetArguments& arguments) {
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  const fs::path folder = arguments.folder;
  Dataset dataset(folder);
  const auto file_of = [&](std::string stem) {
    std::replace(stem.begin(), stem.end(), '/', '-');
    return std::pair(stem, folder / "scenes" / (stem + ".scenes"));
  };
  for (const CollectedScene& scene : collected_scenes()) {
    if (*stop != 0) return kExitInterrupted;
    if (!glob_matches(arguments.set, scene.name)) continue;
    const auto [stem, path] = file_of(scene.name);
    dataset.write(fs::path("scenes") / (stem + ".scenes"), scene.bytes);
    dataset.add(scene.name, stem, *open_collected(scene), scene.name.starts_with(kHeldOutScenes), stop);
  }
  const std::size_t captured = dataset.count();
  const auto sets = static_cast<std::int64_t>(made_sets().size());
  for (std::int64_t k = 0; k < sets; ++k) {
    const MadeSet& made = made_sets()[static_cast<std::size_t>(k)];
    const std::int64_t count = arguments.made / sets + (k < arguments.made % sets ? 1 : 0);
    if (count == 0 || !glob_matches(arguments.set, made.name)) continue;
    const auto [stem, path] = file_of(made.name);
    const auto set = open_set(fmt::format("{}{{nc_max={}}}", made.name, arguments.contacts));
    WholeFile out(path);
    ScenesWriter writer(out.draft().string(), {.scene = set->name(), .engine = "lcpbench"});
    for (std::int64_t trial = 0; trial < count && *stop == 0; ++trial) {
      SceneStep step;
      step.step = trial;
      step.problem = set->generate(kSeed, trial);
      writer.add(step);
    }
    writer.close();
    if (*stop != 0) return kExitInterrupted;
    out.commit();
    dataset.add(set->name(), stem, ScenesFile(path.string()), made.features.held_out, stop);
  }
  if (*stop != 0) return kExitInterrupted;
  dataset.write_table();
  dataset.write("README.md",
                fmt::format(kCard, fmt::arg("count", dataset.count()), fmt::arg("captured", captured),
                            fmt::arg("made", dataset.count() - captured), fmt::arg("version", kBuildInfo.version),
                            fmt::arg("seed", kSeed), fmt::arg("contacts", arguments.contacts),
                            fmt::arg("limit", kTimeLimitS), fmt::arg("unsolved", dataset.count() - dataset.solved()),
                            fmt::arg("even", dataset.even())));
  say(stdout, "{} problems in {}\n", dataset.count(), printable(arguments.folder));
  return kExitDone;
}

}  // namespace

Action add_dataset_command(CLI::App& command) {
  const auto arguments = std::make_shared<DatasetArguments>();
  command.add_option("FOLDER", arguments->folder, "where the files go")->required();
  command.add_option("--set", arguments->set, "only sets whose names match: made/*")->capture_default_str();
  add_number(command, "--made", arguments->made, "how many problems beside the captured ones, evenly of made/*",
             CLI::Range(INT64_C(0), INT64_C(1'000'000)));
  add_number(command, "--contacts", arguments->contacts, "the most contacts that a made problem aims at",
             CLI::Range(INT64_C(1), INT64_C(20'000)));
  command.footer(
      "Writes captured and made contact problems as scenes files, their verified answers, a table of features "
      "and a data card. The problems are the same on every machine.");
  return [arguments] { return write_dataset(*arguments); };
}

}  // namespace lcpbench
