#!/usr/bin/env python3
"""PyPI's MuJoCo as an engine of `lcpbench replay --engine external{...}` (docs/reference/external.md).

All settings are MuJoCo's defaults; nothing sleeps. `solve_s` is the processor time of the whole step.
"""
import time

import mujoco
import numpy as np
import peer


class Engine:
    def __init__(self, scene):
        spec = mujoco.MjSpec()
        spec.option.timestep = scene["step"]
        spec.option.gravity = [0, 0, 0]  # it comes with the forces
        self.moves = [each["mass"] > 0 for each in scene["bodies"]]
        self.motions = [each["motion"] for each in scene["bodies"]]
        for each, moves in zip(scene["bodies"], self.moves):
            at, turn = each["motion"][:3], each["motion"][3:7]
            body = spec.worldbody.add_body(pos=at, quat=turn)
            if moves:
                body.add_freejoint()
                body.mass, body.inertia, body.explicitinertial = each["mass"], each["inertia"], True
                body.ipos, body.iquat = [0, 0, 0], [1, 0, 0, 0]
            for part in each["parts"]:
                shape = dict(type=mujoco.mjtGeom.mjGEOM_BOX, size=part["box"]) if "box" in part else dict(
                    type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[part["sphere"], 0, 0])
                body.add_geom(pos=part["offset"], friction=[scene["mu"], 0.005, 0.0001], mass=0, **shape)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.place(self.motions)

    def place(self, motions):
        self.motions, at = motions, 0
        for motion, moves in zip(motions, self.moves):
            if not moves:
                continue
            turn = np.zeros(9)
            mujoco.mju_quat2Mat(turn, np.array(motion[3:7]))
            self.data.qpos[7 * at:7 * at + 7] = motion[:7]
            self.data.qvel[6 * at:6 * at + 3] = motion[7:10]
            self.data.qvel[6 * at + 3:6 * at + 6] = turn.reshape(3, 3).T @ motion[10:]  # about the body's own axes
            at += 1
        return {}

    def step(self, forces):
        """One step under each body's force [N] and torque [N m]. The contacts are those as it began."""
        self.data.xfrc_applied[1:] = forces
        start = time.process_time()
        mujoco.mj_step(self.model, self.data)
        solve_s = time.process_time() - start
        contacts, at, motions = self.contacts(), 0, []
        for motion, moves in zip(self.motions, self.moves):
            if moves:
                turn = np.zeros(9)
                qpos, qvel = self.data.qpos[7 * at:7 * at + 7], self.data.qvel[6 * at:6 * at + 6]
                mujoco.mju_quat2Mat(turn, qpos[3:])
                motion = [*qpos, *qvel[:3], *(turn.reshape(3, 3) @ qvel[3:])]
                at += 1
            motions.append([float(x) for x in motion])
        self.motions = motions
        return dict(contacts=contacts, motions=motions, solve_s=solve_s)

    def contacts(self):
        found, force = [], np.zeros(6)
        for number, contact in enumerate(self.data.contact[:self.data.ncon]):
            frame = contact.frame.reshape(3, 3)
            mujoco.mj_contactForce(self.model, self.data, number, force)
            bodies = [int(self.model.geom_bodyid[geom]) - 1 for geom in contact.geom]
            impulse = -self.model.opt.timestep * (frame.T @ force[:3])  # MuJoCo's normal points into the second body
            found.append(dict(bodies=bodies, normal=list(-frame[0]), point=list(contact.pos), gap=float(contact.dist),
                              impulse=list(impulse)))
        return found


peer.serve_engine("MuJoCo", mujoco.__version__, Engine)
