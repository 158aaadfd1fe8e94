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
        self.assertEqual({int(record["false_claims.part"]) for record in shares}, {wrong})
        self.assertEqual({record["recommended"] for record in shares}, {"0"})
        with open(self.path("report/tables/caught.csv"), encoding="utf-8") as file:
            caught = {record["solver"].partition("{")[0]: int(record["false_claims"]) for record in csv.DictReader(file)}
        self.assertEqual(caught, {"external": wrong})

    def test_zeros(self):
        self.expect_wrong_everywhere("zeros", "paper/monotone/exp1{nc_max=4}")

    def test_the_last_problems_answer(self):
        self.expect_wrong_everywhere("last", "paper/monotone/exp1{nc_max=4}")

    def test_the_frictionless_answer(self):
        self.expect_wrong_everywhere("frictionless", "paper/copositive/exp1{nc_max=3}")

    def write(self, name, content):
        with open(self.path(name), "w", encoding="utf-8") as file:
            json.dump(content, file)

    def answering(self, name, answer, form="lcp"):
        """A solver that gives this answer to the problem named x."""
        self.write(name, {"x": answer})
        script = os.path.join(HERE, "fixed_answers.py")
        return f"external{{command={sys.executable} {script} {self.path(name)},form={form}}}"

    def test_a_wrong_velocity_beside_a_right_z(self):
        """The verdict covers the velocity, in solve and in a store."""
        problem = {"format": "lcpbench-problem", "version": 1, "name": "x", "kind": "contact", "v": [-1, 0, 0],
                   "N": [[1], [0], [0]], "G": [[2, 0, 0], [0, 1, 0], [0, 0, 4]]}
        self.write("x.json", problem)
        given = {"right": [0, 0, 0], "wrong": [777, 888, 999], "near": [0, 0, 1e-3], "none": None}
        expected = {"right": "solved", "wrong": "wrong", "near": "wrong", "none": "solved"}
        solvers = []
        for name, velocity in given.items():
            answer = {"claim": "solved", "z": [2]} | ({"velocity": velocity} if velocity else {})
            passes = second_judge.judge(problem, [2], velocity)["passes"]
            self.assertEqual(second_judge.verdict("solved", passes, "solvable"), expected[name])
            solvers += ["--solver", self.answering(name, answer, "contact")]
        rows = json.loads(lcpbench("solve", self.path("x.json"), *solvers, "--format", "json"))
        verdicts = {os.path.basename(row["settings"].split()[2].split(",")[0]): row for row in rows}
        self.assertEqual({name: row["verdict"] for name, row in verdicts.items()}, expected)
        self.assertTrue(verdicts["wrong"]["why"].startswith(
            "said solved, but its velocity is not the one that its z gives: coordinate 2 is 999, and z gives 0; error "),
            verdicts["wrong"]["why"])
        self.assertIsNone(verdicts["none"]["errors"]["returned_velocity_error"])
        lcpbench("run", "--set", "file:" + self.path("x.json"), *solvers, "--store", self.path("s.db"))
        with sqlite3.connect(self.path("s.db")) as store:
            found = store.execute("SELECT verdict, returned_velocity_error FROM judged JOIN verdicts USING "
                                  "(problem_id, solver_id, part) ORDER BY 2").fetchall()
        store.close()
        self.assertEqual([verdict for verdict, _ in found], ["solved", "solved", "wrong", "wrong"])
        lcpbench("report", self.path("s.db"), "--out", self.path("report"))
        with open(self.path("report/summary.json"), encoding="utf-8") as file:
            self.assertEqual(sum(cell["false_claims"] for cell in json.load(file)["cells"]), 2)

    def test_an_answer_within_the_tolerance_contradicts_no_proof(self):
        """Two walls leave 2^-17 of the way too little room. In whatever order answer and proof arrive, both are right."""
        problem = {"format": "lcpbench-problem", "version": 1, "name": "x", "kind": "contact", "v": [0],
                   "N": [[1, -1]], "D": [[0, 0]], "edges": [2, 0], "mu": [0, 0], "G": [[1]],
                   "b": [-1, 1 - 2.0**-17]}
        self.write("x.json", problem)
        passes = self.answering("passes", {"claim": "solved", "z": [1, 0, 0, 0, 0]}, "contact")
        denies = self.answering("denies", {"claim": "unsolvable"}, "contact")
        proves = self.answering("proves", {"claim": "unsolvable", "farkas": [1, 1]}, "contact")
        gives_up = self.answering("lost", {"claim": "iteration_limit"}, "contact")
        expected = {passes: "solved", denies: "unsolvable", proves: "unsolvable", gives_up: "missed"}

        def run(store, *solvers):
            for solver in solvers:
                lcpbench("run", "--set", "file:" + self.path("x.json"), "--solver", solver, "--store", self.path(store))

        def judged(store):
            with sqlite3.connect(self.path(store)) as connection:
                rows = connection.execute("SELECT truth, verdict FROM judged ORDER BY verdict").fetchall()
            connection.close()
            return rows

        for deniers in ([denies], [proves], [denies, proves]):
            solvers = [passes, gives_up, *deniers]
            found = [("nearly", verdict) for verdict in sorted(expected[solver] for solver in solvers)]
            for order in (solvers, solvers[::-1]):
                arguments = [argument for solver in order for argument in ("--solver", solver)]
                rows = json.loads(lcpbench("solve", self.path("x.json"), *arguments, "--format", "json"))
                self.assertEqual(sorted((row["truth"], row["verdict"]) for row in rows), found)
                self.assertEqual({row["least_violation_m_per_s"] for row in rows}, {2.0**-18})  # of u = (1, 1)
                store = f"{len(os.listdir(self.folder.name))}.db"
                run(store, *order)
                self.assertEqual(judged(store), found)
                lcpbench("certify", "--store", self.path(store))  # exit code 0: no contradiction
                self.assertEqual(judged(store), found)

        run("a.db", passes, denies)  # certified only afterwards
        lcpbench("certify", "--store", self.path("a.db"))
        self.assertEqual(judged("a.db"), [("nearly", "solved"), ("nearly", "unsolvable")])
        run("b.db", gives_up)
        lcpbench("certify", "--store", self.path("b.db"))
        self.assertEqual(judged("b.db"), [("unsolvable", "unsolvable")])
        lcpbench("merge", "--mixed", self.path("m.db"), self.path("b.db"), self.path("a.db"))
        self.assertEqual(judged("m.db"), [("nearly", "missed"), ("nearly", "solved"), ("nearly", "unsolvable")])
        text = " ".join(lcpbench("solve", self.path("x.json"), "--solver", passes, "--solver", proves).split())
        words = "proven to have no exact solution, but within the tolerance of one"
        self.assertIn("nearly solvable: " + words + "; every answer violates some contact by at least 3.81e-06 m/s", text)
        lcpbench("report", self.path("m.db"), "--out", self.path("report"))
        with open(self.path("report/report.html"), encoding="utf-8") as file:
            self.assertIn("1 problem is nearly solvable: " + words, file.read())
        with open(self.path("report/summary.json"), encoding="utf-8") as file:
            cells = json.load(file)["cells"]
        self.assertEqual([sum(cell[key] for cell in cells) for key in ("nearly_problems", "nearly_solved",
                                                                       "nearly_unsolvable", "false_claims")], [3, 1, 1, 0])

    def test_what_one_denies_rightly_is_the_truth_for_all(self):
        """No z solves it exactly, by 1e-10. Who denies it brings no proof: the judge finds one."""
        problem = {"format": "lcpbench-problem", "version": 1, "name": "x", "kind": "lcp",
                   "M": [[0, 0], [1, 1]], "q": [-1e-10, -1]}
        self.write("x.json", problem)
        near = {"claim": "solved", "z": [0, 1]}
        self.assertTrue(second_judge.judge(problem, near["z"])["passes"])
        solvers = [argument for name, answer in (("near", near), ("denies", {"claim": "unsolvable"}),
                                                 ("lost", {"claim": "iteration_limit", "z": [0, 1]}))
                   for argument in ("--solver", self.answering(name, answer))]
        rows = json.loads(lcpbench("solve", self.path("x.json"), *solvers, "--format", "json"))
        verdicts = {row["claim"]: row["verdict"] for row in rows}
        self.assertEqual(verdicts, {"solved": "solved", "unsolvable": "unsolvable", "iteration_limit": "solved"})
        self.assertEqual({row["truth"] for row in rows}, {"nearly"})
        alone = json.loads(lcpbench("solve", self.path("x.json"), *solvers[:2], "--format", "json"))
        self.assertEqual(alone[0]["verdict"], "solved")  # nobody denied it

        lcpbench("run", "--set", "file:" + self.path("x.json"), *solvers, "--store", self.path("s.db"))
        with sqlite3.connect(self.path("s.db")) as store:
            self.assertEqual(store.execute("SELECT certificate FROM certificates").fetchall(), [("unsolvable",)])
            self.assertEqual(dict(store.execute("SELECT claim, verdict FROM judged")), verdicts)
        store.close()

    def test_no_answer_contradicts_a_clear_proof(self):
        """It misses a solution by a thousandth of its size. Huge multipliers pass all the same, and count for nothing."""
        problem = {"format": "lcpbench-problem", "version": 1, "name": "x", "kind": "lcp",
                   "M": [[1, -1], [-1, 1]], "q": [-1, 0.998]}
        self.write("x.json", problem)
        huge = {"claim": "solved", "z": [1e9 + 1, 1e9]}
        self.assertTrue(second_judge.judge(problem, huge["z"])["passes"])
        self.assertGreater(second_judge.proof_margin(problem, [1, 1]), second_judge.SOLVED_ETA)
        proves = {"claim": "unsolvable", "farkas": [1, 1]}
        answers = (("huge", huge), ("denies", {"claim": "unsolvable"}), ("proves", proves),
                   ("lost", {"claim": "iteration_limit", "z": huge["z"]}))
        expected = {"solved": "wrong", "unsolvable": "unsolvable", "iteration_limit": "unsolvable"}
        for deniers in (("denies",), ("proves",)):
            solvers = [argument for name, answer in answers if name not in ("denies", "proves") or name in deniers
                       for argument in ("--solver", self.answering(name, answer))]
            rows = json.loads(lcpbench("solve", self.path("x.json"), *solvers, "--format", "json"))
            self.assertEqual({row["claim"]: row["verdict"] for row in rows}, expected)
            self.assertEqual({row["truth"] for row in rows}, {"unsolvable"})
            store = self.path(deniers[0] + ".db")
            lcpbench("run", "--set", "file:" + self.path("x.json"), *solvers, "--store", store)
            with sqlite3.connect(store) as connection:
                self.assertEqual(dict(connection.execute("SELECT claim, verdict FROM judged")), expected)
            connection.close()


unittest.main(argv=sys.argv[:1])
