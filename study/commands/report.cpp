#include "study/report/report.h"

#include "study/commands/commands.h"
#include "study/commands/stores.h"
#include "study/report/text.h"

namespace lcpbench {
namespace {

struct ReportArguments {
  std::filesystem::path store;
  std::filesystem::path out = "lcpbench-report";
  std::filesystem::path replay;
};

int run_report(const ReportArguments& arguments) {
  if (arguments.out.empty()) throw InputError("--out '': names no folder");
  std::vector<ReplayedFiles> replays;
  if (!arguments.replay.empty()) replays = read_replays(arguments.replay);
  Store store = open_checked(arguments.store);
  const Coverage coverage = write_report(store, arguments.out, replays);
  say(stdout, "{}\n", printable((arguments.out / "report.html").string()));
  std::fflush(stdout);
  say(stderr, "{}", report::coverage_text(coverage));
  return kExitDone;
}

}  // namespace

Action add_report_command(CLI::App& command) {
  const auto arguments = std::make_shared<ReportArguments>();
  command.add_option("STORE", arguments->store, "store that `lcpbench run` wrote")->required();
  command.add_option("--out", arguments->out, "folder for report.html, report.json, summary.json and tables/*.csv")
      ->capture_default_str();
  command.add_option("--replay", arguments->replay,
                     "folder that `lcpbench replay` wrote: its curves and filmstrips become a section of the report");
  command.footer("Solves nothing again. The study may still be running.");
  return [arguments] { return run_report(*arguments); };
}

}  // namespace lcpbench
