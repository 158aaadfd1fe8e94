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

/// What the engine left out, and what that changes.
struct Audit {
  Index solved = 0;            ///< contacts with an impulse
  std::vector<Index> missing;  ///< without one, although the engine's velocity runs into them
  FastestContact error;        ///< of the velocity without them
};

Vector solved_velocity(const Problem& problem, double time_limit_s) {
  TimedAnswer timed;
  open_solver(parse_spec("auto"))->run(problem, {.time_limit_s = time_limit_s}, timed);
  if (timed.answer.claim != Claim::kSolved) throw InputError("auto says " + std::string(to_string(timed.answer.claim)));
  if (timed.answer.velocity.size() > 0) return timed.answer.velocity;
  return post_impact_velocity(*problem.contact(), timed.answer.z);
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
    (z(i) != 0 || !(speed < -kRunsInto) ? kept : result.missing).push_back(i);
  }
  if (result.missing.empty()) return result;
  const Vector without = solved_velocity(with_contacts(problem, kept), time_limit_s);
  result.error = fastest_contact(contacts, solved_velocity(problem, time_limit_s) - without);
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
      Json missing = Json::array();
      for (const Index i : found.missing) missing.push_back(name(i));
      rows.push_back({{"problem", file},
                      {"found", count},
                      {"solved", found.solved},
                      {"missing", missing},
                      {"velocity_error_m_per_s", found.error.m_per_s}});
      return;
    }
    say(stdout, "{}: {} of {} contacts have an impulse, {} missing", printable(file), found.solved, count,
        found.missing.size());
    if (!found.missing.empty())
      say(stdout, ", first {}: {:.3g} m/s", printable(name(found.missing.front())), found.error.m_per_s);
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
      "Counts the contacts to which the engine gave no impulse, although its velocity runs into them at more than "
      "1 mm/s: they are missing in its solver. Solves the step with `auto` with and without them, and prints the "
      "largest "
      "difference of the two velocities at a contact. In Python lcpbench.mujoco.audit also says why they are missing.");
  return [arguments] { return audit_files(*arguments); };
}

}  // namespace lcpbench
