#include "study/store/merge.h"

#include "study/commands/commands.h"
#include "study/commands/stores.h"

namespace lcpbench {
namespace {

struct MergeArguments {
  std::filesystem::path out;
  std::vector<std::filesystem::path> inputs;
  bool mixed = false;
};

int merge(const MergeArguments& arguments) {
  const MergeOutcome outcome = merge_stores(arguments.out, arguments.inputs, told_on_stderr(), arguments.mixed);
  for (const std::string& notice : outcome.notices) say(stderr, "lcpbench: {}\n", notice);
  if (outcome.conflicts.empty()) {
    say(stdout, "{}: {} cells\n", printable(arguments.out.string()), format_count(outcome.cells));
    return kExitDone;
  }
  for (const std::string& conflict : outcome.conflicts) say(stderr, "lcpbench: conflict: {}\n", conflict);
  say(stderr, "lcpbench: nothing was merged; every input is as it was\n");
  return kExitCheckFailed;
}

}  // namespace

Action add_merge_command(CLI::App& command) {
  const auto arguments = std::make_shared<MergeArguments>();
  command.add_option("OUT", arguments->out, "store to write; if it exists, it is joined with the others")->required();
  command.add_option("IN", arguments->inputs, "stores to join")->required();
  command.add_flag("--mixed", arguments->mixed, "join stores of different plans or versions of lcpbench, too");
  command.footer(
      "The result equals that of the unsharded run, except for times. If stores contradict each other, nothing is "
      "written and the exit code is 1.");
  return [arguments] { return merge(*arguments); };
}

}  // namespace lcpbench
