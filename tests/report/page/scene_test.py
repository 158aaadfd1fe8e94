"""Steps and films in 3D in a real browser: scene_test.py LCPBENCH [TEST...]. Skipped (77) without Chromium."""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[3]
PAGE = SOURCE / "study/report/page"
sys.path.insert(0, str(SOURCE / "tests/support"))
import chromium  # noqa: E402

LCPBENCH = None
HOSTILE = "=</script><script>alert(1)</script>'\"&"
NO_WEBGL = """HTMLCanvasElement.prototype.getContext = ((get) => function (kind, ...rest) {
  return kind.startsWith("webgl") ? null : get.call(this, kind, ...rest);
})(HTMLCanvasElement.prototype.getContext)"""
# Of a picture: how many colours it has, and a number that changes with it.
LOOK = """(() => {
  const canvas = document.querySelectorAll("canvas")[%d];
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const pixels = new Uint32Array(data.buffer);
  let sum = 0;
  for (let i = 0; i < pixels.length; ++i) sum = (sum * 31 + pixels[i]) | 0;
  return { colours: new Set(pixels).size, sum };
})()"""


def view(*arguments):
    done = subprocess.run([LCPBENCH, "view", *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def pushed_up(file, *more):
    """A step in which a contact at its top pulls a small cube up, far from the origin, and more shapes."""
    corners = [each / 10 for x in (-1, 1) for y in (-1, 1) for z in (-1, 1) for each in (x, y, z)]
    header = {"format": "lcpbench-scenes", "version": 1, "scene": "cube", "gravity": [0, 0, -9.81],
              "shapes": [{"body": 0, "type": "hull", "size": corners}, *more]}
    body = {"mass": 1, "inertia": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "position": [50, 0, 0.1], "linear_velocity": [0, 0, -1],
            "angular_velocity": [0, 0, 0]}
    contact = {"body_a": 0, "body_b": -1, "point": [50, 0, 0.2], "normal": [0, 0, 1], "tangent": [1, 0, 0], "mu": 0.5, "edges": 4}
    problem = {"format": "lcpbench-problem", "version": 1, "name": "cube", "kind": "scene", "bodies": [body],
               "contacts": [contact]}
    step = {"step": 0, "problem": problem, "poses": [[50, 0, 0.1, 1, 0, 0, 0]]}
    file.with_suffix(".scenes").write_text(json.dumps(header) + "\n" + json.dumps(step) + "\n")
    view(f"{file.with_suffix('.scenes')}#0", "--solver", "auto", "--solver", "psor", "--out", file)


def fall(folder):
    """Replays of a cube: it stays with the first solver, and falls by 8 m with the second, whose name is hostile."""
    problem = {"format": "lcpbench-problem", "version": 1, "name": "cube", "kind": "scene", "contacts": [], "bodies": [
        {"mass": 1, "inertia": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "position": [0, 0, 8], "linear_velocity": [0, 0, 0],
         "angular_velocity": [0, 0, 0]}]}
    header = {"format": "lcpbench-scenes", "version": 1, "scene": HOSTILE, "step_length": 0.01, "gravity": [0, 0, -9.81],
              "shapes": [{"body": 0, "type": "box", "size": [1, 1, 1]}]}
    replays = []
    (folder / "steps").mkdir(parents=True)
    for solver, way in (("auto", 0), (HOSTILE, 8)):
        name = f"{way}.scenes"
        frames = [header] + [{"step": k, "time": k / 100, "problem": problem, "poses": [[0, 0, 8 - way * k / 100, 1, 0, 0, 0], []]}
                             for k in (0, 50, 100)]
        (folder / "steps" / name).write_text("".join(json.dumps(frame) + "\n" for frame in frames))
        rows = ["step,time_s,contacts,claim,energy_j,deepest_m,drift_m,slip_m,cpu_s"]
        rows += [f"{k},{k / 100},0,solved,{80 - k},0,{way * k / 100},,0.001" for k in range(101)]
        (folder / "steps" / f"{name}.csv").write_text("\n".join(rows) + "\nend,\n")
        replays.append({"solver": solver, "file": name})
    scene = {"scene": HOSTILE, "engine": "ODE", "steps": 101, "step_length_s": 0.01, "pushed": False, "replays": replays}
    (folder / "replays.json").write_text(json.dumps({"format": "lcpbench-replays", "version": 1, "scenes": [scene]}))


class SceneTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="lcpbench-scene-test-")
        cls.addClassCleanup(cls.scratch.cleanup)
        cls.folder = pathlib.Path(cls.scratch.name)
        step = f"{SOURCE}/generators/scenes/slope/ode.scenes#5"
        known = subprocess.run([LCPBENCH, "view", step.split("#")[0]], capture_output=True, text=True).stderr
        cls.step = known.split("name one, as '")[1].split("'")[0]
        solvers = ["--solver", "auto", "--solver", "psor{max_iterations=3}", "--solver", "lemke"]
        view(cls.step, *solvers, "--out", cls.folder / "step.html")
        cls.shown = json.loads(view(cls.step, *solvers, "--format", "json"))["scenes"][0]
        pushed_up(cls.folder / "arrow.html")
        pushed_up(cls.folder / "ground.html", {"body": -1, "type": "plane", "size": [0, 0, 1, 0]})
        pushed_up(cls.folder / "line.html", {"body": -1, "type": "hull", "size": 2 * [50, 0, 0] + 2 * [50.1, 0, 0]})
        fall(cls.folder / "replays")
        view(cls.folder / "replays", "--out", cls.folder / "film.html")
        cls.browser = cls.enterClassContext(chromium.Browser())

    def setUp(self):
        self.browser.resize(1280, 900)
        self.browser.prefer("light")
        self.browser.errors.clear()
        self.browser.requests.clear()

    def tearDown(self):
        self.assertEqual(self.browser.errors, [])
        foreign = [each for each in self.browser.requests if not each.startswith(("file:", "data:", "blob:"))]
        self.assertEqual(foreign, [], "the page asks no network")

    def open(self, name):
        self.browser.open("about:blank")
        self.browser.open((self.folder / name).as_uri())
        self.browser.wait("document.querySelectorAll('canvas').length === 2")
        self.browser.wait("document.querySelector('canvas').width > 300 || innerWidth < 500")

    def look(self, picture=0):
        return self.browser.run(LOOK % picture)

    def text(self, selector):
        return self.browser.run(f"document.querySelector({json.dumps(selector)})?.innerText ?? ''")

    def changes(self, act):
        before = self.look()["sum"]
        act()
        return self.look()["sum"] != before

    def key(self, key):
        self.browser.run(f"""(() => {{ const canvas = document.querySelector("canvas"); canvas.focus();
          canvas.dispatchEvent(new KeyboardEvent("keydown", {{ key: "{key}", bubbles: true, cancelable: true }})); }})()""")

    def test_a_step_is_drawn_and_turned_by_keys_and_mouse(self):
        self.open("step.html")
        self.assertGreater(self.look()["colours"], 20)
        self.assertNotEqual(self.look(0)["sum"], self.look(1)["sum"])  # another answer
        for key in ("ArrowLeft", "ArrowUp", "+", "-"):
            self.assertTrue(self.changes(lambda: self.key(key)), key)
        self.key("0")
        start = self.look()["sum"]
        x, y = self.browser.center("canvas")
        for kind, at in (("mousePressed", x), ("mouseMoved", x + 40), ("mouseReleased", x + 40)):
            self.browser.send("Input.dispatchMouseEvent", type=kind, x=at, y=y, button="left", buttons=1, clickCount=1)
        self.assertNotEqual(self.look()["sum"], start)
        self.browser.run("[...document.querySelectorAll('button')].find((each) => each.textContent === 'Reset view').click()")
        self.assertEqual(self.look()["sum"], start)
        for name in ("impulses", "velocities of contacts"):
            toggle = f"[...document.querySelectorAll('fieldset label')].find((each) => each.textContent.trim() === '{name}')"
            self.assertTrue(self.changes(lambda: self.browser.run(f"{toggle}.querySelector('input').click()")), name)

    def test_the_table_has_the_numbers_and_chooses_a_contact(self):
        self.open("step.html")
        self.browser.click("details summary")
        self.browser.wait("document.querySelector('tbody td')")
        rows = self.browser.run("[...document.querySelectorAll('tbody tr')].map((row) => [...row.cells].map((cell) => cell.innerText))")
        self.assertEqual(len(rows), self.shown["contacts"]["count"])
        worst = max(self.shown["answers"][1]["residuals"])
        self.assertEqual(float(rows[0][2]), float(f"{worst:.1e}"))
        self.assertTrue(self.changes(lambda: self.browser.click("tbody button")))
        self.assertIn(rows[0][0], self.text(".scene3d-readout"))
        self.assertIn(rows[0][2], self.text(".scene3d-readout"))

    def test_any_two_answers_stand_side_by_side(self):
        self.open("step.html")
        self.assertIn("said solved; verdict: solved", self.text(".scene3d-words"))
        self.browser.run("""(() => { const select = document.querySelector("select"); select.value = 1;
          select.dispatchEvent(new Event("change")); })()""")
        self.assertIn("stopped at its limit of iterations", self.text(".scene3d-words"))
        self.assertEqual(self.look(0)["sum"], self.look(1)["sum"])

    def test_without_webgl_there_are_the_numbers(self):
        script = self.browser.send("Page.addScriptToEvaluateOnNewDocument", source=NO_WEBGL)["identifier"]
        try:
            for name, rows in (("step.html", self.shown["contacts"]["count"]), ("film.html", 2)):
                self.browser.open((self.folder / name).as_uri())
                self.browser.wait("document.querySelector('figure tbody tr')")
                self.assertIn("no WebGL", self.text("figure"))
                self.assertEqual(self.browser.run("document.querySelectorAll('canvas').length"), 0)
                self.assertEqual(self.browser.run("document.querySelectorAll('tbody tr').length"), rows)
        finally:
            self.browser.send("Page.removeScriptToEvaluateOnNewDocument", identifier=script)

    def test_a_film_has_one_slider_for_all_solvers(self):
        self.open("film.html")
        self.assertIn(HOSTILE, self.browser.run("document.body.textContent"))
        self.assertEqual(self.browser.run("document.querySelectorAll('script').length"), 2)
        stands, falls = self.look(0)["sum"], self.look(1)["sum"]
        self.browser.run("""(() => { const slider = document.querySelector("input[type=range]"); slider.value = 0.77;
          slider.dispatchEvent(new Event("input")); })()""")
        self.assertEqual(self.look(0)["sum"], stands)
        self.assertNotEqual(self.look(1)["sum"], falls)
        self.assertIn("0.77 s of 1.01 s", self.text("output"))
        self.assertIn("8 m", self.text("tbody"))

    def drawn(self, picture=0):
        """The share of drawn pixels inside of the picture, and at its edge."""
        return self.browser.run("""(() => {
          const canvas = document.querySelectorAll("canvas")[%d];
          const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
          const [drawn, all] = [[0, 0], [0, 0]];
          for (let i = 0; i < data.length / 4; ++i) {
            const [x, y] = [i %% canvas.width, Math.floor(i / canvas.width)];
            const at_edge = Number(x === 0 || y === 0 || x === canvas.width - 1 || y === canvas.height - 1);
            if (data[4 * i + 3] > 0) ++drawn[at_edge];
            ++all[at_edge];
          }
          return drawn.map((count, i) => count / all[i]); })()""" % picture)

    def test_no_arrow_leaves_the_frame(self):
        self.open("arrow.html")
        inner, edge = self.drawn()
        self.assertGreater(inner, 0.05)
        self.assertEqual(edge, 0)

    def test_the_ground_is_seen_wherever_the_scene_is(self):
        self.open("arrow.html")
        without = self.drawn()[0]
        self.open("ground.html")
        self.assertGreater(self.drawn()[0], without + 0.4)

    def test_a_hull_without_volume_is_no_error(self):
        self.open("line.html")
        self.assertGreater(self.drawn()[0], 0.05)

    def test_the_picture_has_room_for_the_scene_over_all_steps(self):
        self.open("film.html")
        for picture, time_s in ((0, 0), (1, 0), (1, 0.5), (1, 1.01)):
            self.browser.run(f"""(() => {{ const slider = document.querySelector("input[type=range]"); slider.value = {time_s};
              slider.dispatchEvent(new Event("input")); }})()""")
            inner, edge = self.drawn(picture)
            self.assertGreater(inner, 0.001, (picture, time_s))
            self.assertEqual(edge, 0, (picture, time_s))

    def test_a_saved_table_runs_no_formula(self):
        self.open("film.html")
        self.browser.send("Browser.setDownloadBehavior", session=None, behavior="allow", downloadPath=str(self.folder))
        self.browser.run("[...document.querySelectorAll('button')].find((each) => each.textContent === 'CSV').click()")
        saved = self.folder / "replays.csv"
        end = time.monotonic() + 120
        while not saved.exists() and time.monotonic() < end:
            self.browser.run("new Promise((done) => setTimeout(done, 50))")
        solvers = [row["solver"] for row in csv.DictReader(saved.read_text().splitlines())]
        self.assertEqual(solvers, ["auto", "'" + HOSTILE])

    def test_error_against_processor_time_has_a_dot_for_each_replay(self):
        self.open("film.html")
        self.browser.run("""(() => { const choice = document.querySelector("select[aria-label=Curve]"); choice.value = "cost";
          choice.dispatchEvent(new Event("change")); })()""")
        words = self.browser.run("document.querySelector('.scene3d-chart svg').getAttribute('aria-label')")
        self.assertIn("auto at most 1 µm in 100 ms", words)
        self.assertIn("lost in 100 ms", words)  # the one that falls, 8 m away
        self.assertEqual(self.browser.run("document.querySelectorAll('.scene3d-chart svg circle').length"), 2)
        self.assertIsNone(self.browser.run("document.querySelector('.scene3d-cursor')"))
        self.assertIn("100 ms", self.text("tbody"))

    def play(self):
        """Plays the film until it ends. @returns the pictures of the second solver on the way"""
        self.browser.run("document.querySelector('button.play').click()")
        self.assertEqual(self.text("button.play"), "Pause")
        pictures = set()
        end = time.monotonic() + 60
        while self.text("button.play") == "Pause" and time.monotonic() < end:
            pictures.add(self.look(1)["sum"])
        self.assertEqual(self.text("button.play"), "Play")
        self.assertIn("1.01 s of 1.01 s", self.text("output"))
        return len(pictures)

    def test_a_film_plays_and_moves_less_where_motion_is_unwanted(self):
        self.open("film.html")
        self.assertGreater(self.play(), 3)
        self.browser.send("Emulation.setEmulatedMedia", features=[{"name": "prefers-reduced-motion", "value": "reduce"}])
        self.open("film.html")
        self.assertLessEqual(self.play(), 3)  # its frames, and nothing between them

    def test_phone_and_dark_mode(self):
        for name in ("step.html", "film.html"):
            self.browser.resize(390, 844, phone=True)
            self.open(name)
            self.browser.run("document.querySelectorAll('details').forEach((each) => (each.open = true))")
            self.assertLessEqual(self.browser.run("document.documentElement.scrollWidth"), 390, name)
            light = self.look()["sum"]
            self.browser.prefer("dark")
            self.browser.wait(f"{LOOK % 0}.sum !== {light}")
            self.browser.prefer("light")

if __name__ == "__main__":
    if not chromium.find_chromium():
        print("skipped: Chromium is not installed (Debian's package chromium)")
        sys.exit(77)
    LCPBENCH = pathlib.Path(sys.argv[1]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
