#include "core/io/problem_io.h"
#include "generators/sets.h"
#include "study/commands/commands.h"

namespace lcpbench {
namespace {

struct GenerateArguments {
  std::string set;
  std::string out;
  std::uint64_t seed = 1;
  std::int64_t count = 1;
  std::int64_t first = 0;
};

int generate(const GenerateArguments& arguments) {
  const std::unique_ptr<ProblemSet> set = open_set(arguments.set);
  const std::filesystem::path folder = arguments.out;
  make_folder(folder);
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  std::int64_t count = 0;
  for (; count < arguments.count && *stop == 0; ++count) {
    const std::int64_t trial = arguments.first + count;
    write_problem(set->generate(arguments.seed, trial), folder / fmt::format("{:06}.json", trial));
  }
  say(stdout, "{} problem{} of {} in {}\n", count, count == 1 ? "" : "s", set->name(), printable(arguments.out));
  return *stop != 0 ? kExitInterrupted : kExitDone;
}

}  // namespace

Action add_generate_command(CLI::App& command) {
  const auto arguments = std::make_shared<GenerateArguments>();
  command.add_option("SET", arguments->set, "problem set, with its options in braces")->required();
  command.add_option("--seed", arguments->seed, "stream of random problems")->check(seed_check())->required();
  command.add_option("--count", arguments->count, "how many problems")
      ->required()
      ->check(CLI::Range(INT64_C(1), INT64_C(10'000'000)));
  add_number(command, "--first", arguments->first, "index of the first trial",
             CLI::Range(INT64_C(0), INT64_C(1'000'000'000'000)));
  command.add_option("--out", arguments->out, "folder for DIR/NNNNNN.json, NNNNNN the trial's index")->required();
  return [arguments] { return generate(*arguments); };
}

}  // namespace lcpbench
