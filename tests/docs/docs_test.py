#!/usr/bin/env python3
"""Checks the documents against the project.

    docs_test.py links                     every relative link and every docs/ path in the sources leads somewhere
    docs_test.py tables LCPBENCH [--write] tables that are made from the program or from results/ are up to date; --write brings them up to date
    docs_test.py specs LCPBENCH            the program takes every solver with settings that pages, plans and results name
    docs_test.py tutorial PAGE LCPBENCH    the commands of a tutorial run, and print the counts of wrong answers that it states

In a tutorial a fence ```sh is run, and a fence with a file name, as in ```python mine.py, is written to that file.
Exit codes: 0 done, 1 a check failed.
"""
import csv
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from paper_tables import paper_table

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SOURCES = ("adapters", "cmake", "core", "examples", "generators", "native", "python", "study", "tests")
# Solvers with settings that the program refuses, by their beginning, and why they stand somewhere all the same.
REFUSED = {
    "lemke{rules=2012}": "results of an earlier program", "lemke{cap=lemke,rules=2012}": "the same",
    "primal_dual{rules=2012}": "the same",
    "auto{error=$t}": "a loop of the shell", "auto{error=rho}": "rho is a number", "regularized{solver=...}": "a form",
    "auto{start=last}": "how --start last names its second runs",
}
# Solvers that the program had: the rows of earlier commits in results/ name them, nothing else may.
GONE = ("quickstep_sor",)
# The text of the store's tables is part of its format, comments included: it keeps the path that the page had.
OLD_PATHS = {("study/store/schema.cpp", "docs/certificates.md")}


def documents():
    """All pages, the generated page of the paper's study included."""
    yield from sorted(ROOT.glob("*.md"))
    for folder in ("docs", "examples", "results", "tests"):
        yield from sorted((ROOT / folder).rglob("*.md"))


def without_code(text):
    return re.sub(r"`[^`\n]*`", "", re.sub(r"^```.*?^```", "", text, flags=re.S | re.M))


def anchors(page):
    """The anchors that GitHub gives to the headings of a page."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.S | re.M)
    headings = re.findall(r"^#+ (.*)$", text, flags=re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def broken_links():
    for page in documents():
        for link in re.findall(r"\]\(([^)\s]+)\)", without_code(page.read_text())):
            if "://" in link or link.startswith("mailto:"):
                continue
            path, _, anchor = link.partition("#")
            target = (page.parent / path).resolve() if path else page
            if not target.exists():
                yield f"{page.relative_to(ROOT)}: ({link}) leads nowhere"
            elif anchor and anchor not in anchors(target):
                yield f"{page.relative_to(ROOT)}: ({link}): no such heading"


def broken_paths():
    files = [file for folder in SOURCES for file in sorted((ROOT / folder).rglob("*"))]
    files += list(ROOT.glob("run-*"))
    for file in files + list(documents()):
        name = str(file.relative_to(ROOT))
        if not file.is_file() or file == pathlib.Path(__file__).resolve():
            continue
        if "node_modules" in file.parts:  # of the report's page, where npm put them
            continue
        try:
            text = file.read_text()
        except UnicodeDecodeError:
            continue
        for path in re.findall(r"(?<![\w./-])docs/[\w./-]*\w", text):
            if not (ROOT / path).exists() and (name, path) not in OLD_PATHS:
                yield f"{name}: {path} does not exist"


def unlisted_pages():
    index = (ROOT / "docs/index.md").read_text()
    listed = {(ROOT / "docs" / link).resolve() for link in re.findall(r"\]\(([^)#\s]+)", index)}
    for page in sorted((ROOT / "docs").rglob("*.md")):
        if page.name != "index.md" and page.resolve() not in listed and page.parent.resolve() not in listed:
            yield f"docs/index.md does not list {page.relative_to(ROOT)}"


def misnamed_tables():
    """Tables of the report that exist or that its page lists, not both; paper-* stands for several."""
    rows = re.findall(r"^\| ((?:`[\w*-]+`(?:, )?)+) \|", (ROOT / "docs/howto/report.md").read_text(), flags=re.M)
    listed = {name for row in rows for name in re.findall(r"`([\w*-]+)`", row)}
    tables = {file.stem for file in (ROOT / "study/report/tables").glob("*.sql")}
    tables = {"paper-*" if name.startswith("paper-") else name for name in tables}
    for name in sorted(listed ^ tables):
        yield f"docs/howto/report.md: the table {name} {'does not exist' if name in listed else 'is not listed'}"


def check_links():
    faults = [*broken_links(), *broken_paths(), *unlisted_pages(), *misnamed_tables()]
    print("\n".join(faults) or "all links lead somewhere")
    return 1 if faults else 0


def cell(text):
    """As a cell of a table. Bars are escaped, and limits that only say "any number" are left out."""
    text = re.sub(r", (1099511627776|1000000000)\]", ", ...)", text)
    return re.sub(r"([|<*_])", r"\\\1", text)


def settings_table(solver):
    if not solver["settings"]:
        return "It has no settings.\n"
    lines = ["| setting | default | range | meaning |", "| --- | --- | --- | --- |"]
    for setting in solver["settings"]:
        default = f"`{setting['default']}`" if setting["default"] else ""
        help_text = cell(setting["help"])
        lines.append(f"| `{setting['name']}` | {default} | {cell(setting['range'])} | {help_text} |")
    return "\n".join(lines) + "\n"


def percent(share):
    return f"{100 * float(share):.1f}".removesuffix(".0")


def seconds(text):
    value = float(text)
    unit, factor = next((u, f) for u, f in (("s", 1), ("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9)) if value >= f)
    return f"{value / factor:.3g} {unit}" if value / factor < 100 else f"{value / factor:.0f} {unit}"


LEAST_PROBLEMS = 35  # that carry a factor, as in the report


def factor(value):
    return f"{value:.1f}" if value < 10 else f"{value:.0f}" if value < 1000 else f"{round(value, -1):.0f}"


def solved_of_met(row):
    """The share solved, the refused problems among the whole; below 35 problems as a count."""
    solved, met = int(row["solved.part"]), int(row["solved.whole"])
    if row["solver"] != "engine":  # whose answers were not kept where it solved other contacts
        met += int(row["refused.part"])
    return f"{percent(solved / met)} %" if met >= LEAST_PROBLEMS else f"{solved} of {met}"


SCENES = ("auto", "contact_lemke", "contact_ipm", "friction_ipm", "psor", "cone_ipm{cone=true}", "siconos_fc3d{cone=true}",
          "siconos_fc3d{cone=true,tolerance=1e-04}", "dart_lemke", "ipopt_mpcc", "simbody_plus{cone=true}", "ode_quickstep{iterations=1000}", "ode_quickstep",
          "dart_dantzig", "bullet_si{iterations=1000}", "bullet_si")


def scenes_table(solvers=()):
    """Solvers on captured steps; without names all of them."""
    with open(ROOT / "results/scenes/decision.csv", newline="") as file:
        rows = {(row["contacts"], row["solver"]): row for row in csv.DictReader(file)}
    scenes = ("A robot's step", "Stacks and walls", "Piles", "Other scenes")

    def missed(solver):
        solved, met = (sum(int(row["solved." + part]) for (_, name), row in rows.items() if name == solver) for part in ("part", "whole"))
        return 1 - solved / met

    lines = ["| solver | robots | stacks, walls | piles | other scenes | wrong |", "| --- | --- | --- | --- | --- | --- |"]
    for solver in solvers or sorted(dict.fromkeys(solver for _, solver in rows), key=missed):
        taken = [rows[scene, solver] if (scene, solver) in rows else None for scene in scenes]
        cells = [", ".join([solved_of_met(row), *([seconds(row["mean_time_s.value"])] if row["mean_time_s.value"] else [])])
                 if row and row["solved.whole"] != "0" else "-" for row in taken]
        wrong, of = (sum(int(row[f"false_claims.{part}"]) for row in taken if row) for part in ("part", "whole"))
        wrong = "-" if solver == "engine" else f"{wrong} of {of}"  # an engine claims nothing about hard contacts
        lines.append(f"| `{solver}` | {' | '.join(cells)} | {wrong} |")
    return "\n".join(lines) + "\n"


def length(metres):
    return f"{metres:.2g} m" if metres >= 0.1 else f"{100 * metres:.2g} cm" if metres >= 0.01 else \
        f"{1000 * metres:.2g} mm" if metres >= 5e-7 else "0"


def way(row, lost):
    """How far moved what should not, or sank, and the processor time for a second of the scene."""
    metres = row["slip_m"] or row["drift_m"] or row["deepest_m"] or "nan"
    if int(row["survived"]) < int(row["steps"]):
        return lost  # its time would be that of a scene that has fallen
    return length(float(metres)) + (f", {seconds(row['cpu_s_per_s'])}" if row["cpu_s_per_s"] else "")  # an engine may tell none


def steps_table():
    """What a second of a scene becomes, and what it costs, in the ways of results/replay/steps.py, for the README."""
    rows = {}
    for table in ("steps", "box3d"):  # Box3D was measured by itself: results/replay/README.md
        with open(ROOT / f"results/replay/{table}.csv", newline="") as file:
            rows |= {(row["scene"], row["stepper"], row["engine"]): row for row in csv.DictReader(file)}
    scenes = {"pyramid-55": "55-cube pyramid", "wall": "wall", "mass-ratio-1e4": "10 t on 1 kg", "gripper": "gripper", "box-pile": "falling pile"}
    names = {("exact", "ODE"): "`auto`", ("exact{solver=auto{error=1e-04}}", "ODE"): "`auto{{error=1e-4}}`",
             ("sequential_impulses", "ODE"): "`sequential_impulses`, 8 sweeps", ("sequential_impulses{iterations=50}", "ODE"): "the same, 50 sweeps",
             ("engine", "Bullet"): "Bullet {}", ("engine", "DART"): "DART {}", ("engine", "MuJoCo"): "MuJoCo {}, whole step",
             ("engine", "Box3D"): "Box3D {}, whole step, another machine"}
    lines = ["| step by | " + " | ".join(scenes.values()) + " |", "| --- " * (len(scenes) + 1) + "|"]
    for (stepper, engine), name in names.items():
        cells = [rows.get((scene, stepper, engine)) for scene in scenes]
        if any(cells):
            version = next(row for row in cells if row)["version"]
            lines.append(f"| {name.format(version)} | {' | '.join(way(row, 'lost') if row else '-' for row in cells)} |")
    return "\n".join(lines) + "\n"


def replay_table(engine):
    """The same for all scenes whose contacts that engine finds, in results/replay/summary.csv, a column for each stepper."""
    rows = replayed(engine)
    columns = list(dict.fromkeys(stepper for _, stepper in rows if stepper != "nothing"))
    titles = {"exact": "`auto`", "exact{solver=cone_ipm{cone=true}}": "`cone_ipm{cone=true}`", "pgs{iterations=1,substeps=10}": "10 substeps of `pgs`",
              "engine": "the engine"}
    lines = ["| scene | " + " | ".join(titles.get(column, f"`{column}`") for column in columns) + " |", "| --- " * (len(columns) + 1) + "|"]
    for scene in dict.fromkeys(scene for scene, _ in rows):
        lines.append(f"| {scene} | {' | '.join(way(row, 'lost at ' + row['survived']) for row in (rows[scene, column] for column in columns))} |")
    return "\n".join(lines) + "\n"


def replayed(engine):
    with open(ROOT / "results/replay/summary.csv", newline="") as file:
        return {(row["scene"], row["stepper"]): row for row in csv.DictReader(file) if row["engine"] == engine}


def engines_table():
    """Other engines as they are shipped, and `auto` with the contacts that each finds."""
    engines = ("Bullet", "Rapier", "Jolt")
    rows = {engine: replayed(engine) for engine in engines}
    lines = ["| scene | " + " | ".join(f"{engine} | `auto`" for engine in engines) + " |", "| --- " * (2 * len(engines) + 1) + "|"]
    for scene in dict.fromkeys(scene for scene, _ in rows[engines[0]]):
        cells = (way(row, "lost at " + row["survived"]) for engine in engines for row in (rows[engine][scene, "engine"], rows[engine][scene, "exact"]))
        lines.append(f"| {scene} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


WARM = ("auto", "auto{error=1e-04}", "siconos_fc3d{cone=true,tolerance=1e-04}", "dart_pgs", "bullet_si", "contact_lemke", "psor")


def warm_table():
    """Solvers on consecutive steps, from nothing and from their last answers."""
    with open(ROOT / "results/warm/warm.csv", newline="") as file:
        rows = {(row["scene"], row["solver"], row["start"]): row for row in csv.DictReader(file)}
    scenes = ("stack", "wall", "sphere-pile", "quadruped-trotting")
    lines = ["| solver | starts from | " + " | ".join(scenes) + " |", "| --- " * (len(scenes) + 2) + "|"]
    for solver in WARM:
        for start in ("nothing", "last"):
            taken = [rows.get((scene, solver, start)) for scene in scenes]
            if not any(taken):
                continue
            cells = [f"{solved_share(row)}, {float(row['median_error']):.0e}, {seconds(row['median_time_s'])}"
                     if row and row["steps"] != row["refused"] else "-" for row in taken]
            name = f"`{solver}`" if start == "nothing" else ""
            words = start if start == "nothing" else "its last answer"
            lines.append(f"| {name} | {words} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def solved_share(row):
    return f"{percent(int(row['solved']) / (int(row['steps']) - int(row['refused'])))} %"


PEERS = {"auto": "`auto`", "contact_lemke": "`contact_lemke`", "drake_lcp.py moby": "Drake `MobyLcpSolver`",
         "drake_lcp.py unrevised": "Drake `UnrevisedLemkeSolver`", "pinocchio_cone.py admm": "Pinocchio ADMM, the round cone",
         "pinocchio_cone.py pgs": "Pinocchio PGS, the round cone", "convex.py proxqp relaxed": "ProxQP, relaxed friction",
         "convex.py clarabel relaxed": "Clarabel, relaxed friction", "convex.py scs relaxed": "SCS, relaxed friction",
         "drake_sap.py": "a step of Drake, SAP", "mujoco_step.py newton": "a step of MuJoCo, Newton's method",
         "mujoco_step.py cg": "a step of MuJoCo, CG", "mujoco_step.py pgs": "a step of MuJoCo, PGS",
         "newton_step.py": "a step of Newton, SolverSteel", "rapier_step.py": "a step of Rapier, as shipped",
         "rapier_step.py 1000": "a step of Rapier, 1,000 sweeps", "jolt_step.py": "a step of Jolt, as shipped",
         "jolt_step.py 1000": "a step of Jolt, 1,000 sweeps"}


def peers_table():
    """Packages of PyPI and npm on captured steps: share solved, time from outside, and the time that they report."""
    with open(ROOT / "results/peers/shares.csv", newline="") as file:
        rows = {(row["contacts"], row["solver"]): row for row in csv.DictReader(file)}
    scenes = ("A robot's step", "Stacks and walls", "Piles", "Other scenes")
    lines = ["| solver | a robot's step | stacks and walls | piles | other scenes | said solved, was wrong |",
             "| --- | --- | --- | --- | --- | --- |"]
    for solver in PEERS:
        cells, wrong, of = [], 0, 0
        for row in (rows[scene, solver] for scene in scenes):
            problems = int(row["problems"])
            wrong, of = wrong + int(row["false_claims"]), of + problems
            share = f"{percent(int(row['solved']) / problems)} %" if problems >= LEAST_PROBLEMS else f"{row['solved']} of {problems}"
            reported = f" ({seconds(row['mean_reported_s'])})" if row["mean_reported_s"] else ""
            cells.append(f"{share}, {seconds(row['mean_time_s'])}{reported}" if problems else "-")
        lines.append(f"| {PEERS[solver]} | {' | '.join(cells)} | {wrong} of {of} |")
    return "\n".join(lines) + "\n"


def study_table(name):
    """The table of this name, of README and of pages of results."""
    made = {"scenes": lambda: scenes_table(SCENES), "all-scenes": scenes_table, "steps": steps_table, "peers": peers_table, "warm": warm_table,
            "bodies": lambda: replay_table("ODE"), "robots": lambda: replay_table("MuJoCo"), "engines": engines_table}
    if name in made:
        return made[name]()
    with open(ROOT / "results/quick/decision.csv", newline="") as file:
        rows = {(row["contacts"], row["solver"]): row for row in csv.DictReader(file)}
    lines = ["| contacts | solver | of | solved (95 %) | wrong | time | times as long (95 %) |", "| --- " * 7 + "|"]
    chosen = {"Frictionless": ("active_set", "auto", "lemke", "lemke{engine=dense}", "bullet_dantzig{diagonal=1e-12}", "bullet_dantzig", "dart_lemke", "siconos_pgs", "siconos_lemke", "ipopt_qp"),
              "Frictional": ("contact_lemke", "auto", "lemke", "lemke{engine=dense}", "dart_lemke", "ipopt_mpcc", "siconos_newton_fb", "siconos_lemke", "bullet_lemke"),
              "Ill-conditioned, frictionless": ("active_set", "auto", "lemke", "dart_lemke", "siconos_lemke"),
              "Ill-conditioned, frictional": ("contact_lemke", "auto", "lemke", "lemke{engine=dense}", "dart_lemke", "siconos_lemke", "ipopt_mpcc")}
    for contacts, solvers in chosen.items():
        for solver in solvers:
            row = rows[contacts, solver]
            assert row["refused.part"] == "0", "a share of the problems taken is none of the problems met"
            share = f"{percent(row['solved.share'])} % ({percent(row['solved.low'])}-{percent(row['solved.high'])})"
            value, low, high = (row["factor." + part] for part in ("value", "low", "high"))
            long = f"{factor(float(value))} ({factor(float(low))}-{factor(float(high))}), n {row['factor.problems']}" if low else "-"
            if low and int(row["factor.problems"]) < LEAST_PROBLEMS:
                long = f"- (n {row['factor.problems']})"
            lines.append(f"| {contacts.lower() if solver == solvers[0] else ''} | `{solver}` | {row['solved.whole']} | {share} | "
                         f"{percent(row['false_claims.share'])} % | {seconds(row['mean_time_s.value'])} | {long} |")
    return "\n".join(lines) + "\n"


def with_tables(text, solvers):
    makers = {"settings": lambda name, _: settings_table(solvers[name]),
              "study": lambda name, _: study_table(name), "paper": paper_table}
    pattern = r"(<!-- (settings|study|paper): ([\w-]+) -->\n)(.*?)(<!-- end -->)"
    return re.sub(pattern, lambda match: match[1] + makers[match[2]](match[3], match[4]) + match[5], text, flags=re.S)


def check_tables(lcpbench, write):
    output = subprocess.run([lcpbench, "solvers", "--format", "json"], capture_output=True, text=True, check=True)
    solvers = {solver["name"]: solver for solver in json.loads(output.stdout)}
    stale, tables = [], 0
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *(ROOT / f"results/{each}/README.md" for each in ("paper", "peers", "quick", "replay", "scenes", "warm"))]:
        text = page.read_text()
        tables += text.count("<!-- end -->")
        wanted = with_tables(text, solvers)
        if wanted != text:
            stale.append(str(page.relative_to(ROOT)))
            if write:
                page.write_text(wanted)
    if stale and not write:
        print("stale tables in " + ", ".join(stale) + f"\nrun: tests/docs/docs_test.py tables {lcpbench} --write")
        return 1
    print(f"{tables} tables are up to date")
    return 0 if tables > 0 else 1


def check_specs(lcpbench):
    def listed(*arguments):
        return subprocess.run([lcpbench, "solvers", *arguments, "--format", "json"], capture_output=True, text=True)

    names = [each["name"] for each in json.loads(listed().stdout)] + list(GONE)
    files = [*ROOT.glob("*.md"), *(ROOT / "study").rglob("*.json")]
    for folder in ("docs", "results"):
        files += [each for suffix in ("md", "json", "csv") for each in (ROOT / folder).rglob("*." + suffix)]
    found = {}
    for file in files:
        for spec in re.findall(rf"(?<![\w/])(?:{'|'.join(names)})\{{[^{{}}\n]+\}}", file.read_text()):
            found.setdefault(spec, str(file.relative_to(ROOT)))
    of_results = tuple(name + "{" for name in GONE)
    known = {each for each in found if each.startswith(tuple(REFUSED))}
    known |= {each for each, file in found.items() if each.startswith(of_results) and file.startswith("results/")}
    refused = {each: done.stderr.strip() for each in found if (done := listed(each)).returncode != 0}
    for spec in sorted(set(refused) - known):
        print(f"{found[spec]}: {spec}: {refused[spec]}")
    for start in REFUSED:
        if not any(each.startswith(start) for each in refused):
            print(f"{start}: stands nowhere, or is not refused: take it out of REFUSED")
            return 1
    print(f"{len(found)} solvers with settings, {len(known)} of them known to be refused")
    return 0 if set(refused) <= known and len(found) > len(known) else 1


def run_tutorial(page, lcpbench):
    """Runs the page as a reader does, from a folder that holds the examples."""
    program = pathlib.Path(lcpbench).resolve()
    environment = dict(os.environ, PATH=f"{program.parent}:{os.environ['PATH']}")
    text = pathlib.Path(page).read_text()
    fences = re.findall(r"^```(\w*) ?(\S*)\n(.*?)^```$", text, flags=re.S | re.M)
    commands, output = 0, ""
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(ROOT / "examples", os.path.join(folder, "examples"))
        for language, file, content in fences:
            if file:
                (pathlib.Path(folder) / file).write_text(content)
            elif language == "sh":
                commands += 1
                ended = subprocess.run(["bash", "-euo", "pipefail", "-c", content], cwd=folder, env=environment,
                                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                print(content + ended.stdout, end="")
                output += ended.stdout
                if ended.returncode != 0:
                    print(f"\n{page}: exit code {ended.returncode} of\n{content}")
                    return 1
    for wrong in re.findall(r"the output says that (\d+ of \d+) are wrong", text):
        if not re.search(f"said solved, and was wrong: [^\n]* on {wrong}\\b", output):
            print(f"\n{page}: the output does not say that {wrong} are wrong")
            return 1
    return 0 if commands > 0 else 1


if __name__ == "__main__":
    task, *arguments = sys.argv[1:] or [""]
    if task == "links":
        sys.exit(check_links())
    if task == "tables":
        sys.exit(check_tables(arguments[0], "--write" in arguments))
    if task == "specs":
        sys.exit(check_specs(arguments[0]))
    if task == "tutorial":
        sys.exit(run_tutorial(*arguments))
    sys.exit(__doc__)
