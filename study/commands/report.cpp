#include "study/report/report.h"

#include <cstdio>
#include <filesystem>
#include <memory>

#include "core/error.h"
#include "study/commands/commands.h"
#include "study/commands/stores.h"
#include "study/report/coverage.h"
#include "study/output/terminal.h"

namespace lcpbench {
namespace {

struct ReportArguments {
  std::filesystem::path store;
  std::filesystem::path out = "lcpbench-report";
};

int run_report(const ReportArguments& arguments) {
  if (arguments.out.empty()) throw InputError("--out '': names no folder");
  Store store = open_checked(arguments.store);
  write_report(store, arguments.out);
  say(stdout, "{}\n", (arguments.out / "report.html").string());
  std::fflush(stdout);
  say(stderr, "{}", report::coverage_text(coverage_of(store.database())));
  return kExitDone;
}

}  // namespace

Action add_report_command(CLI::App& command) {
  const auto arguments = std::make_shared<ReportArguments>();
  command.add_option("STORE", arguments->store, "store that `lcpbench run` wrote")->required();
  command.add_option("--out", arguments->out, "folder for report.html, summary.json, tables and figures")
      ->capture_default_str();
  command.footer("Solves nothing again. The study may still be running.");
  return [arguments] { return run_report(*arguments); };
}

}  // namespace lcpbench
