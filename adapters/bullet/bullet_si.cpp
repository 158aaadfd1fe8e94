// Bullet's btSequentialImpulseConstraintSolver, its worlds' default, on a rigid scene.
#include "adapters/bullet/bullet_world.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#endif

class btSequentialImpulseConstraintSolver;

namespace lcpbench {

SolverDefinition lcpbench_solver_bullet_si() {
  return define_adapter<BulletWorldSolver<btSequentialImpulseConstraintSolver>, BulletWorldSettings>(
      {.name = "bullet_si",
       .summary = "Bullet's default solver of worlds (float64) on the rigid scene: sequential impulses",
       .source =
           "Bullet Physics, BulletDynamics/ConstraintSolver; a finished step counts as a claim, it has no failure",
       .capabilities = kBulletWorldCapabilities});
}

}  // namespace lcpbench
