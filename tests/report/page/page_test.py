"""The report's page in a real browser: page_test.py LCPBENCH CHOICES [TEST...]. Skipped (77) without Chromium.

Runs a small study, writes its report, and uses the page as people do. CHOICES is the program of choices.cpp.
"""

import csv
import json
import math
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[3]
PAGE = SOURCE / "study/report/page"
sys.path.insert(0, str(SOURCE / "tests/support"))
import chromium  # noqa: E402

LCPBENCH = CHOICES = None
HOSTILE = "<script>alert(1)</script>'\"& names"


def run(*arguments, folder=None, codes=(0,)):
    """Standard output of a program that ends with one of the exit codes."""
    done = subprocess.run(list(map(str, arguments)), cwd=folder, capture_output=True, text=True)
    assert done.returncode in codes, f"{arguments}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


class Study:
    """A store and its report in a folder."""

    def __init__(self, folder, name, *runs):
        self.folder = folder
        self.store = folder / f"{name}.db"
        self.report = folder / name
        for arguments in runs:
            run(LCPBENCH, "run", *arguments, "--store", self.store, folder=folder)
        run(LCPBENCH, "report", self.store, "--out", self.report, folder=folder)
        self.address = (self.report / "report.html").as_uri()

    def table(self, name):
        with open(self.report / "tables" / f"{name}.csv", newline="") as file:
            return list(csv.DictReader(file))

    def recommended(self, error=""):
        """Solver by kind of contacts, as tables/ has it; "" where none is."""
        return {row["contacts"]: row["solver"] for row in self.table("choices")
                if (float(row["error"]) if row["error"] else "") == error}


def named(option, *values):
    return [word for value in values for word in (f"--{option}", value)]


class PageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="lcpbench-page-test-")
        cls.addClassCleanup(cls.scratch.cleanup)
        cls.folder = pathlib.Path(cls.scratch.name)
        sets = named("set", "scene/gripper/*", "scene/box/*", "scene/wedge/*", "paper/monotone/exp1",
                     "paper/copositive/exp1")
        solvers = ["psor", "contact_lemke", "auto", "lemke", "regularized", "friction_ipm", "psor{max_iterations=20}",
                   "cone_ipm{cone=true}", "active_set"]
        cls.liar = "bullet_si" if (LCPBENCH.parent / "lcpbench-worker-bullet").exists() else None
        cls.study = Study(cls.folder, "study",
                          [*sets, "--trials", "40", *named("solver", *solvers, *filter(None, [cls.liar]))],
                          [*sets, "--trials", "6", "--solver", "lemke{engine=dense}"])  # on a part of the problems
        cls.browser = cls.enterClassContext(chromium.Browser())

    def setUp(self):
        self.browser.resize(1280, 900)
        self.browser.prefer("light")
        self.browser.errors.clear()
        self.browser.requests.clear()
        self.open(self.study)

    def tearDown(self):
        self.assertEqual(self.browser.errors, [])
        foreign = [each for each in self.browser.requests if not each.startswith(("file:", "data:", "blob:"))]
        self.assertEqual(foreign, [], "the page asks no network")

    def open(self, study, choice=""):
        self.browser.open("about:blank")
        self.browser.open(study.address + choice)
        self.browser.wait("document.querySelector('main h1')")

    def decisions(self):
        """Solver by kind of contacts, as the page's table has it; "" where none is."""
        return dict(self.browser.run("""[...document.querySelectorAll('.decision tbody tr')].map((row) => [
          row.querySelector('th').firstChild.textContent, row.querySelector('button.solver')?.textContent ?? ''])"""))

    def push(self, selector, words):
        """Clicks the element with these words."""
        self.browser.run(f"""[...document.querySelectorAll({json.dumps(selector)})]
          .find((each) => each.textContent === {json.dumps(words)}).click()""")

    def text(self, selector):
        return self.browser.run(f"document.querySelector({json.dumps(selector)})?.innerText ?? ''")

    def assert_fits(self):
        self.assertLessEqual(self.browser.run("document.documentElement.scrollWidth"),
                             self.browser.run("document.documentElement.clientWidth"), "no sideways scrolling")

    # --- the first screen ---

    def test_first_screen_says_what_the_tables_say(self):
        summary = json.loads((self.study.report / "summary.json").read_text())
        best = {row["contacts"]: row for row in summary["decision"] if row["recommended"]}
        self.assertTrue(best)
        rows = dict(self.browser.run("""[...document.querySelectorAll('.decision tbody tr')].map((row) =>
          [row.querySelector('th').firstChild.textContent, row.innerText])"""))
        sentence = self.text(".sentence")
        for contacts, row in best.items():
            self.assertIn(row["solver"], rows[contacts])
            self.assertIn(row["solver"], sentence)
            self.assertIn(f"of {row['solved']['whole']:,}", rows[contacts])
            self.assertIn(f"{100 * row['solved']['low']:.1f}", rows[contacts])
        self.assertEqual({contacts: solver for contacts, solver in self.decisions().items()}, self.study.recommended())
        share = summary["coverage"]["share"]
        self.assertIn("All " if share == 1 else f"{100 * share:.1f} % of the plan", self.text(".plan"))

    def test_names_of_a_store_are_text(self):
        problems = self.folder / HOSTILE
        run(LCPBENCH, "generate", "paper/monotone/exp1", "--seed", 3, "--count", 3, "--out", problems)
        study = Study(self.folder, "hostile", ["--set", f"file:{problems}", *named("solver", "lemke", "psor")])
        self.open(study, "#contacts=nothing&error=<b>")
        self.browser.run("document.querySelectorAll('details').forEach((each) => (each.open = true))")
        self.browser.wait("document.querySelector('#tables table')")
        self.assertIn(HOSTILE, self.browser.run("document.body.textContent"))
        self.assertEqual(self.browser.run("document.querySelectorAll('script').length"), 2)
        self.assertIn("No solver is recommended", self.text(".sentence"))

    # --- ask ---

    def test_the_recommendation_follows_the_error(self):
        self.browser.run("document.getElementById('error').focus()")
        self.assertIn("1e-4", self.text("output"))
        seen = [self.decisions()]
        errors = json.loads((self.study.report / "report.json").read_text())["errors"]
        self.assertEqual(errors, [None, *(float(f"1e-{power}") for power in range(1, 13))])
        top = self.browser.run("document.getElementById('error').getBoundingClientRect().y")
        for _ in range(4):  # three steps to 1e-1, which is the end
            self.browser.press("ArrowLeft")
        for error in errors[1:]:
            self.assertEqual(float(self.text("output")), error)
            self.assertEqual(self.decisions(), self.study.recommended(error))
            self.assertEqual(self.browser.run("document.getElementById('error').getBoundingClientRect().y"), top)
            seen.append(self.decisions())
            self.browser.press("ArrowRight")
        self.assertGreater(len({json.dumps(each) for each in seen}), 1, "some recommendation changes")
        address = self.browser.run("location.href")
        self.assertIn("error=1e-12", address)
        self.browser.open("about:blank")
        self.browser.open(address)
        self.assertEqual(self.decisions(), seen[-1], "a link shows the same")
        self.assertIn("1e-12", self.text(".sentence"))
        self.browser.click("nav a:last-child")
        self.assertEqual(self.browser.run("location.href"), address, "links inside the page keep the choice")

    def test_the_choice_follows_sets_and_solvers(self):
        self.browser.run("delete URLSearchParams.prototype.size")  # as in browsers before 2023
        chosen = next(filter(None, self.decisions().values()))
        self.browser.run("document.querySelector('#solvers').open = true")
        self.browser.run(f"""[...document.querySelectorAll('#solvers .check')]
          .find((each) => each.textContent === {json.dumps(chosen)}).querySelector('input').click()""")
        self.assertNotIn(chosen, self.decisions().values())
        self.browser.run("""(() => { const select = document.getElementById('contacts');
          select.value = 'own'; select.dispatchEvent(new Event('change')); })()""")
        self.browser.run("document.querySelector('#sets').open = true")
        self.push("#sets button", "None")
        self.browser.run("""[...document.querySelectorAll('#sets .check')]
          .find((each) => each.textContent === 'paper/monotone/exp1').querySelector('input').click()""")
        self.assertEqual(list(self.decisions()), ["Your selection"])
        self.assertIn("40", self.text(".decision tbody"))
        self.assertIn("set=paper%2Fmonotone%2Fexp1", self.browser.run("location.hash"))
        self.push(".controls button", "Reset")
        self.assertEqual(self.browser.run("location.hash"), "")
        self.assertEqual(self.decisions(), self.study.recommended())

    def test_the_page_chooses_as_the_program_does(self):
        selections = json.loads(run(CHOICES, self.study.store, 1000))
        self.assertEqual(len(selections), 1000)
        source = (PAGE / "src/choice.js").read_text().replace("export ", "")
        answers = json.loads(self.browser.run("""(() => {
          const source = %s;
          const selections = %s;
          const Statistics = (0, eval)(`(() => { ${source}; return Statistics; })()`);
          const report = JSON.parse(document.getElementById('report').textContent);
          const statistics = new Statistics(report);
          const label = (record) => report.solvers[record.solver].label;
          const places = new Map(report.solvers.map((each, i) => [each.label, i]));
          return JSON.stringify(selections.map(({ sets, solvers, error }) => {
            const choice = statistics.choose(sets, new Set(solvers.map((each) => places.get(each))), error);
            const contenders = choice.records.map((record) => ({
              solver: label(record), ground: record.ground, tie: record.tie ?? false, solved: record.solved,
              of: record.of, low: record.interval.low, false: record.false, time: record.time.value,
              factor_n: record.factor?.n ?? 0,
              factor: record.factor?.value ?? null, factor_low: record.factor?.low ?? null }));
            return { recommended: choice.recommended !== null, plan: choice.plan, contenders };
          }));
        })()""" % (json.dumps(source), json.dumps(selections))))
        grounds = set()
        for selection, answer in zip(selections, answers):
            self.assertEqual(answer["recommended"], selection["recommended"])
            self.assertAlmostEqual(answer["plan"], selection["plan"], delta=1e-9)
            self.assertEqual(len(answer["contenders"]), len(selection["contenders"]))
            for ours, theirs in zip(answer["contenders"], selection["contenders"]):
                grounds.add(theirs["ground"])
                for name, value in theirs.items():
                    if isinstance(value, float):
                        self.assertLessEqual(abs(ours[name] - value), 1e-9 * abs(value), name)
                    else:
                        self.assertEqual(ours[name], value, (name, selection))
        seen = {"reliable", "unsolved", "few_problems", "small_sample", "other_model"}
        self.assertLessEqual(seen | ({"false_claims", "some_sets"} if self.liar else set()), grounds)

    def test_back_returns_to_the_choice_before(self):
        chosen = self.decisions()
        self.browser.run("document.getElementById('error').focus()")
        self.browser.press("ArrowRight")
        self.push(".controls button", "Only other libraries")
        self.browser.run("document.querySelector('.dot').dispatchEvent(new Event('click'))")
        for address, dialog in (("#error=1e-5&solver=", True), ("#error=1e-5&solver=", False), ("#error=1e-5", False),
                                ("", False)):
            self.browser.wait(f"location.hash.startsWith('{address}') && "
                              f"Boolean(document.querySelector('dialog')) === {json.dumps(dialog)}")
            if address:
                self.browser.run("history.back()")
        self.assertEqual(self.decisions(), chosen)

    def test_a_click_leaves_other_libraries_only(self):
        solvers = json.loads((self.study.report / "report.json").read_text())["solvers"]
        others = {each["label"] for each in solvers if each["library"] != "native"}
        box = """[...document.querySelectorAll('.libraries label')].find((each) => each.textContent === 'lcpbench')
          ?.querySelector('input')"""
        if not others:
            self.assertIsNone(self.browser.run(box), "there is nothing to choose")
            self.skipTest("Bullet's worker is not built")
        self.push(".controls button", "Only other libraries")
        chosen = self.browser.run("""[...document.querySelectorAll('#solvers .check')]
          .filter((each) => each.querySelector('input').checked).map((each) => each.textContent)""")
        self.assertEqual(set(chosen), others)
        self.assertFalse(self.browser.run(f"{box}.checked"))
        self.browser.run(f"{box}.click()")
        self.assertEqual(self.browser.run("location.hash"), "", "all solvers again")

    def test_a_solver_says_what_it_is_and_where_it_is_to_be_had(self):
        solvers = json.loads((self.study.report / "report.json").read_text())["solvers"]
        links = {"lemke": "scholar.google.com", self.liar: "github.com/bulletphysics"}
        for name in filter(None, links):
            self.open(self.study, f"#solver={name}&contacts=Other+scenes")
            self.browser.run("document.querySelector('.dot').dispatchEvent(new Event('click'))")
            solver = next(each for each in solvers if each["label"] == name)
            self.assertIn(f"{solver['summary'][1:]}; it is a part of ", self.text("dialog p"))
            self.assertIn(solver["version"], self.text("dialog p"))
            self.assertIn(links[name], self.browser.run("document.querySelector('dialog p a').href"))

    # --- pictures ---

    def lines(self, form):
        """Of the picture of all scenes in this form each solver's label and its line: [x, y] in units of the axes."""
        self.open(self.study, f"#contacts=Other+scenes&y={form}")
        return self.browser.run("""(() => { const svg = document.querySelector('.pictures svg');
          return [...svg.querySelectorAll('path.dot')].map((path) => [path.ariaLabel.split(';')[0],
            path.getAttribute('d').match(/[-\\d.e]+/g).map(Number).reduce((points, value, i) => {
              i % 2 ? points.at(-1).push(svg.scale('y').invert(value)) : points.push([svg.scale('x').invert(value)]);
              return points; }, [])]); })()""")

    def test_shares_over_errors_are_those_of_the_tables(self):
        sets = [row["set"] for row in self.study.table("coverage") if row["kind"] == "scenes"]
        counts = {}
        for row in self.study.table("within_error"):
            if row["set"] in sets and row["error"]:
                at = counts.setdefault(row["solver"], {}).setdefault(float(row["error"]), [0, 0])
                at[0] += int(row["solved"])
                at[1] += int(row["of"])
        lines = dict(self.lines("share"))
        self.assertEqual(lines.keys(), counts.keys())
        for solver, line in lines.items():
            for (error, share), (solved, of) in zip(line, counts[solver].values(), strict=True):
                self.assertAlmostEqual(share, solved / of, delta=0.005, msg=f"{solver}, {error}")

    def test_the_profile_counts_times_of_the_fastest(self):
        """From the store: of each solver the share of problems that it solved in at most so many times the least time, of
        each set over the problems that all solvers took which took any of it."""
        answers = json.loads(run(LCPBENCH, "query", self.study.store, self.profile_query(), "--format", "json"))
        solvers, takers = {}, {}
        for row in answers:
            solvers.setdefault(row["set_id"], set()).add(row["solver"])
            takers.setdefault(row["problem"], set()).add(row["solver"])
        answers = [row for row in answers if takers[row["problem"]] == solvers[row["set_id"]]]
        least = {}
        for row in answers:
            if row["solved"]:
                least[row["problem"]] = min(least.get(row["problem"], math.inf), row["time"])
        lines = dict(self.lines("profile"))
        for solver in {row["solver"] for row in answers}:
            own = [row for row in answers if row["solver"] == solver]
            for factor in (1, 2, 10):
                low, high = (sum(bool(row["solved"]) and row["time"] <= factor * wide * least[row["problem"]]
                                 for row in own) / len(own) for wide in (0.98, 1.02))
                drawn = max(y for x, y in lines[solver] if x <= factor * 1.001)
                self.assertTrue(low - 0.005 <= drawn <= high + 0.005, f"{solver}, {factor}: {low} {drawn} {high}")

    def profile_query(self):
        file = self.folder / "profile.sql"
        file.write_text("""SELECT v.label AS solver, j.set_id, j.problem_id AS problem, j.verdict = 'solved' AS solved,
            t.setup_cpu_s + t.solve_cpu_s AS time
          FROM judged j JOIN sets ON sets.id = j.set_id JOIN set_facts f ON f.name = sets.name AND f.kind = 'scenes'
          JOIN solvers s ON s.id = j.solver_id
          JOIN solver_facts v ON v.name = s.name AND v.settings = s.settings
          JOIN timings t USING (problem_id, solver_id, part) WHERE j.claim <> 'unsupported'""")
        return file

    # --- point ---

    def test_a_dot_leads_to_a_command_that_repeats_the_failure(self):
        self.open(self.study, "#contacts=Frictionless")
        label = self.browser.run("""[...document.querySelectorAll('.dot')].map((each) => each.ariaLabel)
          .find((each) => each.startsWith('psor{') && !each.includes('100 % of'))""")
        self.browser.hover(f'[aria-label="{label}"]')
        self.browser.wait("document.querySelector('.tip').offsetHeight")
        self.assertIn("psor{max_iterations=20}", self.text(".tip"))
        self.assertIn("solved", self.text(".tip"))
        self.browser.click(f'[aria-label="{label}"]')
        self.browser.wait("document.querySelector('dialog[open]')")
        command = self.text("dialog .command pre")
        self.assertIn("a relative path", self.text("dialog"))
        self.assertTrue(self.browser.run("document.querySelector('dialog .command button').textContent === 'Copy'"))
        words = re.sub(r"\blcpbench\b", shlex.quote(str(LCPBENCH)), command)
        output = subprocess.run(["bash", "-c", words], cwd=self.folder, capture_output=True, text=True)
        self.assertIn(output.returncode, (0, 1), f"{command}\n{output.stderr}")
        self.assertIn("psor", output.stdout)
        self.browser.press("Escape")
        self.browser.wait("!document.querySelector('dialog')")

    def test_who_said_solved_and_was_wrong(self):
        if not self.liar:
            self.skipTest("Bullet's worker is not built")
        row = next(row for row in self.study.table("caught") if row["solver"] == self.liar)
        self.browser.click("#caught summary")
        self.browser.wait("document.querySelector('#caught tbody tr')")
        self.assertIn(self.liar, self.text("#caught tbody"))
        self.assertIn("HAVING SUM(false_claims) > 0", self.browser.run("""(() => {
          const fold = document.querySelector('#caught details');
          fold.open = true;
          return new Promise((done) => setTimeout(() => done(fold.textContent), 50)); })()"""))
        self.push("#caught tbody button", self.liar)
        command = self.text("dialog .command pre")
        self.assertIn(self.liar, command)
        words = re.sub(r"\blcpbench\b", shlex.quote(str(LCPBENCH)), command)
        output = subprocess.run(["bash", "-c", words], cwd=self.folder, capture_output=True, text=True)
        self.assertRegex(output.stdout, r"bullet_si +solved +wrong", row)

    def test_dots_have_a_keyboard(self):
        self.browser.run("document.querySelector('.dot[tabindex=\"0\"]').focus()")
        first = self.browser.run("document.activeElement.getAttribute('aria-label')")
        self.browser.press("ArrowRight")
        self.assertNotEqual(self.browser.run("document.activeElement.getAttribute('aria-label')"), first)
        self.browser.press("Enter")
        self.assertTrue(self.browser.run("Boolean(document.querySelector('dialog[open]'))"))
        self.browser.press("Escape")

    def test_a_set_refused_as_a_whole_is_among_the_refusals(self):
        self.open(self.study, "#set=paper/monotone/exp1&set=paper/copositive/exp1")
        self.assertIn("active_set 40 of 80", self.text(".pictures"))
        self.open(self.study, "#set=paper/copositive/exp1&solver=active_set")
        self.assertIn("no chosen solver took these problems", self.text(".decision"))

    # --- soft contacts ---

    def test_three_errors_stand_where_the_table_says(self):
        """A sliding particle of 1 kg with r_n = 1, by hand: softness changes 1/2 m/s, the relaxation 1/6 m/s."""
        (self.folder / "soft.json").write_text(json.dumps({
            "format": "lcpbench-problem", "version": 1, "name": "slider", "kind": "contact", "v": [1, 0, -1],
            "N": [[0], [0], [1]], "D": [[1, 0, -1, 0], [0, 1, 0, -1], [0, 0, 0, 0]], "edges": [4], "mu": [0.5],
            "G": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "compliance_n": [1]}))
        soft = Study(self.folder, "soft", [*named("set", "file:soft.json", "changed{of=file:soft.json,by=hard}"),
                                           *named("solver", "cone_ipm{cone=true}", "cone_ipm{cone=true,slip=none}")])
        self.open(soft)
        labels = self.browser.run("[...document.querySelectorAll('#errors .plot-y-axis-tick-label text')]"
                                  ".map((text) => text.textContent)")
        self.assertEqual(labels, ["softness", "relaxation", "cone_ipm{cone=true,slip=none}", "cone_ipm{cone=true}"])
        x = self.browser.run("""(() => { const at = (node) => node.getBoundingClientRect();
          return [...document.querySelectorAll('#errors .plot-dot circle')].map((dot) => at(dot).x + at(dot).width / 2)
            .concat(at(document.querySelector('#errors .plot-rule line')).x); })()""")
        line, decades = x[-1], [math.log10(error / 1e-3) for error in (1 / 2, 1 / 6)]
        self.assertEqual(len(x), 5)
        self.assertAlmostEqual((x[0] - line) / decades[0], (x[1] - line) / decades[1], delta=1)  # pixels a decade
        self.assertTrue(all(solver < line for solver in x[2:4]))
        self.open(self.study)
        self.assertFalse(self.browser.run("Boolean(document.querySelector('#errors'))"))

    # --- scenes ---

    def test_the_report_has_its_scenes(self):  # scene_test.py says more
        self.assertFalse(self.browser.run("Boolean(document.querySelector('#scenes canvas'))"), "it is below the window")
        self.browser.run("document.querySelector('#scenes').scrollIntoView()")
        self.browser.wait("document.querySelectorAll('#scenes canvas').length >= 2")
        self.browser.wait("document.querySelector('#scenes canvas').width > 300")

    # --- tables ---

    def test_tables_are_searched_sorted_and_saved(self):
        self.browser.run("document.querySelector('#table-results').open = true")
        self.browser.wait("document.querySelector('#table-results tbody tr')")
        self.browser.run("""(() => { const search = document.querySelector('#table-results input');
          search.value = 'friction_ipm wedge'; search.dispatchEvent(new Event('input')); })()""")
        rows = self.browser.run("[...document.querySelectorAll('#table-results tbody tr')].map((row) => row.innerText)")
        wanted = [row for row in self.study.table("results")
                  if row["solver"] == "friction_ipm" and "wedge" in row["set"]]
        self.assertEqual(len(rows), len(wanted))
        self.assertTrue(all("friction_ipm" in row for row in rows))
        self.browser.run("document.querySelector('#table-results th button').click()")
        self.assertEqual(self.browser.run("document.querySelector('#table-results th').ariaSort"), "ascending")
        self.browser.send("Browser.setDownloadBehavior", session=None, behavior="allow", downloadPath=str(self.folder))
        self.push("#table-results button", "CSV")
        saved = self.folder / "results.csv"
        self.browser.wait("true")
        for _ in range(100):
            if saved.exists():
                break
            self.browser.run("new Promise((done) => setTimeout(done, 50))")
        self.assertEqual(len(list(csv.DictReader(saved.read_text().splitlines()))), len(wanted))
        self.assertIn("SELECT", self.browser.run("""(() => {
          const fold = document.querySelector('#table-results details');
          fold.open = true;
          return new Promise((done) => setTimeout(() => done(fold.textContent), 50)); })()"""))

    # --- two stores ---

    def test_a_comparison_says_what_changed(self):
        options = ("--set", "paper/monotone/exp1", "--set", "paper/copositive/exp1", "--trials", "40")
        good, bad = (self.folder / f"{name}.db" for name in ("good", "bad"))
        run(LCPBENCH, "run", *options, "--solver", "psor", "--store", good)
        run(LCPBENCH, "run", *options, "--solver", "psor{max_iterations=5}", "--store", bad)
        page = self.folder / "comparison.html"
        for a, b, words in ((good, bad, "B is worse"), (good, good, "no difference")):
            names = [("psor" if each == good else "psor{max_iterations=5}") for each in (a, b)]
            run(LCPBENCH, "compare", a, b, "--solver-a", names[0], "--solver-b", names[1], "--out", page)
            self.browser.open(page.as_uri())
            self.assertIn(words, self.text(".sentence"))
            for part in ("#solvers", "#changes"):
                self.assertEqual("solves fewer" in self.text(part), b == bad, part)
            self.assert_fits()

    # --- ways to look at it ---

    def test_a_phone_needs_no_sideways_scrolling(self):
        self.browser.resize(390, 844, phone=True)
        for choice in ("", "#contacts=Frictionless&y=share", "#contacts=Frictionless&y=profile"):
            self.open(self.study, choice)
            self.browser.run("document.querySelectorAll('details').forEach((each) => (each.open = true))")
            self.browser.run("new Promise((done) => setTimeout(done, 200))")
            self.assert_fits()
        self.browser.run("document.querySelector('.dot').dispatchEvent(new Event('click'))")
        self.assertTrue(self.browser.run("""(() => { const dialog = document.querySelector('dialog');
          return dialog.scrollWidth <= dialog.clientWidth; })()"""))

    def test_dark_and_light(self):
        lightness = """getComputedStyle(document.body).backgroundColor.match(/\\d+/g)
          .reduce((sum, each) => sum + Number(each), 0)"""
        self.assertGreater(self.browser.run(lightness), 600)
        self.browser.prefer("dark")
        self.assertLess(self.browser.run(lightness), 150)

    def test_print(self):
        pages = len(re.findall(rb"/Type\s*/Page\b", self.browser.pdf()))
        self.assertLessEqual(pages, 12)
        self.assertGreaterEqual(pages, 2)

    def test_contrast_and_names(self):
        axe = PAGE / "node_modules/axe-core/axe.min.js"
        if not axe.exists():
            self.skipTest("axe-core is not installed: npm ci in study/report/page")
        for scheme in ("light", "dark"):
            self.browser.prefer(scheme)
            self.open(self.study, "#contacts=Frictionless")
            self.browser.run("document.querySelectorAll('details').forEach((each) => (each.open = true))")
            self.browser.run(axe.read_text() + "; 1")
            for state in ("page", "dialog"):
                found = self.browser.run("""axe.run().then(({ violations }) => violations.map(({ id, nodes }) =>
                  `${id}: ${nodes[0].html.slice(0, 300)} (${nodes.length})`))""")
                self.assertEqual(found, [], f"{scheme}, {state}")
                self.browser.run("document.querySelector('.dot').dispatchEvent(new Event('click'))")


if __name__ == "__main__":
    if not chromium.find_chromium():
        print("skipped: Chromium is not installed (Debian's package chromium)")
        sys.exit(77)
    LCPBENCH, CHOICES = (pathlib.Path(each).resolve() for each in sys.argv[1:3])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
