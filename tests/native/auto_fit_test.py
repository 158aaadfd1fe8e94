#!/usr/bin/env python3
"""The table of auto's predictions is what `auto_fit.py fit` makes of the measured costs in results/auto."""
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def fit(table):
    command = [sys.executable, str(ROOT / "native/auto/measure/auto_fit.py"), "fit", str(table)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def numbers_of(text):
    """The numbers of the rows, in their order."""
    return [float(number) for number in re.findall(r"(?<=[{ ])-?\d[\d.]*", text)]


class AutoFit(unittest.TestCase):
    def test_the_table_is_fitted_to_the_measured_costs(self):
        fitted = numbers_of(fit(ROOT / "results/auto/costs.csv").stdout)
        table = numbers_of((ROOT / "native/auto/prediction_rows.inc").read_text(encoding="utf-8"))
        self.assertLessEqual(sum(number != 0 for number in table), 100)
        self.assertEqual(len(fitted), len(table))
        for k, (of_fit, of_table) in enumerate(zip(fitted, table)):
            self.assertLessEqual(abs(of_fit - of_table), 1.5e-3, k)  # rounded to three digits

    def test_refuses_what_is_no_table(self):
        for file in ("no/such/file", ROOT / "README.md"):
            result = fit(file)
            self.assertNotEqual(result.returncode, 0)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)


if __name__ == "__main__":
    unittest.main()
