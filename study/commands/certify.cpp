#include <algorithm>
#include <fstream>
#include <string_view>

#include "core/io/whole_file.h"
#include "generators/sets.h"
#include "study/certificates/certify_store.h"
#include "study/certificates/proof_document.h"
#include "study/commands/commands.h"
#include "study/commands/problem_files.h"
#include "study/commands/stores.h"
#include "study/output/columns.h"
#include "study/output/solution_text.h"
#include "study/run/provenance.h"
#include "study/statistics/statistics.h"

namespace lcpbench {
namespace {

struct CertifyArguments {
  std::vector<std::string> files;
  bool exact = false;
  double time_limit_s = 10.0;
  std::string proofs;
  bool json = false;
  std::string store;
  std::vector<std::string> sets;
  std::int64_t every = 20;
  std::optional<int> jobs;
  bool other_velocity = false;
};

/// Proofs go to a file, one line each; or nowhere.
class ProofFile {
 public:
  /// @param name  "" for nowhere @param inputs  what the command reads
  ProofFile(const std::string& name, const std::vector<std::string>& inputs) : name_(name) {
    if (name.empty()) return;
    refuse_inputs(name, inputs);
    whole_.emplace(name);
    file_.open(whole_->draft(), std::ios::binary | std::ios::trunc);
  }
  bool wanted() const { return whole_.has_value(); }
  void add(std::string_view document) {
    file_ << document << '\n';
    ++count_;
  }
  /// @throws InputError when not all of it arrived.
  void close() {
    if (!wanted()) return;
    file_.close();
    if (!file_) throw InputError(name_ + ": cannot be written");
    whole_->commit();
    say(stderr, "{} in {}; study/check_certificates.py checks them\n", counted_noun(count_, "proof"), printable(name_));
  }

 private:
  std::string name_;
  std::optional<WholeFile> whole_;
  std::ofstream file_;
  std::size_t count_ = 0;
};

// ------------------------------------------------------------------------------------------------ problem files

Json fractions_json(const ExactVector& vector) {
  return vector.numerators.empty() ? Json(nullptr) : Json(fractions(vector));
}

/// A row of the command's JSON; null stands for what the certificate does not have. `farkas` is the vector of a proof
/// "farkas", that there is no solution, or of a proof "lp", that there is one.
/// @param exact  adds the exact vectors, as lists of fractions in text
Json certificate_json(const Problem& problem, const std::string& file, const Certificate& certificate, bool exact) {
  Json json{{"problem", problem_summary_json(problem, file)},
            {"certificate", to_string(certificate.kind)},
            {"proof", certificate.proof == ProofKind::kNone ? Json(nullptr) : Json(to_string(certificate.proof))},
            {"z", json_vector(certificate.z, certificate.proof == ProofKind::kExactBasis)},
            {"velocity", json_vector(certificate.velocity)},
            {"velocity_unique", json_optional(certificate.velocity_unique)},
            {"farkas", json_vector(certificate.farkas)},
            {"seconds", json_number(certificate.seconds)}};
  if (exact) {
    json["z_exact"] = fractions_json(certificate.exact_z);
    json["velocity_exact"] = fractions_json(certificate.exact_velocity);
    json["farkas_exact"] = fractions_json(certificate.exact_farkas);
  }
  return json;
}

std::string finding(const Problem& problem, const Certificate& certificate) {
  switch (certificate.proof) {
    case ProofKind::kExactBasis: return "it has a solution, checked in exact arithmetic";
    case ProofKind::kLp: return "it has a solution: proven in exact arithmetic without giving one";
    case ProofKind::kFarkas: {
      const double bound = least_violation(problem, certificate);
      return bound > 0 ? fmt::format(
                             "it has no solution: whatever the impulses, a contact{} is violated by {:.3g} {} "
                             "or more",
                             problem.contact()->has_rows() ? " or bounded row" : "", bound,
                             problem.contact()->has_rows() ? "m/s or rad/s" : "m/s")
                       : "it has no solution, proven in exact arithmetic";
    }
    case ProofKind::kEveryBasis: return "it has no solution: no basis gives one in exact arithmetic";
    case ProofKind::kNone: break;
  }
  return "neither a solution nor a proof that there is none was found";
}

void print_vector(const char* title, const ExactVector& vector) {
  if (vector.numerators.empty()) return;
  say(stdout, "  {}:\n", title);
  for (const std::string& entry : fractions(vector)) say(stdout, "    {}\n", entry);
}

void print_certificate(const Problem& problem, const std::string& file, const Certificate& certificate,
                       bool exact) {
  std::string text =
      fmt::format("{}\n  {}: {} ({})\n", problem_summary_text(problem, file), to_string(certificate.kind),
                  finding(problem, certificate), format_seconds(certificate.seconds));
  if (!certificate.detail.empty()) text += "  " + certificate.detail + "\n";
  if (const std::string numbers = few_numbers(certificate.velocity); !numbers.empty()) {
    const char* others = !certificate.velocity_unique   ? ""
                         : *certificate.velocity_unique ? ", the only one"
                                                        : ", of which another is certified too";
    text += fmt::format("  velocity after the impact{}: {}\n", others, numbers);
  }
  say_folded("{}", text);
  if (certificate.z.size() == problem.size()) {
    say(stdout, "{}",
        solution_text(problem, "certified", certificate.z, certificate.velocity, contact_names(file), text_width()));
    const ContactProblem* const contact = problem.contact();
    if (contact != nullptr && may_have_other_impulses(*contact, certificate.velocity)) {
      say_folded("other impulses may give the same motion; these are the ones that were certified\n");
    }
  }
  if (exact) {
    print_vector("z", certificate.exact_z);
    print_vector("velocity", certificate.exact_velocity);
    print_vector("proof", certificate.exact_farkas);
  }
  say(stdout, "\n");
}

int certify_files(const CertifyArguments& arguments) {
  ProofFile proofs(arguments.proofs, arguments.files);
  // A single problem is somebody's question: whether its answer is the only one belongs to it.
  const CertifyOptions options{.time_limit_s = arguments.time_limit_s, .seek_other_velocity = true};
  Certifier certifier(options);
  const auto examine = [&](const Problem& problem, const std::string& file, Json& rows) {
    const Certificate certificate = certifier.certify(problem);
    if (arguments.json) {
      rows.push_back(certificate_json(problem, file, certificate, arguments.exact));
    } else {
      print_certificate(problem, file, certificate, arguments.exact);
    }
    if (proofs.wanted() && certificate.kind != CertificateKind::kOpen) {
      proofs.add(proof_document(problem, certificate));
    }
  };
  const int exit_code = examine_problem_files(arguments.files, arguments.json, examine);
  proofs.close();
  return exit_code;
}

// ------------------------------------------------------------------------------------------------------ a store

/// The store's sets that the patterns name. @throws InputError for a pattern that names none of them.
std::vector<std::string> sets_of_store(Store& store, const std::vector<std::string>& patterns) {
  const auto stored = store.sets();
  std::vector<std::string> chosen;
  for (const std::string& pattern : patterns) {
    const std::size_t before = chosen.size();
    for (const std::string& name : expand_sets(pattern)) {
      const bool known = std::ranges::any_of(stored, [&](const auto& set) { return set.second == name; });
      if (known) chosen.push_back(name);
    }
    if (chosen.size() > before) continue;
    throw InputError(fmt::format("{}: has no problem of '{}'", store.file().string(), pattern));
  }
  return chosen;
}

Json set_json(const CertifiedSet& set) {
  const std::int64_t proven = set.certified();
  const Interval share = wilson(set.solution, proven);
  const Interval share_999 = wilson(set.solution, proven, kNormal9995);
  return {{"set", set.set},
          {"problems", set.problems},
          {"certified", proven},
          {"solution", set.solution},
          {"unsolvable", set.unsolvable},
          {"open", set.open},
          {"solution_share", json_number(static_cast<double>(set.solution) / static_cast<double>(proven))},
          {"solution_low", json_number(share.low)},
          {"solution_high", json_number(share.high)},
          {"solution_low_999", json_number(share_999.low)},
          {"solution_high_999", json_number(share_999.high)},
          {"unsolvable_high", json_number(wilson(set.unsolvable, proven).high)},
          {"open_high", json_number(wilson(set.open, proven).high)},
          {"seconds_mean", json_number(set.seconds_mean)},
          {"seconds_max", json_number(set.seconds_max)},
          {"other_velocity", set.other_velocity},
          {"answers", set.answers},
          {"verified", set.verified},
          {"forward_errors", set.forward}};
}

std::string counts_table(const Json& sets) {
  using Align = TextTable::Align;
  const auto solvable = [](const Json& set) {
    if (set["certified"] == 0) return std::string("-");
    return fmt::format("{:.2f} to {:.2f} %", 100 * set["solution_low"].get<double>(),
                       100 * set["solution_high"].get<double>());
  };
  return table_text({{{"set", Align::kLeft}, field("set")},
                     {{"problems"}, field("problems")},
                     {{"certified"}, field("certified")},
                     {{"solution", Align::kRight, 1}, field("solution")},
                     {{"unsolvable"}, field("unsolvable")},
                     {{"open"}, field("open")},
                     {{"solvable, 95 %", Align::kRight, 2}, solvable},
                     {{"mean time", Align::kRight, 4}, field("seconds_mean", format_seconds)},
                     {{"answers", Align::kRight, 3}, field("answers")},
                     {{"verified", Align::kRight, 3}, field("verified")},
                     {{"forward errors", Align::kRight, 5}, field("forward_errors")}},
                    sets);
}

/// What was decided and what was not looked at, in whole sentences.
std::string counts_text(const std::vector<CertifiedSet>& sets, const CertifyArguments& arguments) {
  CertifiedSet all;
  std::int64_t left_out = 0;
  for (const CertifiedSet& set : sets) {
    all.solution += set.solution;
    all.unsolvable += set.unsolvable;
    all.open += set.open;
    left_out += set.problems - set.certified();
  }
  std::string text =
      fmt::format("Of {} problems with a certificate {} have a solution, {} have none, and {} are open.\n",
                  format_count(all.certified()), format_count(all.solution), format_count(all.unsolvable),
                  format_count(all.open));
  if (left_out == 0) return text;
  return text + fmt::format("{} problems with friction were left out, because --every {} takes only one trial in {} of "
                            "them. --every 1 takes all; the same command goes on from here.\n",
                            format_count(left_out), arguments.every, arguments.every);
}

/// @throws InputError when the file is no store; one that does not exist is not made.
Store open_existing(const std::string& file) {
  print_notice(Store::open_for_reading(file));
  return Store::open_for_writing(file, told_on_stderr());
}

CertifyOutcome certify_all(const CertifyArguments& arguments, Store& store, const CertifyScope& scope,
                           const volatile std::sig_atomic_t* stop) {
  CertifyRun run;
  run.scope = scope;
  run.jobs = arguments.jobs.value_or(processors());
  run.stop = stop;
  const CertifyOptions options{.time_limit_s = arguments.time_limit_s, .seek_other_velocity = arguments.other_velocity};
  run.open = [options] {
    const auto certifier = std::make_shared<Certifier>(options);
    return [certifier](const Problem& problem) { return certifier->certify(problem); };
  };
  ProgressLine progress;
  progress.show("certifying problems of " + store.file().string());
  run.on_progress = [&progress](std::int64_t done, std::int64_t total) {
    progress.show(fmt::format("certifying: {} of {} problems are done", format_count(done), format_count(total)));
  };
  return certify_store(store, run);
}

void print_findings(const CertifyArguments& arguments, const std::vector<CertifiedSet>& sets,
                    const std::vector<std::string>& contradictions) {
  Json rows = Json::array();
  for (const CertifiedSet& set : sets) rows.push_back(set_json(set));
  if (arguments.json) {
    print_json({{"provenance", provenance(typed_command_line, utc_now())},
                {"sets", rows},
                {"contradictions", contradictions},
                {"ok", contradictions.empty()}});
    say(stderr, "{}", counts_text(sets, arguments));
    return;
  }
  say(stdout, "{}\n", counts_table(rows));
  say_folded("{}", counts_text(sets, arguments));
  for (const std::string& line : contradictions) say_folded("CONTRADICTION: {}\n", line);
  if (contradictions.empty()) say(stdout, "no answer and no certificate contradict each other\n");
}

int certify_stored(const CertifyArguments& arguments) {
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  Store store = open_existing(arguments.store);
  const CertifyScope scope{sets_of_store(store, arguments.sets), arguments.every, arguments.time_limit_s};
  ProofFile proofs(arguments.proofs, {arguments.store});
  const CertifyOutcome outcome = certify_all(arguments, store, scope, stop);
  if (outcome.done < outcome.total) {
    say(stderr, "lcpbench: interrupted; {} of {} problems are done: run the same command again to resume\n",
        format_count(outcome.done), format_count(outcome.total));
    return kExitInterrupted;
  }
  CertificateTable table(store);
  const std::vector<std::string> contradictions = table.contradictions(scope);
  print_findings(arguments, table.counts(scope), contradictions);
  if (proofs.wanted()) {
    table.for_each_proof(scope, [&](std::string_view document) { proofs.add(document); });
    proofs.close();
  }
  return contradictions.empty() ? kExitDone : kExitCheckFailed;
}

int certify(const CertifyArguments& arguments) {
  if (arguments.files.empty() == arguments.store.empty()) {
    throw InputError("certify: give problem files, or --store STORE (lcpbench certify --help)");
  }
  return arguments.store.empty() ? certify_files(arguments) : certify_stored(arguments);
}

}  // namespace

Action add_certify_command(CLI::App& command) {
  const auto arguments = std::make_shared<CertifyArguments>();
  command.add_option("FILE", arguments->files, "problem files");
  add_number(command, "--time-limit", arguments->time_limit_s, "seconds for each problem", number_check());
  command.add_option("--proofs", arguments->proofs,
                     "write problems and proofs to this file, for study/check_certificates.py");
  add_output_options(command, arguments->json);
  CLI::Option* store = command.add_option("--store", arguments->store,
                                          "instead of FILE: the problems of a store of lcpbench run; resumes");
  command.add_flag("--exact", arguments->exact, "show the exact rationals too")->excludes(store);
  add_repeatable(command, "--set", arguments->sets,
                 "only this set, or glob, of the store; may be repeated (default: all)")
      ->needs(store);
  add_number(command, "--every", arguments->every,
             "of the store's frictional problems only the trials that this divides;\nfrictionless ones are all "
             "certified",
             CLI::Range(1, 100'000'000))
      ->needs(store);
  add_number(command, "--jobs", arguments->jobs, "threads (default: one per processor)", CLI::Range(1, 1024))
      ->needs(store);
  command
      .add_flag("--other-velocity", arguments->other_velocity,
                "look for a second velocity of frictional problems; with FILE always done")
      ->needs(store);
  command.footer(
      "solution: one is proven to exist. unsolvable: proven to have none. open: neither. Proofs are exact, on the "
      "numbers of the file. A file that cannot be read does not stop the others; the exit code is then 2. With "
      "--store: exit code 1 when an answer and a certificate contradict each other. See "
      "docs/explanation/certificates.md.");
  return [arguments] { return certify(*arguments); };
}

}  // namespace lcpbench
