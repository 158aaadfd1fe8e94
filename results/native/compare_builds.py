"""Times of native solvers in two builds of lcpbench, in turns, as CSV.

    compare_builds.py OLD NEW [ROUNDS] > builds.csv

OLD, NEW: lcpbench executables. Each round runs `bench` once with either, on the same 500 problems; its time is the mean
over them, from the data to the answer. least_ratio: of the least times of the rounds; median_ratio: the median of the
ratios of one round.
"""

import json
import statistics
import subprocess
import sys

SEED = 20270401
PROBLEMS = 500
CELLS = [
    ("contact_lemke", "paper/copositive/exp1"),
    ("contact_lemke", "paper/copositive/exp5-1e10"),
    ("contact_lemke", "paper/monotone/exp1"),
    ("active_set", "paper/monotone/exp1"),
]


def bench(program, solver, problems):
    command = [program, "bench", "--set", problems, "--solver", solver, "--reference", solver]
    command += ["--problems", str(PROBLEMS), "--seed", str(SEED), "--format", "json"]
    result = json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)
    cell = result["cells"][0]
    return result["provenance"]["commit"], min(cell["reference_mean_s"], cell["solver_mean_s"]) * 1e6


def main():
    old, new = sys.argv[1:3]
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 9
    print("set,solver,old_commit,new_commit,old_us,new_us,least_ratio,median_ratio")
    for solver, problems in CELLS:
        times = {old: [], new: []}
        commits = {}
        for _ in range(rounds):
            for program in (old, new):
                commits[program], time = bench(program, solver, problems)
                times[program].append(time)
        least = min(times[new]) / min(times[old])
        median = statistics.median(b / a for a, b in zip(times[old], times[new]))
        print(f"{problems},{solver},{commits[old]},{commits[new]},{min(times[old]):.2f},{min(times[new]):.2f},"
              f"{least:.3f},{median:.3f}", flush=True)


if __name__ == "__main__":
    main()
