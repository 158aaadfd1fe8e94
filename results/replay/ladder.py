#!/usr/bin/env python3
"""ladder.py LCPBENCH FOLDER STEPS FINEST SCENE[@ENGINE]...: how the error of exact steps on the round cone falls with the step, against steps of h / FINEST.

Each scene is stepped on over STEPS of its own steps h (a multiple of 30), and with h/4, h/16, ... for as long, and once more with the finest steps from
1e-12 m beside: from where these two are 0.1 mm apart, no position means anything (until_s). Prints CSV: error_m is the largest distance of a part from
where the finest steps have it, in up to 30 pictures until then; falls_by that of the row before over it; asymmetry_m how far the motion leaves the
mirror planes x = 0 and y = 0 that its first picture has (empty: none); hash the SHA-256 of the positions in all pictures of the finest steps.
"""
import hashlib
import json
import math
import pathlib
import struct
import subprocess
import sys

LCPBENCH, FOLDER, STEPS, FINEST = sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
CONE = "cone_ipm{cone=true}"


def motion(scene, divide, solver="--solver", stepper=CONE, nudge=""):
    """{time: positions of all parts} of one replay."""
    name, *engine = scene.split("@")
    spec = f"{name}{{divide={divide}{nudge}}}"
    folder = FOLDER / "@".join([spec, *engine])
    asked = ["--engine", *engine] if engine else []
    subprocess.run([LCPBENCH, "replay", spec, solver, stepper, *asked, "--steps", str(STEPS * divide), "--out", folder], check=True,
                   stdout=subprocess.DEVNULL)
    replay = json.loads((folder / "replays.json").read_text())["scenes"][0]["replays"][0]
    with open(folder / "steps" / replay["file"]) as file:
        next(file)
        frames = [json.loads(line) for line in file]
    every = STEPS * divide // 30
    return {frame["step"] // every: (frame["time"], [pose[:3] for pose in frame["poses"] if len(pose) == 7],
                                     frame["problem"].get("bodies", [])) for frame in frames if frame["step"] % every == 0}


def error(a, b, until):
    return max(math.dist(p, q) for k in a if k in b and k < until for p, q in zip(a[k][1], b[k][1]))


def asymmetry(frames, until):
    """The largest distance of a part from the mirror image of its partner; None without bodies in a mirror plane."""
    worst = None
    _, first, bodies = frames[0]
    for axis in (0, 1):
        def image(p):
            return [-p[i] if i == axis else p[i] for i in range(3)]

        def rounded(velocities):
            return sorted([round(x, 9) + 0.0 for x in v] for v in velocities)
        moved = [(body["linear_velocity"], body["angular_velocity"]) for body in bodies]
        turned = [image(linear) + [-x for x in image(angular)] for linear, angular in moved]
        partners = [min(range(len(first)), key=lambda j: math.dist(image(p), first[j])) for p in first]
        if bodies and rounded(linear + angular for linear, angular in moved) == rounded(turned) and all(
                math.dist(image(p), first[j]) < 1e-12 for p, j in zip(first, partners)):
            apart = max(math.dist(image(p), now[j]) for k, (_, now, _) in frames.items() if k < until for p, j in zip(now, partners))
            worst = max(apart, worst or 0)
    return worst


def number(value):
    return "" if value is None else f"{value:.3g}"


def main():
    print("scene,stepper,divide,until_s,parts,error_m,falls_by,asymmetry_m,hash")
    for scene in sys.argv[5:]:
        truth = motion(scene, FINEST)
        beside = motion(scene, FINEST, nudge=",nudge=1e-12")
        parted = [k for k in truth if k in beside and max(map(math.dist, truth[k][1], beside[k][1])) > 1e-4]
        until = min(parted, default=31)
        ends = truth[until][0] if parted else max(time for time, _, _ in truth.values())
        before = None
        for stepper, divide in [("nothing", 1)] + [(f"exact{{solver={CONE}}}", 4**k) for k in range(round(math.log(FINEST, 4)) + 1)]:
            frames = truth if divide == FINEST else motion(scene, divide, "--stepper", stepper)
            wrong = error(frames, truth, until)
            falls = before / wrong if divide > 1 and before and wrong > 0 else None
            sha = hashlib.sha256(b"".join(struct.pack("<3d", *p) for _, places, _ in truth.values() for p in places)).hexdigest()
            print(",".join([scene, stepper, str(divide), f"{ends:.3g}", "yes" if parted else "no", number(wrong), number(falls),
                            number(asymmetry(frames, until)), sha[:16] if divide == FINEST else ""]), flush=True)
            before = wrong


if __name__ == "__main__":
    main()
