"""Times of active_set, from a problem's data to its answer, over those of Bullet's Dantzig alone, M and q given, as CSV.

    from_matrix.py LCPBENCH [ROUNDS] > from-matrix.csv

Bullet's time is that of its solve; forming M is its set-up and is not counted. That is a difference of two times, whose
least would be too little: of each problem the median of the rounds counts. Means over the problems that both solved and the evaluation verified. solved, bullet_solved: of all problems.
"""

import collections
import os
import sqlite3
import statistics
import subprocess
import sys
import tempfile

SEED = 20270401
PROBLEMS = 1000
BULLET = "bullet_dantzig{diagonal=1e-12}"
SETS = ["exp1", "exp2", "exp5-1e5", "exp5-1e8", "exp5-1e10", "exp5-1e10{redundancy=combination}"]
TIMES = """
  SELECT s.name, v.name, t.problem_id, t.setup_cpu_s, t.solve_cpu_s, judged.solved
  FROM timings t JOIN problems p ON p.id = t.problem_id JOIN sets s ON s.id = p.set_id
  JOIN solvers v ON v.id = t.solver_id
  JOIN verdicts judged ON judged.problem_id = t.problem_id AND judged.solver_id = t.solver_id"""


def run_once(program, runs):
    """runs: by set and problem, {solver: (times [s], whether it solved)}"""
    with tempfile.TemporaryDirectory() as folder:
        store = os.path.join(folder, "times.db")
        command = [program, "run", "--solver", "active_set", "--solver", BULLET]
        command += ["--trials", str(PROBLEMS), "--seed", str(SEED), "--store", store]
        for name in SETS:
            command += ["--set", f"paper/monotone/{name}"]
        subprocess.run(command, capture_output=True, check=True)
        for name, solver, problem, setup, solve, solved in sqlite3.connect(store).execute(TIMES):
            time = solve if solver == "bullet_dantzig" else setup + solve
            runs[name].setdefault(problem, {}).setdefault(solver, ([], solved))[0].append(time)


def main():
    runs = collections.defaultdict(dict)
    for _ in range(int(sys.argv[2]) if len(sys.argv) > 2 else 9):
        run_once(sys.argv[1], runs)
    print("set,problems,solved,bullet_solved,active_set_us,bullet_us,ratio")
    for name in (f"paper/monotone/{name}" for name in SETS):
        pairs = [(run["active_set"], run["bullet_dantzig"]) for run in runs[name].values()]
        both = [(own, bullet) for own, bullet in pairs if own[1] and bullet[1]]
        own_us = 1e6 * sum(statistics.median(own[0]) for own, _ in both) / len(both)
        bullet_us = 1e6 * sum(statistics.median(bullet[0]) for _, bullet in both) / len(both)
        print(f"{name},{len(pairs)},{sum(own[1] for own, _ in pairs)},{sum(bullet[1] for _, bullet in pairs)},"
              f"{own_us:.3f},{bullet_us:.3f},{own_us / bullet_us:.3f}", flush=True)


if __name__ == "__main__":
    main()
