#!/usr/bin/env python3
"""A step of Rapier: rapier_step.py [SWEEPS], with form=scene,cone=true.

Bodies are free, and each contact is a pair of small balls that touch at its point and meet nothing else. All settings
are Rapier's but one: friction is that of each contact (COULOMB), because the other model tells no friction impulses. A
step of 1/60 s has four substeps; SWEEPS that end a substep, without softness, are 1 in Rapier. It is single precision.
Contacts with an offset are refused: the substeps meet gaps at their own times, and push out penetrations at a rate.
"""
import sys

from peer import Contacts, serve, timed
import numpy as np
import rapier3d as rapier
from scipy.spatial.transform import Rotation

sweeps = int(sys.argv[1]) if len(sys.argv) > 1 else 1
STEP, RADIUS = 1 / 60, 1e-3


class Hooks:
    def filter_contact_pair(self, context):
        a, b = (context.colliders[each].user_data for each in (context.collider1, context.collider2))
        return rapier.SolverFlags.default_() if a // 2 == b // 2 else None


def load(text):
    problem = Contacts.of_scene(text)
    if np.any(problem.b != 0):
        return "contacts have offsets, which Rapier meets in its substeps"
    world = rapier.PhysicsWorld()
    world.physics_hooks = Hooks()
    world.integration_parameters.dt = STEP
    world.integration_parameters.num_internal_stabilization_iterations = sweeps
    world.integration_parameters.friction_model = rapier.FrictionModel.COULOMB
    bodies = []
    for each in text["bodies"]:
        moments, axes = np.linalg.eigh(each["inertia"])
        axes[:, 0] *= np.linalg.det(axes)
        turn = rapier.Rotation3.from_scaled_axis(tuple(Rotation.from_matrix(axes).as_rotvec()))
        bodies.append(world.add_body(
            rapier.RigidBodyBuilder(rapier.RigidBodyType.DYNAMIC).translation(each["position"])
            .linvel(each["linear_velocity"]).angvel(each["angular_velocity"]).can_sleep(False)
            .additional_mass_properties(rapier.MassProperties((0, 0, 0), each["mass"], tuple(moments), turn))))
    for i, side, k, at in problem.balls(RADIUS, np.zeros(problem.nc)):
        ball = (rapier.Collider.ball(RADIUS).density(0.0).friction(float(problem.mu[i])).user_data(2 * i + side)
                .active_hooks(rapier.ActiveHooks.FILTER_CONTACT_PAIRS).translation(tuple(at)))
        world.add_collider(ball, bodies[k] if k >= 0 else None)

    def solve(_):
        timed(world.step)
        pushes = []
        for pair in world.narrow_phase.contact_pairs():
            i, side = divmod(world.colliders[pair.collider1].user_data, 2)
            for manifold in pair.manifolds:
                x, y, z = push = -np.array([manifold.data.normal.x, manifold.data.normal.y, manifold.data.normal.z])
                sign = np.copysign(1.0, z)
                scale = -1 / (sign + z)
                tangent = np.array([x * y * scale, sign + y * y * scale, -y])  # glam's any_orthonormal_vector()
                for point in manifold.points:
                    a, b = point.tangent_impulse
                    pushes.append((i, side, point.impulse * push + a * tangent + b * np.cross(push, tangent)))
        return problem.of_engine(pushes)

    return solve


serve(load)
