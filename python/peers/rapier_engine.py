#!/usr/bin/env python3
"""Rapier as an engine of `lcpbench capture` and `replay` (docs/reference/external.md).

rapier_engine.py [coulomb]: all settings are Rapier's, but for sleep, of which there is none. Its own model of friction
tells no impulses of friction: with `coulomb`, Rapier's other model, a step has the engine's impulses.
"""
import importlib.metadata
import sys

import numpy as np
import peer
import rapier3d as rapier
from scipy.spatial.transform import Rotation


class Engine:
    def __init__(self, scene):
        self.motions = [each["motion"] for each in scene["bodies"]]
        self.parts = [(k, part) for k, each in enumerate(scene["bodies"]) for part in each["parts"]]
        self.world = rapier.PhysicsWorld()  # without gravity: it comes with the forces
        self.world.integration_parameters.dt = scene["step"]
        if len(sys.argv) > 1:
            self.world.integration_parameters.friction_model = rapier.FrictionModel.COULOMB
        self.bodies = []
        for each in scene["bodies"]:
            kind = rapier.RigidBodyType.DYNAMIC if each["mass"] > 0 else rapier.RigidBodyType.FIXED
            mass = rapier.MassProperties((0, 0, 0), each["mass"], tuple(each["inertia"]), rapier.Rotation3.identity())
            body = rapier.RigidBodyBuilder(kind).can_sleep(False).gyroscopic_forces(False)
            self.bodies.append(self.world.add_body(body.additional_mass_properties(mass)))
        self.place(self.motions)
        for number, (k, part) in enumerate(self.parts):
            shape = rapier.Collider.cuboid(*part["box"]) if "box" in part else rapier.Collider.ball(part["sphere"])
            shape = shape.density(0.0).friction(scene["mu"]).restitution(scene["restitution"]).user_data(number)
            self.world.add_collider(shape.translation(tuple(part["offset"])), self.bodies[k])

    def place(self, motions):
        self.motions = motions
        for handle, motion in zip(self.bodies, motions):
            body = self.world.rigid_bodies[handle]
            body.position = rapier.Isometry3(tuple(motion[:3]), rapier.Rotation3.from_quaternion(*motion[3:7]))
            if body.is_dynamic:
                body.linvel, body.angvel = tuple(motion[7:10]), tuple(motion[10:])
        return {}

    def step(self, forces):
        """One step under each body's force [N] and torque [N m]. The contacts are those as it began."""
        bodies = [self.world.rigid_bodies[each] for each in self.bodies]
        for body, force in zip(bodies, forces):
            if body.is_dynamic:
                body.reset_forces()
                body.reset_torques()
                body.add_force(tuple(force[:3]))
                body.add_torque(tuple(force[3:]))
        self.world.step()
        contacts = self.contacts()  # from self.motions, which are still those before the step
        stages = self.world.physics_pipeline.counters.stages
        self.motions = []
        for body in bodies:
            p, q, v, w = body.translation, body.rotation, body.linvel, body.angvel
            self.motions.append([p.x, p.y, p.z, q.w, q.i, q.j, q.k, v.x, v.y, v.z, w.x, w.y, w.z])
        return dict(contacts=contacts, motions=self.motions,
                    solve_s=1e-3 * (stages.island_constraints_collection_time_ms + stages.solver_time_ms))

    def contacts(self):
        turns = Rotation.from_quat(np.array(self.motions)[:, [4, 5, 6, 3]]).as_matrix()
        found = []
        for pair in self.world.narrow_phase.contact_pairs():
            parts = [self.parts[self.world.colliders[each].user_data] for each in (pair.collider1, pair.collider2)]
            for manifold in pair.manifolds:
                out = manifold.data.normal
                x, y, z = normal = -np.array([out.x, out.y, out.z])  # into the first shape
                sign = np.copysign(1.0, z)
                scale = -1 / (sign + z)
                tangent = np.array([x * y * scale, sign + y * y * scale, -y])  # glam's any_orthonormal_vector()
                for point in manifold.points:
                    ends = [self.motions[k][:3] + turns[k] @ np.add(part["offset"], [at.x, at.y, at.z])
                            for (k, part), at in zip(parts, (point.local_p1, point.local_p2))]
                    contact = dict(bodies=[k for k, _ in parts], normal=list(normal), point=list(sum(ends) / 2),
                                   gap=normal @ (ends[0] - ends[1]))
                    if len(sys.argv) > 1:
                        a, b = point.tangent_impulse
                        contact["impulse"] = list(point.impulse * normal + a * tangent + b * np.cross(normal, tangent))
                    found.append(contact)
        return found


peer.serve_engine("Rapier", importlib.metadata.version("rapier3d"), Engine)
