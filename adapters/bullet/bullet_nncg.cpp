// Bullet's nonsmooth nonlinear conjugate gradients, on a rigid scene.
#include "adapters/bullet/bullet_world.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#endif

class btNNCGConstraintSolver;

namespace lcpbench {

SolverDefinition lcpbench_solver_bullet_nncg() {
  return define_adapter<BulletWorldSolver<btNNCGConstraintSolver>, BulletWorldSettings>(
      {.name = "bullet_nncg",
       .summary =
           "Bullet's btNNCGConstraintSolver (float64) on the rigid scene: nonsmooth nonlinear conjugate gradients",
       .source =
           "Bullet Physics, BulletDynamics/ConstraintSolver; Silcowitz-Hansen, Niebe, Erleben 2010, Vis. Comput. 26",
       .capabilities = kBulletWorldCapabilities});
}

}  // namespace lcpbench
