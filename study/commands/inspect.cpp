#include <csignal>
#include <memory>
#include <string>
#include <vector>

#include "study/commands/commands.h"
#include "study/commands/options.h"
#include "study/commands/problem_files.h"
#include "study/inspect/inspection.h"
#include "study/run/interrupt.h"
#include "study/output/json_output.h"
#include "study/output/terminal.h"

namespace lcpbench {
namespace {

struct InspectArguments {
  std::vector<std::string> files;
  std::string format = "text";
  Extent extent;
};

int inspect_files(const InspectArguments& arguments) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  const auto visit = [&](const Problem& problem, const std::string& file) {
    const Inspection inspection = interruptibly([&] { return inspect(problem); });
    if (arguments.format == "json") {
      rows.push_back(inspection_json(inspection));
      rows.back()["problem"]["file"] = file;
    } else {
      say(stdout, "{}\n{}\n", printable(file), inspection_text(inspection, arguments.extent.width()));
    }
  };
  const bool complete = for_each_problem_file(arguments.files, stop, visit);
  if (arguments.format == "json") print_json(rows);
  if (*stop != 0) return kExitInterrupted;
  return complete ? kExitDone : kExitBadInput;
}

}  // namespace

Action add_inspect_command(CLI::App& command) {
  const auto arguments = std::make_shared<InspectArguments>();
  command.add_option("FILE", arguments->files, "problem files")->required();
  add_wide_option(command, arguments->extent);
  add_format_option(command, arguments->format);
  command.footer(
      "Prints size, symmetry, definiteness, rank, conditioning, redundancy and scaling, and warns of probable mistakes "
      "in the data. Solves nothing. Warnings do not change the exit code. A file "
      "that cannot be read does not stop the others; the exit code is then 2. See docs/reference/inspect.md.");
  return [arguments] { return inspect_files(*arguments); };
}

}  // namespace lcpbench
