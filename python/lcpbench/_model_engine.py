"""Steps models of MuJoCo for the program `lcpbench`, as an engine of its protocol (docs/reference/external.md)."""

from __future__ import annotations

import json
import os
import sys
from typing import Any

import mujoco
import numpy as np

from . import _native
from ._files import pose_rows, rows
from .mujoco import capture, shapes

MARGIN = 1e-4  # [m] up to which a solver in the loop gets open contacts


def _place(model: Any, data: Any, name: str) -> np.ndarray:
    for kind, places in ((mujoco.mjtObj.mjOBJ_BODY, data.xpos), (mujoco.mjtObj.mjOBJ_GEOM, data.geom_xpos),
                         (mujoco.mjtObj.mjOBJ_SITE, data.site_xpos)):
        index = mujoco.mj_name2id(model, kind, name)
        if index >= 0:
            return places[index]
    raise ValueError(f"the model has no body, geometry or site '{name}'")


class _Engine:
    def model(self, file: str, soft: str, marks: list[str]) -> dict[str, Any]:
        self._model = model = mujoco.MjModel.from_xml_path(file)
        self._data, self._soft = mujoco.MjData(model), soft
        if model.nkey:
            mujoco.mj_resetDataKeyframe(model, self._data, 0)
        if soft in ("newton", "cg", "pgs", "exact"):
            model.opt.solver = getattr(mujoco.mjtSolver, "mjSOL_" + ("NEWTON" if soft == "exact" else soft.upper()))
        if soft == "exact":
            model.opt.iterations, model.opt.tolerance = 1000, 0
        free = model.jnt_bodyid[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
        self._marks = [_place(model, self._data, each) for each in marks] or [self._data.xpos[each] for each in free]
        mujoco.mj_forward(model, self._data)
        capture(model, self._data, soft=bool(soft), stepped=False)  # refuses what is outside
        drawn = shapes(model)
        self._drawn = [body for body, _, _ in drawn]
        return {"engine": "MuJoCo", "version": mujoco.mj_versionString(), "step_length": model.opt.timestep,
                "gravity": model.opt.gravity.tolist(), "free": len(free),
                "shapes": [{"type": kind, "size": list(size)} for _, kind, size in drawn]}

    def step(self, loop: bool) -> dict[str, Any]:
        model, data = self._model, self._data
        if loop:
            if model.na:
                raise ValueError("the model's actuators have activations, which MuJoCo's own solver moves on: use --loop "
                                 "engine")
            np.maximum(model.geom_margin, MARGIN + model.geom_gap, out=model.geom_margin)
        mujoco.mj_forward(model, data)
        marks = [each.tolist() for each in self._marks]
        rk4 = not loop and model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
        if not loop and not rk4:
            euler = model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER
            (mujoco.mj_Euler if euler else mujoco.mj_implicit)(model, data)
        step = capture(model, data, soft=bool(self._soft), stepped=not loop)
        if rk4:  # captured is its first stage
            mujoco.mj_RungeKutta(model, data, 4)
        reply = {"problem": json.loads(_native.problem_json(step.problem._data)), "gap": step.gap.tolist(),
                 "ids": step.contact_ids, "frames": rows(step.contact_frames), "marks": marks,
                 "poses": pose_rows(step.poses[self._drawn]).tolist(), "notes": step.notes}
        if not loop:
            reply.update(impulses=step.impulses.tolist(), row_impulses=step.row_impulses.tolist(), velocity=step.velocity.tolist())
        return reply

    def place(self, velocity: list[float], moving: list[float]) -> dict[str, Any]:
        """The velocity after the step, and the one that the bodies move along."""
        model, data = self._model, self._data
        data.qvel[:] = velocity
        mujoco.mj_integratePos(model, data.qpos, np.array(moving), model.opt.timestep)
        data.time += model.opt.timestep
        return {}


def main() -> None:
    out, engine = os.fdopen(os.dup(1), "w"), _Engine()
    os.dup2(2, 1)  # what MuJoCo prints is no answer
    for line in sys.stdin:
        request = json.loads(line)
        try:
            print(json.dumps(getattr(engine, request.pop("verb"))(**request)), file=out, flush=True)
        except (ValueError, mujoco.FatalError) as error:
            sys.exit(" ".join(str(error).split()))


if __name__ == "__main__":
    main()
