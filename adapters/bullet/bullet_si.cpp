// Bullet's btSequentialImpulseConstraintSolver, its worlds' default, on a rigid scene.
#include "adapters/bullet/bullet_world.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#endif

namespace lcpbench {

SolverDefinition lcpbench_solver_bullet_si() {
  SolverDefinition definition{
      .name = "bullet_si",
      .summary = "Bullet's default solver of worlds (float64) on the rigid scene: sequential impulses",
      .source = "Bullet Physics, BulletDynamics/ConstraintSolver; a finished step counts as a claim, it has no failure",
      .capabilities = kBulletWorldCapabilities};
#ifdef LCPBENCH_DESCRIBE_ONLY
  return with_settings<BulletWorldSettings>(std::move(definition));
#else
  return define_solver<BulletWorldSolver<btSequentialImpulseConstraintSolver>, BulletWorldSettings>(
      std::move(definition));
#endif
}

}  // namespace lcpbench
