"""The documents: code runs and prints what stands beside it, and the reference is that of the docstrings."""
import contextlib
import dataclasses
import importlib.util
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import lcpbench

ROOT = pathlib.Path(os.environ["LCPBENCH_SOURCE"])


def run_page(page):
    """Runs the cells of a page's notebook: what each prints, and the output that stands in it."""
    made = subprocess.run([sys.executable, ROOT / "python/tools/notebook.py", ROOT / page], capture_output=True,
                          check=True)
    names, said = {}, []
    for cell in json.loads(made.stdout)["cells"]:
        if cell["cell_type"] == "code":
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(compile(cell["source"], page, "exec"), names)
            said.append((out.getvalue(), "".join(each["text"] for each in cell["outputs"])))
    return said


class Documents(unittest.TestCase):
    def test_the_first_example_says_what_stands_beside_it(self):
        (said, _), = run_page("docs/howto/python.md")
        solved, wrong = said.splitlines()
        self.assertEqual(solved, "solved [0.97 0.   0.  ]")
        self.assertTrue(wrong.startswith("wrong, residual 0.3: said solved, but contact 0"), wrong)

    @unittest.skipIf(importlib.util.find_spec("mujoco") is None, "PyPI's mujoco is not installed")
    def test_the_tutorial_on_a_robot_prints_what_stands_beside_it(self):
        with tempfile.TemporaryDirectory() as folder:
            before = os.getcwd()
            os.chdir(folder)
            try:
                said = run_page("docs/tutorial/mujoco-robot.md")
            finally:
                os.chdir(before)
        self.assertEqual(len(said), 6)
        for printed, expected in said:  # numbers differ with MuJoCo's version and the machine
            self.assertEqual(*(re.sub(r" +\d+ us", " us", re.sub(r"\d+\.\d+|\b\d+ (?=of|wrong|steps)|foot\d|contact \d", "#", each))
                               for each in (printed, expected)))
        for solver in ("auto", "contact_lemke"):
            self.assertRegex(said[1][0], rf"{solver} +solved (\d+) of \1, wrong 0")

    def test_the_reference_is_made_from_the_docstrings(self):
        made = subprocess.run([sys.executable, ROOT / "python/tools/reference.py"], capture_output=True, text=True,
                              check=True)
        self.assertEqual(made.stdout, (ROOT / "docs/reference/python.md").read_text(),
                         "run python3 python/tools/reference.py > docs/reference/python.md")

    def test_the_reference_says_what_the_attributes_hold(self):
        page = (ROOT / "docs/reference/python.md").read_text()
        for cls, names in ((lcpbench.Verdict, [each.name for each in dataclasses.fields(lcpbench.Verdict)]),
                           (lcpbench.ContactSolver, [name for name in dir(lcpbench.ContactSolver) if name[0] != "_"])):
            section = page.split(f"## lcpbench.{cls.__name__}\n")[1].split("\n## ")[0]
            for name in names:
                self.assertRegex(section, rf"(?m)^[^(]*\b{name}\b.*: |\.{name}\(", cls)


if __name__ == "__main__":
    unittest.main()
