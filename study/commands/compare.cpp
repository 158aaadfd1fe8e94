#include "core/io/whole_file.h"
#include "study/commands/commands.h"
#include "study/commands/stores.h"
#include "study/compare/comparison.h"
#include "study/report/tables.h"

namespace lcpbench {
namespace {

struct CompareArguments {
  std::filesystem::path a;
  std::filesystem::path b;
  CompareOptions options;
  std::filesystem::path page;
  bool all = false;
  bool json = false;
  bool fail_on_regression = false;
  bool fail_on_slower = false;
};

std::string member(const Json& run, const char* name) {
  const bool present = run.contains(name) && run[name].is_string();
  return present ? run[name].get<std::string>() : "not recorded";
}

/// Times of different machines or builds say little of the solvers.
void warn_of_differences(const Json& a, const Json& b) {
  for (const char* name : {"processor", "compiler", "flags"}) {
    if (member(a, name) == member(b, name)) continue;
    say(stderr, "lcpbench: the stores differ in their {} ({}; {}): do not trust the times\n", name, member(a, name),
        member(b, name));
  }
}

int compare(const CompareArguments& arguments) {
  if (!arguments.page.empty() && arguments.page.extension() != ".html") {
    throw InputError(
        fmt::format("--out {}: a browser shows a page only if its name ends in .html", arguments.page.string()));
  }
  Store a = open_checked(arguments.a);
  Store b = open_checked(arguments.b);
  const Json comparison = compare_stores(a, b, arguments.options);
  const Json run_a = last_run(a);
  const Json run_b = last_run(b);
  warn_of_differences(run_a, run_b);
  Json document{{"a", {{"store", arguments.a.string()}, {"provenance", run_a}}},
                {"b", {{"store", arguments.b.string()}, {"provenance", run_b}}}};
  document.update(comparison);
  if (!arguments.page.empty()) {
    write_file(arguments.page, report::page_html({{"format", "lcpbench-report"},
                                                  {"version", 1},
                                                  {"kind", "comparison"},
                                                  {"comparison", document}}));
  }
  if (arguments.json) {
    print_json(document);
  } else {
    say_folded("A: {}\nB: {}\n", printable(arguments.a.string()), printable(arguments.b.string()));
    say(stdout, "\n{}", comparison_text(comparison, text_width(), arguments.all));
  }
  const auto fails = [&](bool asked, const char* what) { return asked && comparison[what].get<bool>(); };
  const bool failed = fails(arguments.fail_on_regression, "regressed") || fails(arguments.fail_on_slower, "slower");
  return failed ? kExitCheckFailed : kExitDone;
}

}  // namespace

Action add_compare_command(CLI::App& command) {
  const auto arguments = std::make_shared<CompareArguments>();
  command.add_option("A", arguments->a, "store to compare with: the older one")->required();
  command.add_option("B", arguments->b, "store to judge: the newer one; may be A with --solver-b")->required();
  add_repeatable(command, "--set", arguments->options.sets, "set name or glob; may be repeated; default all");
  const auto solver_a = command.add_option("--solver-a", arguments->options.solver_a,
                                           "compare only this solver of A, spelt as in the report");
  command.add_option("--solver-b", arguments->options.solver_b, "... with this solver of B; default: the same")
      ->needs(solver_a);
  command.add_flag("--fail-on-regression", arguments->fail_on_regression,
                   "exit with 1 when B solves significantly fewer problems or makes any new false claim");
  command.add_flag("--fail-on-slower", arguments->fail_on_slower, "exit with 1 when B is significantly slower");
  command.add_option("--out", arguments->page, "file of a page that shows the comparison");
  command.add_flag("--long", arguments->all, "show every set and solver, not only the largest changes");
  add_output_options(command, arguments->json);
  command.footer(
      "Compares on the problems that both stores hold with the same data. Solved and false claims: exact McNemar "
      "test, corrected by Holm's method. Times: geometric mean of the ratios on problems solved in both, 95 % interval; "
      "under 5 %, with an interval that contains 1, or without significance in the sign test, it is a tie. Solvers "
      "belong together by name, settings and sweep, also across versions and instruction-set levels. See "
      "docs/howto/compare.md.");
  return [arguments] { return compare(*arguments); };
}

}  // namespace lcpbench
