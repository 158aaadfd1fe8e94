#include "study/inspect/inspection.h"

#include "study/commands/commands.h"
#include "study/commands/problem_files.h"

namespace lcpbench {
namespace {

struct InspectArguments {
  std::vector<std::string> files;
  bool json = false;
};

int inspect_files(const InspectArguments& arguments) {
  const auto examine = [&](const Problem& problem, const std::string& file, Json& rows) {
    const Inspection inspection = interruptibly([&] { return inspect(problem); });
    if (arguments.json) {
      rows.push_back(inspection_json(inspection));
      rows.back()["problem"]["file"] = file;
    } else {
      say(stdout, "{}\n{}\n", printable(file), inspection_text(inspection, text_width()));
    }
  };
  return examine_problem_files(arguments.files, arguments.json, examine);
}

}  // namespace

Action add_inspect_command(CLI::App& command) {
  const auto arguments = std::make_shared<InspectArguments>();
  command.add_option("FILE", arguments->files, "problem files")->required();
  add_output_options(command, arguments->json);
  command.footer(
      "Prints size, symmetry, definiteness, rank, conditioning, redundancy and scaling, and warns of probable mistakes "
      "in the data. Solves nothing. Warnings do not change the exit code. A file "
      "that cannot be read does not stop the others; the exit code is then 2. See docs/reference/inspect.md.");
  return [arguments] { return inspect_files(*arguments); };
}

}  // namespace lcpbench
