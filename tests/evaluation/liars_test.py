#!/usr/bin/env python3
"""A solver that says solved and is not is shown as wrong wherever it is: solve, run, summary.json, the report.

usage: liars_test.py LCPBENCH
"""
import csv
import json
import os
import sqlite3
import subprocess
import sys
import tempfile
import unittest

import fixed_answers
import second_judge

HERE = os.path.dirname(os.path.abspath(__file__))
PROGRAM = os.path.abspath(sys.argv[1])
TRIALS = 12


def lcpbench(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=True).stdout


class LiarTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def expect_wrong_everywhere(self, kind, problem_set):
        spec = (f"external{{command={sys.executable} {os.path.join(HERE, 'fixed_answers.py')} {kind},"
                "form=contact}")
        lcpbench("generate", problem_set, "--seed", "1", "--count", str(TRIALS), "--out", self.path("problems"))
        files = sorted(os.path.join(self.path("problems"), name) for name in os.listdir(self.path("problems")))
        liar, passes, criterion = fixed_answers.Liar(kind), [], 0
        for name in files:
            with open(name, encoding="utf-8") as file:
                problem = json.load(file)
            liar.take(problem)
            judged = second_judge.judge(problem, liar.answer()["z"])
            passes.append(judged["passes"])
            criterion += judged["criterion"]
        wrong = passes.count(False)
        self.assertGreaterEqual(wrong, TRIALS // 2, "the liar is not wrong often enough to show anything")

        rows = json.loads(lcpbench("solve", *files, "--solver", spec, "--format", "json"))
        self.assertEqual([row["verdict"] for row in rows], ["solved" if right else "wrong" for right in passes])
        self.assertTrue(all(row["why"].startswith("said solved, but ") for row in rows if row["verdict"] == "wrong"))
        # Where lines break depends on the length of the paths in them.
        text = " ".join(lcpbench("solve", files[passes.index(False)], "--solver", spec).split())
        self.assertIn(" said solved, but ", text)

        store = self.path("s.db")
        lcpbench("run", "--set", problem_set, "--trials", str(TRIALS), "--solver", spec, "--solver", "contact_lemke",
                 "--seed", "1", "--store", store)
        lcpbench("report", store, "--out", self.path("report"))
        with open(self.path("report/summary.json"), encoding="utf-8") as file:
            cells = json.load(file)["cells"]
        cell = next(cell for cell in cells if cell["solver"] == "external")
        self.assertEqual(cell["claimed"], TRIALS)
        self.assertEqual(cell["wrong"], wrong)
        self.assertEqual(cell["false_claims"], wrong)
        self.assertEqual(cell["criterion"], criterion)
        self.assertEqual(cell["solved"], TRIALS - wrong)
        self.expect_on_first_screen(wrong)

    def expect_on_first_screen(self, wrong):
        with open(self.path("report/tables/decision.csv"), encoding="utf-8") as file:
            shares = [record for record in csv.DictReader(file) if record["solver"].startswith("external")]
        self.assertTrue(shares)
        self.assertEqual({int(record["false_claims.count"]) for record in shares}, {wrong})
        self.assertEqual({record["recommended"] for record in shares}, {"false"})
        with open(self.path("report/report.html"), encoding="utf-8") as file:
            page = file.read()
        first_screen = page[:page.index('<section id=')]
        self.assertNotIn("No solver here said solved and was wrong", first_screen)
        self.assertIn("external{", first_screen)

    def test_zeros(self):
        self.expect_wrong_everywhere("zeros", "paper/monotone/exp1{nc_max=4}")

    def test_the_last_problems_answer(self):
        self.expect_wrong_everywhere("last", "paper/monotone/exp1{nc_max=4}")

    def test_the_frictionless_answer(self):
        self.expect_wrong_everywhere("frictionless", "paper/copositive/exp1{nc_max=3}")

    def answering(self, name, answer):
        """A solver that gives this answer to the problem named x."""
        with open(self.path(name), "w", encoding="utf-8") as file:
            json.dump({"x": answer}, file)
        return (f"external{{command={sys.executable} {os.path.join(HERE, 'fixed_answers.py')} {self.path(name)}}}")

    def test_what_one_denies_rightly_is_the_truth_for_all(self):
        """No z solves it, by 1e-10, and no u proves that: M z + q >= 0 has solutions. Only enumeration sees it."""
        problem = {"format": "lcpbench-problem", "version": 1, "name": "x", "kind": "lcp",
                   "M": [[0, 3], [0, 1]], "q": [-3, -0.9999999999]}
        with open(self.path("x.json"), "w", encoding="utf-8") as file:
            json.dump(problem, file)
        near = {"claim": "solved", "z": [0, 1]}
        self.assertTrue(second_judge.judge(problem, near["z"])["passes"])
        solvers = [argument for name, answer in (("near", near), ("denies", {"claim": "unsolvable"}),
                                                 ("lost", {"claim": "iteration_limit", "z": [0, 1]}))
                   for argument in ("--solver", self.answering(name, answer))]
        rows = json.loads(lcpbench("solve", self.path("x.json"), *solvers, "--format", "json"))
        verdicts = {row["claim"]: row["verdict"] for row in rows}
        self.assertEqual(verdicts, {"solved": "wrong", "unsolvable": "unsolvable", "iteration_limit": "unsolvable"})
        self.assertEqual({row["truth"] for row in rows}, {"unsolvable"})
        alone = json.loads(lcpbench("solve", self.path("x.json"), *solvers[:2], "--format", "json"))
        self.assertEqual(alone[0]["verdict"], "solved")  # nobody denied it

        lcpbench("run", "--set", "file:" + self.path("x.json"), *solvers, "--store", self.path("s.db"))
        with sqlite3.connect(self.path("s.db")) as store:
            self.assertEqual(store.execute("SELECT certificate FROM certificates").fetchall(), [("unsolvable",)])
            self.assertEqual(dict(store.execute("SELECT claim, verdict FROM judged")), verdicts)
        store.close()


unittest.main(argv=sys.argv[:1])
