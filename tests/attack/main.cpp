// Solvers, certificates and the evaluation against nasty small problems whose exact truth is found independently.
#include <algorithm>
#include <cstdio>
#include <fstream>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/spec.h"
#include "core/io/problem_io.h"
#include "study/run/provenance.h"
#include "tests/attack/campaign.h"

namespace lcpbench::attack {
namespace {

constexpr std::uint64_t kMostUnresolved = 100;  // one problem in so many may have an inertia that is not resolved

struct Arguments {
  std::string family = "all";
  CampaignOptions campaign;
  std::string solvers;
  std::string replay;
};

std::vector<std::string> chosen_subjects(const std::string& text) {
  std::vector<std::string> all = subject_names();
  const std::vector<std::string> sampled = sampled_subject_names();
  all.insert(all.end(), sampled.begin(), sampled.end());
  if (text.empty()) return all;
  std::vector<std::string> chosen = lcpbench::split_top_level(text);
  for (const std::string& name : chosen) {
    if (std::find(all.begin(), all.end(), name.substr(0, name.find('{'))) == all.end()) {
      throw InputError("--solvers: '" + name + "' is no native solver, embedded:solver, certify or reader");
    }
  }
  return chosen;
}

unsigned long long printable(std::uint64_t value) { return static_cast<unsigned long long>(value); }

void print_table(const Tally& tally, const CampaignOptions& options) {
  std::printf(
      "%s: %llu problems, seed %llu: %llu solvable, %llu unsolvable (%llu shown by doubles, %llu nearly solvable), "
      "%llu unknown, %llu unresolved\n",
      to_string(options.family), printable(options.problems), printable(options.seed), printable(tally.truth(0)),
      printable(tally.truth(1)), printable(tally.truth(2)), printable(tally.truth(4)), printable(tally.truth(3)),
      printable(tally.truth(5)));
  for (std::size_t s = 0; s < tally.subjects.size(); ++s) {
    std::printf("  %-20s", tally.subjects[s].c_str());
    for (std::size_t o = 0; o < kOutcomes; ++o) {
      const auto outcome = static_cast<Outcome>(o);
      const std::uint64_t count = tally.count(s, outcome);
      if (count > 0)
        std::printf(" %s%s %llu", contradiction(outcome) ? "! " : "", to_string(outcome), printable(count));
    }
    std::printf("; slowest %.3f s (problem %llu)\n", tally.slowest_s[s], printable(tally.slowest_at[s]));
  }
}

void write_counts(const Tally& tally, const CampaignOptions& options, std::ofstream& csv) {
  for (std::size_t k = 0; k < tally.kinds.size(); ++k) {
    for (std::size_t s = 0; s < tally.subjects.size(); ++s) {
      const std::string& subject = tally.subjects[s];
      const char* const quote = subject.find(',') == std::string::npos ? "" : "\"";
      csv << to_string(options.family) << ',' << tally.kinds[k] << ',' << quote << subject << quote;
      for (std::size_t o = 0; o < kOutcomes; ++o) csv << ',' << tally.count(k, s, static_cast<Outcome>(o));
      csv << '\n';
    }
  }
}

void write_truths(const Tally& tally, const CampaignOptions& options, std::ofstream& csv) {
  for (std::size_t k = 0; k < tally.kinds.size(); ++k) {
    csv << to_string(options.family) << ',' << tally.kinds[k];
    for (std::size_t t = 0; t < kTruths; ++t) csv << ',' << tally.truths[k * kTruths + t];
    csv << '\n';
  }
}

/// What every subject does with one problem of a file.
int replay(const Arguments& arguments) {
  Target target(read_problem(arguments.replay));
  const std::size_t truth = target.truth.truth == Truth::kSolvable     ? 0
                            : target.truth.truth == Truth::kUnsolvable ? 1
                                                                       : 3;
  std::printf("%s%s\n", kTruthNames[truth], target.truth.shown_by_doubles ? ", shown by doubles" : "");
  bool contradicted = false;
  for (const std::string& name : arguments.campaign.subjects) {
    for (const Approach approach : {Approach::kLoad, Approach::kUpdate, Approach::kStart}) {
      target.approach = approach;
      std::string detail;
      const Outcome outcome = make_subject(name)->meet(target, arguments.campaign.time_limit_s, detail);
      std::printf("  %-20s %s%s: %s\n", name.c_str(), contradiction(outcome) ? "! " : "", to_string(outcome),
                  detail.c_str());
      contradicted = contradicted || contradiction(outcome);
    }
  }
  return contradicted ? 1 : 0;
}

int attack(Arguments& arguments, const std::string& command) {
  CampaignOptions& options = arguments.campaign;
  options.subjects = chosen_subjects(arguments.solvers);
  if (arguments.solvers.empty()) options.sampled_from = subject_names().size();
  if (!arguments.replay.empty()) return replay(arguments);
  const std::string started = utc_now();
  const std::filesystem::path out = options.out;
  std::ofstream counts;
  std::ofstream truths;
  if (!out.empty()) {
    options.out = out / "problems";
    std::filesystem::create_directories(options.out);
    std::ofstream(out / "provenance.json") << provenance(command, started).dump(2) << '\n';
    counts.open(out / "counts.csv");
    truths.open(out / "truths.csv");
    counts << "family,kind,subject";
    for (std::size_t o = 0; o < kOutcomes; ++o) counts << ',' << to_string(static_cast<Outcome>(o));
    counts << '\n';
    truths << "family,kind";
    for (const char* name : kTruthNames) truths << ',' << name;
    truths << '\n';
  }
  std::uint64_t contradictions = 0;
  bool too_many_unresolved = false;
  for (const Family family : kFamilies) {
    if (arguments.family != "all" && arguments.family != to_string(family)) continue;
    options.family = family;
    const Tally tally = run_campaign(options);
    print_table(tally, options);
    if (!out.empty()) {
      write_counts(tally, options, counts);
      write_truths(tally, options, truths);
    }
    contradictions += tally.contradictions();
    too_many_unresolved = too_many_unresolved || kMostUnresolved * tally.truth(5) > options.problems;
  }
  std::printf("%llu contradictions\n", printable(contradictions));
  if (too_many_unresolved) std::printf("the evaluation left more than 1 %% of a family unresolved\n");
  return contradictions == 0 && !too_many_unresolved ? 0 : 1;
}

}  // namespace
}  // namespace lcpbench::attack

int main(int argc, char** argv) {
  using namespace lcpbench::attack;
  Arguments arguments;
  CampaignOptions& options = arguments.campaign;
  CLI::App app(
      "Attacks the native solvers, certify and the evaluation with nasty small problems of known truth.\n"
      "Exit code: 0, no contradiction; 1, contradictions; 2, usage.");
  app.add_option("--kind", arguments.family, "lcp, contact, soft, doubtful or all")
      ->check(CLI::IsMember({"lcp", "contact", "soft", "doubtful", "all"}));
  app.add_option("--problems", options.problems, "number of problems of each kind");
  app.add_option("--first", options.first, "index of the first problem");
  app.add_option("--seed", options.seed, "seed");
  app.add_option("--jobs", options.jobs, "processes")->check(CLI::Range(1, 256));
  app.add_option("--solvers", arguments.solvers,
                 "only these, separated by commas; certify, reader and embedded:solver are among them");
  app.add_option("--time-limit", options.time_limit_s, "seconds that each solver is given");
  app.add_option("--out", options.out, "folder for counts.csv, truths.csv, provenance.json and problems/");
  app.add_option("--replay", arguments.replay, "one problem file instead of generated problems")
      ->check(CLI::ExistingFile);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  std::string command;
  for (int i = 0; i < argc; ++i) command += (i == 0 ? "attack" : std::string(" ") + argv[i]);
  try {
    return attack(arguments, command);
  } catch (const lcpbench::InputError& error) {
    std::fprintf(stderr, "attack: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "attack: %s\n", error.what());
    return 3;
  }
}
