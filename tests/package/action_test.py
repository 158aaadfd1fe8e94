"""Runs the steps of action.yml as GitHub does: action_test.py SOURCE PROGRAM."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap

SOURCE, PROGRAM = map(pathlib.Path, sys.argv[1:])
ACTION = (SOURCE / "action.yml").read_text()
SOLVER = (SOURCE / "examples/external_solver.py").read_text()


def steps():
    for step in re.split(r"^    - name: ", ACTION, flags=re.M)[1:]:
        given = dict(re.findall(r"^        (\w+): \$\{\{ inputs\.(\w+) \}\}$", step, flags=re.M))
        yield given, textwrap.dedent(step.split("      run: |\n")[1])


def run(folder, inputs):
    """The exit code of the first step that fails, or 0, and all that was printed."""
    said = ""
    for given, script in steps():
        environment = {**os.environ, "PATH": f"{PROGRAM.parent}:{os.environ['PATH']}", "RUNNER_TEMP": folder,
                       "GITHUB_STEP_SUMMARY": f"{folder}/summary", "GITHUB_ACTION_PATH": str(SOURCE),
                       **{name: inputs[value] for name, value in given.items()}}
        done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", script], cwd=folder, env=environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        said += done.stdout
        if done.returncode != 0:
            return done.returncode, said
    return 0, said


with tempfile.TemporaryDirectory() as folder:
    for name, engine in (("a", "ode"), ("b", "bullet")):
        done = subprocess.run([PROGRAM, "capture", "slope", "--engine", engine, "--every", "20", "--steps", "60",
                               "--out", f"{folder}/{name}.scenes"], capture_output=True)
        if done.returncode != 0:
            sys.exit(77)  # built without these engines
    solver = pathlib.Path(folder, "mine.py")
    inputs = {"scenes": "a.scenes\n\nb.scenes\n", "solver": "external{command=./mine.py}", "baseline": "base.db"}

    def expect(text, code, words):
        solver.write_text(text)
        solver.chmod(0o755)
        found, said = run(folder, inputs)
        assert found == code and words in said, f"exit code {found}, expected {code} and '{words}':\n{said}"

    expect(SOLVER, 0, "base.db is new")
    expect(SOLVER, 0, "a tie with A")
    expect(SOLVER.replace("max(0.0, line[-1])", "2 * line[-1]"), 1, "newly wrong")
    gives_up = SOLVER.replace("table = [[", "return {'claim': 'iteration_limit'}\n    table = [[")
    expect(gives_up, 1, "no longer solved, 0 answers")
    expect(SOLVER, 0, "a tie with A")
    inputs["scenes"] = "missing.scenes"
    expect(SOLVER, 2, "missing.scenes")
