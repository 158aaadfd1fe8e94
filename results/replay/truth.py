#!/usr/bin/env python3
"""truth.py LCPBENCH FOLDER STEPS FINEST SCENE...: how far steppers at their defaults are from exact steps of h / FINEST on the round cone.

As ladder.py: STEPS is a multiple of 30, and no position means anything from where the steps of h / FINEST and those that begin 1e-12 m beside are
0.1 mm apart (until_s). Prints CSV.
"""
import math
import sys

from ladder import CONE, error, motion, number

STEPPERS = [(f"exact{{solver={CONE}}}", 1), (f"exact{{solver={CONE}}}", 4)] + [
    (name, 1) for name in ("exact", "convex", "pgs", "sequential_impulses", "soft_step", "xpbd", "admm", "apgd", "nothing")]
print("scene,stepper,divide,until_s,parts,error_m,to_the_end")
for scene in sys.argv[5:]:
    truth = motion(scene, int(sys.argv[4]))
    beside = motion(scene, int(sys.argv[4]), nudge=",nudge=1e-12")
    parted = [k for k in truth if k in beside and max(map(math.dist, truth[k][1], beside[k][1])) > 1e-4]
    until = min(parted, default=31)
    ends = truth[until][0] if parted else max(time for time, _, _ in truth.values())
    for stepper, divide in STEPPERS:
        frames = motion(scene, divide, "--stepper", stepper)
        to_the_end = all(k in frames for k in truth if k < until)
        print(f'{scene},"{stepper}",{divide},{ends:.3g},{"yes" if parted else "no"},{number(error(frames, truth, until))},'
              f'{"yes" if to_the_end else "no"}', flush=True)
