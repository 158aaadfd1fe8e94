#pragma once

#include <limits>
#include <memory>
#include <string>

#include "core/contact_problem.h"
#include "core/lcp.h"
#include "core/scene.h"

namespace lcpbench {

enum class ProblemKind { kLcp, kContact, kScene };

/// "lcp", "contact" or "scene": the words of the problem file.
const char* to_string(ProblemKind kind);

/// What the engine of a captured step found.
struct EngineAnswer {
  Vector impulses;  ///< f_N of each contact, f_D of each friction direction, f_R of each bounded row
  double solve_s = std::numeric_limits<double>::quiet_NaN();  ///< that its own solver took; NaN: not known
  std::string engine;                                         ///< name and version; "": not known
};

/// One problem, in the most detailed form that is known. A scene has its contact problem, too. Both have their LCP,
/// which is formed at the first call of lcp(). A problem does not change; copies share the data; many threads may read
/// it.
class Problem {
 public:
  Problem() = default;  ///< no problem: every accessor but `kind`, `name` and `engine_impulses` is undefined
  Problem(std::string name, Lcp lcp);
  /// Only solvers see the formation. Problem files and the hash do not contain it.
  Problem(std::string name, ContactProblem contact, const MatrixFormation& formation = {});
  /// Nobody may change the data while any copy of the problem is in use.
  Problem(std::string name, std::shared_ptr<const ContactProblem> contact, const MatrixFormation& formation = {});
  Problem(std::string name, RigidScene scene);

  const std::string& name() const;
  ProblemKind kind() const;

  /// Order of M; M is not formed for this.
  Index size() const;

  /// (q, M). The first call for a contact problem forms and keeps them: see form_lcp; n^2 doubles. Other threads that
  /// call it meanwhile wait.
  const Lcp& lcp() const;

  /// nullptr for a bare LCP.
  const ContactProblem* contact() const;

  /// How lcp() forms M.
  const MatrixFormation& formation() const;

  /// nullptr unless the problem came as a scene.
  const RigidScene* scene() const;

  /// The same problem with what the engine of a captured step found. Problem files and the hash do not contain this.
  Problem with_engine_answer(EngineAnswer answer) const;
  /// nullptr if no impulses of an engine are known.
  const EngineAnswer* engine_answer() const { return engine_.get(); }
  const Vector* engine_impulses() const { return engine_ ? &engine_->impulses : nullptr; }

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
  std::shared_ptr<const EngineAnswer> engine_;
};

}  // namespace lcpbench
