"""The data set: its problems have the same bits everywhere, and its answers are right."""
import csv
import hashlib
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import lcpbench


class Dataset(unittest.TestCase):
    def test_a_part_of_it(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            subprocess.run([os.environ["LCPBENCH_PROGRAM"], "dataset", name, "--set", "*/g*", "--made", "38", "--contacts",
                            "40"], check=True, capture_output=True)
            rows = list(csv.DictReader((folder / "features.csv").read_text().splitlines()))
            made = [each for each in rows if each["set"].startswith("made/")]
            self.assertEqual(len(made), 2)  # of each of 19 sets, of which one begins with g
            seen = {(each["file"], int(each["step"])): k for k, each in enumerate(rows)}
            solved = 0
            for stem in {each["file"] for each in rows}:
                scenes = lcpbench.load(folder / stem)
                lines = (folder / stem.replace("scenes/", "answers/")).with_suffix(".jsonl").read_text().splitlines()
                self.assertEqual(len(lines), len(scenes))
                for step, line in zip(scenes, map(json.loads, lines)):
                    self.assertEqual(step.step, line["step"])
                    self.assertEqual(line["answer"]["impulses"], rows[seen[stem, step.step]]["impulses"])
                    solved += lcpbench.check(step.problem, line["answer"]["z"], line["answer"]["velocity"]).verdict == "solved"
            self.assertEqual(solved, len(rows))
            card = (folder / "README.md").read_text()
            self.assertIn(f"{len(rows)} time steps", card)
            even = [each["impulses"] for each in rows].count("even")
            self.assertIn(f'"even" ({even} of {len(rows)})', card)
            known = "".join(each[key] + "\n" for each in rows for key in list(each)[: list(each).index("verdict")])
            self.assertEqual(hashlib.sha256(known.encode()).hexdigest(),
                             "eb48ec49728a95d65ebd9af4d298c74a0843ae3bbcab5814d58fafe02c2f893a")


if __name__ == "__main__":
    unittest.main()
