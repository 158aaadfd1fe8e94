#include "study/commands/commands.h"
#include "study/commands/problem_files.h"
#include "study/evaluation/fastest_contact.h"
#include "study/run/open_solver.h"
#include "study/shrink/pieces.h"

namespace lcpbench {
namespace {

constexpr double kRunsInto = 1e-3;  // m/s

struct AuditArguments {
  std::vector<std::string> files;
  double time_limit_s = 10.0;
  bool json = false;
};

/// What the engine left without an impulse, and what that changes.
struct Audit {
  Index solved = 0;             ///< contacts with an impulse
  std::vector<Index> run_into;  ///< without one, although they would act and the engine's velocity runs into them
  FastestContact error;         ///< of the velocity without them
};

/// @returns an answer with its velocity
Answer solved(const Problem& problem, double time_limit_s) {
  TimedAnswer timed;
  open_solver(parse_spec("auto{impulses=even}"))->run(problem, {.time_limit_s = time_limit_s}, timed);
  Answer& answer = timed.answer;
  if (answer.claim != Claim::kSolved) throw InputError("auto says " + std::string(to_string(answer.claim)));
  if (answer.velocity.size() == 0) answer.velocity = post_impact_velocity(*problem.contact(), answer.z);
  return std::move(answer);
}

/// @throws InputError for a problem without the impulses of an engine, or that `auto` does not solve
Audit audit(const Problem& problem, double time_limit_s) {
  if (problem.engine_impulses() == nullptr) throw InputError("there are no impulses of an engine");
  const ContactProblem& contacts = *problem.contact();
  const Vector z = complete_impulses(contacts, *problem.engine_impulses());
  const Vector own = post_impact_velocity(contacts, z);
  Audit result;
  std::vector<Index> kept;
  for (Index i = 0; i < contacts.nc(); ++i) {
    if (z(i) != 0) ++result.solved;
    const double speed = dot_column(contacts.N, i, own) + (contacts.b.size() > 0 ? contacts.b(i) : 0);
    (z(i) != 0 || !(speed < -kRunsInto) ? kept : result.run_into).push_back(i);
  }
  if (result.run_into.empty()) return result;
  const Answer whole = solved(problem, time_limit_s);
  std::erase_if(result.run_into, [&](Index i) { return !(whole.z(i) > 0); });
  if (result.run_into.empty()) return result;
  result.error = fastest_contact(contacts, whole.velocity - solved(with_contacts(problem, kept), time_limit_s).velocity);
  return result;
}

int audit_files(const AuditArguments& arguments) {
  const auto examine = [&](const Problem& problem, const std::string& file, Json& rows) {
    Audit found;
    try {
      found = audit(problem, arguments.time_limit_s);
    } catch (const InputError& error) {
      throw InputError(file + ": " + error.what());
    }
    const std::vector<std::string> names = contact_names(file);
    const auto name = [&](Index i) {
      return names.empty() ? fmt::format("contact {}", i) : names[static_cast<std::size_t>(i)];
    };
    const Index count = problem.contact()->nc();
    if (arguments.json) {
      Json run_into = Json::array();
      for (const Index i : found.run_into) run_into.push_back(name(i));
      rows.push_back({{"problem", file},
                      {"found", count},
                      {"solved", found.solved},
                      {"run_into", run_into},
                      {"velocity_error_m_per_s", found.error.m_per_s}});
      return;
    }
    say(stdout, "{}: {} of {} contacts have an impulse, {} without one are run into", printable(file), found.solved,
        count, found.run_into.size());
    if (!found.run_into.empty())
      say(stdout, ", first {}: {:.3g} m/s", printable(name(found.run_into.front())), found.error.m_per_s);
    if (found.error.contact >= 0) say(stdout, " at {}", printable(name(found.error.contact)));
    say(stdout, "\n");
  };
  return examine_problem_files(arguments.files, arguments.json, examine);
}

}  // namespace

Action add_audit_command(CLI::App& command) {
  const auto arguments = std::make_shared<AuditArguments>();
  command.add_option("FILE", arguments->files, "captured steps: F.scenes, or one as F.scenes#120")->required();
  add_number(command, "--time-limit", arguments->time_limit_s, "[s] of each of two solves", number_check());
  add_output_options(command, arguments->json);
  command.footer(
      "Counts the contacts without an impulse of the engine that its velocity runs into at more than 1 mm/s, and that "
      "have one in the answer of `auto`. Either the engine dropped them, or its solver had not come to them yet, as after "
      "few sweeps. Solves the step with `auto` with and without them, and prints the largest difference of the two "
      "velocities at a contact. In Python lcpbench.mujoco.audit finds contacts that MuJoCo dropped, and says why.");
  return [arguments] { return audit_files(*arguments); };
}

}  // namespace lcpbench
