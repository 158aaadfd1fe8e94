#!/usr/bin/env python3
"""Kills commands that write stores at random moments, and damages stores: bits, pages and rows.

    store_attack.py PROGRAM [--kills 1000] [--flips 1000] [--faults 1000] [--seed 1]

A kill holds when the same command, called again, is done with the rows of an unbroken one, and when a reader is served
in between. A flip of one bit holds when the command ends with exit code 2 and one line that names the store, or with
exactly what it says of the sound store. The same holds for faults that leave each row as it was: a page copied over
another, filled with zeros, exchanged with another, or as it was before the last command; a file cut between pages; rows
deleted or added with a right checksum; changed totals. Prints one line for each failure and the counts; exit code 1 for any failure.
"""

import argparse
import collections
import json
import pathlib
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time

TIMEOUT_S = 600  # a command that takes longer counts as blocked
PLAN = {"format": "lcpbench-plan", "version": 1, "name": "attacked", "trials": 40, "time_limit_s": 60,
        "repeat_until_s": 0.0002, "sets": ["paper/monotone/exp1", "paper/monotone/exp3"],
        "solvers": ["lemke", "regularized", {"solver": "lemke{cap=3n}", "sweep": "paper"}]}
TABLES = ("sets", "solvers", "parameterisations", "problems", "vectors", "cell_groups", "answers", "verdicts",
          "certificates", "proofs")  # not those that hold times
NOTHING_KEPT = ("no such store", "is empty")
PAGE = 4096
TAKES_LONG = "reading and checking every row of"  # a busy machine may take its second for that


def split_into_pages(content):
    return [content[at:at + PAGE] for at in range(0, len(content), PAGE)]


class Attack:
    def __init__(self, program, folder, seed):
        self.program, self.folder, self.random = program, folder, random.Random(seed)
        self.failures = 0
        self.counts = collections.Counter()
        self.durations = {}

    def path(self, name):
        return self.folder / name

    def fail(self, what):
        self.failures += 1
        print(f"FAILED: {what}", flush=True)

    def call(self, *arguments):
        """Exit code, standard output, standard error; None for a command that does not end."""
        try:
            done = subprocess.run([self.program, *map(str, arguments)], capture_output=True, cwd=self.folder,
                                  timeout=TIMEOUT_S)
        except subprocess.TimeoutExpired:
            return None, "", f"no end after {TIMEOUT_S} s"
        return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")

    def done(self, *arguments):
        code, out, err = self.call(*arguments)
        if code != 0:
            self.fail(f"{' '.join(map(str, arguments))}: exit code {code}: {err.strip()}")
        return out

    def rows(self, name):
        """Every row of a store but times, as text."""
        database = sqlite3.connect(f"file:{self.path(name)}?mode=ro", uri=True)
        try:
            return [(table, row) for table in TABLES
                    for row in sorted(map(repr, database.execute(f"SELECT * FROM {table}")))]
        except sqlite3.Error as error:
            return [("unreadable", str(error))]
        finally:
            database.close()

    def remove(self, name):
        for suffix in ("", "-wal", "-shm", "-journal", ".lock", ".merging"):
            self.path(name + suffix).unlink(missing_ok=True)

    def copy(self, source, target):
        self.remove(target)
        shutil.copy(self.path(source), self.path(target))

    # ------------------------------------------------------------------------------------------------ sound stores

    def prepare(self):
        self.path("plan.json").write_text(json.dumps(PLAN))
        for name, arguments in (("whole.db", ()), ("1.db", ("--shard", "1/2")), ("2.db", ("--shard", "2/2"))):
            self.done(*self.run_command(name), *arguments)
        self.copy("whole.db", "certified.db")
        self.done(*self.certify_command("certified.db"))
        self.older = split_into_pages(self.path("whole.db").read_bytes())
        self.whole, self.certified = self.rows("whole.db"), self.rows("certified.db")

    @staticmethod
    def run_command(store):
        return "run", "plan.json", "--jobs", 2, "--store", store

    @staticmethod
    def certify_command(store):
        return "certify", "--store", store, "--every", 1, "--jobs", 2, "--format", "json"

    # ------------------------------------------------------------------------------------------------------- kills

    def kill(self, kind, *arguments):
        """Starts a command and kills it. True when it was killed before its end."""
        self.counts[kind] += 1
        longest = self.durations.get(kind, 1.0)
        # Opening and closing a store are short: half of the kills aim at them.
        delay = self.random.choice((self.random.uniform(0, longest), self.random.uniform(0, min(0.05, longest)),
                                    self.random.uniform(0.8 * longest, 1.05 * longest)))
        begin = time.monotonic()
        process = subprocess.Popen([self.program, *map(str, arguments)], cwd=self.folder, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            code = process.wait(delay)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            code = process.wait()
        if code == -signal.SIGKILL:
            return True
        self.durations[kind] = time.monotonic() - begin
        if code != 0:
            self.fail(f"{kind}: exit code {code}")
        return False

    def is_served(self, kind, store):
        """A reader of what a kill left; it must know at least as many rows as after the kill before."""
        self.remove("read.db")
        code, _, err = self.call("merge", "read.db", store)
        if code == 0:
            return sum(table in ("answers", "certificates") for table, _ in self.rows("read.db"))
        if not any(words in err for words in NOTHING_KEPT):
            self.fail(f"{kind}: a reader is not served: exit code {code}: {err.strip()}")
        return 0

    def expect_rows(self, kind, store, rows):
        if self.rows(store) != rows:
            self.fail(f"{kind}: other rows than an unbroken one")

    def kill_until_done(self, kind, command, store, rows):
        """One kill of a command that resumes; a store that is complete is compared and begun anew."""
        if self.kill(kind, *command):
            answers = self.is_served(kind, store)
            if answers < self.answers.get(store, 0):
                self.fail(f"{kind}: {self.answers[store]} answers and certificates became {answers}")
            self.answers[store] = answers
            return True
        self.expect_rows(kind, store, rows)
        self.answers[store] = 0
        return False

    def kill_run(self):
        if not self.kill_until_done("run", self.run_command("run.db"), "run.db", self.whole):
            self.remove("run.db")

    def kill_certify(self):
        if not self.path("certify.db").exists():
            self.copy("whole.db", "certify.db")
        if not self.kill_until_done("certify", self.certify_command("certify.db"), "certify.db", self.certified):
            self.remove("certify.db")

    def kill_finished_run(self):
        self.copy("whole.db", "finished.db")
        self.kill("finished run", *self.run_command("finished.db"))
        self.is_served("finished run", "finished.db")
        self.done(*self.run_command("finished.db"))
        self.expect_rows("finished run", "finished.db", self.whole)

    def kill_fresh(self):
        self.copy("whole.db", "fresh.db")
        command = (*self.run_command("fresh.db"), "--fresh")
        self.kill("run --fresh", *command)
        self.is_served("run --fresh", "fresh.db")
        self.done(*command)
        self.expect_rows("run --fresh", "fresh.db", self.whole)

    def kill_merge(self):
        if self.random.random() < 0.5:
            self.remove("merged.db")
        command = ("merge", "merged.db", "1.db", "2.db")
        self.kill("merge", *command)
        self.done(*command)
        self.expect_rows("merge", "merged.db", self.whole)

    def kill_report(self):
        """Of a store that a killed run left."""
        source = "run.db" if self.path("run.db").exists() else "whole.db"
        for suffix in ("", "-wal", "-journal"):
            if self.path(source + suffix).exists():
                shutil.copy(self.path(source + suffix), self.path("reported.db" + suffix))
        if self.is_served("report", "reported.db") > 0:  # a store without an answer has no report
            command = ("report", "reported.db", "--out", "report")
            self.kill("report", *command)
            self.is_served("report", "reported.db")
            self.done(*command)
        self.remove("reported.db")

    def kills(self, count):
        self.answers = {}
        kinds = (self.kill_run, self.kill_certify, self.kill_merge, self.kill_finished_run, self.kill_run,
                 self.kill_fresh, self.kill_merge, self.kill_report)
        for number in range(count):
            kinds[number % len(kinds)]()
        print(f"{count} kills: " + ", ".join(f"{kind} {number}" for kind, number in sorted(self.counts.items())))

    # ------------------------------------------------------------------------------------------------------- flips

    def flip(self, store):
        self.copy("certified.db", store)
        bytes_ = bytearray(self.path(store).read_bytes())
        bit = self.random.randrange(8 * len(bytes_))
        bytes_[bit // 8] ^= 1 << bit % 8
        self.path(store).write_bytes(bytes_)
        return f"bit {bit}"

    def page_fault(self, pages):
        """What became of the pages, in words."""
        page, other = self.random.randrange(len(pages)), self.random.randrange(len(pages))
        older = [page for page in range(min(len(pages), len(self.older))) if self.older[page] != pages[page]]
        kind = self.random.choice(("copy", "zero", "swap", "cut", "lost write", "lost write"))
        if kind == "copy":
            pages[page] = pages[other]
        elif kind == "zero":
            pages[page] = bytes(PAGE)
        elif kind == "swap":
            pages[page], pages[other] = pages[other], pages[page]
        elif kind == "cut":
            del pages[page:]
        else:
            page = self.random.choice(older)
            pages[page] = self.older[page]
        return f"{kind} of page {page + 1}"

    def row_fault(self, store):
        """What was changed by SQL."""
        database = sqlite3.connect(self.path(store))
        filled = [table for table in (*TABLES, "runs", "timings", "certificate_timings", "totals")
                  if database.execute(f"SELECT 1 FROM {table} LIMIT 1").fetchone()]
        table = self.random.choice(filled)
        columns = [(name, key) for _, name, _, _, _, key in database.execute(f"PRAGMA table_info({table})")]
        keys = ", ".join(name for name, key in columns if key)
        count = self.random.choice((1, 1, 2, 10, 100))
        some = f"({keys}) IN (SELECT {keys} FROM {table} ORDER BY random() LIMIT {count})"
        others = ", ".join("1 - 2 * (random() & 1) + " + name if name == self.random.choice(keys.split(", ")) else name
                           for name, _ in columns)
        sql = self.random.choice((f"DELETE FROM {table} WHERE {some}", f"DELETE FROM {table} WHERE {some}",
                                  f"INSERT OR IGNORE INTO {table} SELECT {others} FROM {table} WHERE {some}",
                                  f"DELETE FROM {table}"))
        if table == "totals":
            sql = self.random.choice((f"DELETE FROM totals WHERE {some}", "UPDATE totals SET digest = digest + 1",
                                      f"UPDATE totals SET row_count = row_count + 1 WHERE {some}"))
        database.execute(sql)
        database.commit()
        database.close()
        return sql

    def fault(self, store):
        self.copy("certified.db", store)
        if self.random.random() < 0.3:
            return self.row_fault(store)
        pages = split_into_pages(self.path(store).read_bytes())
        what = self.page_fault(pages)
        self.path(store).write_bytes(b"".join(pages))
        return what

    def compared(self):
        return self.call("compare", "flipped.db", "certified.db", "--format", "json")

    def merged(self):
        self.remove("merged.db")
        code, _, err = self.call("merge", "merged.db", "flipped.db")
        return code, self.rows("merged.db") if code == 0 else "", err

    def certified_again(self):
        code, out, err = self.call(*self.certify_command("flipped.db"))
        return code, (json.loads(out)["sets"], self.rows("flipped.db")) if code == 0 else "", err

    def run_again(self):
        code, _, err = self.call(*self.run_command("flipped.db"))
        return code, self.rows("flipped.db") if code == 0 else "", err

    def reported(self):
        shutil.rmtree(self.path("report"), ignore_errors=True)
        code, _, err = self.call("report", "flipped.db", "--out", "report")
        return code, self.path("report/summary.json").read_text() if code == 0 else "", err

    def damages(self, name, count, damage):
        kinds = [self.compared, self.merged, self.certified_again, self.run_again] * 4 + [self.reported]
        expected = {}
        for kind in kinds[-5:]:
            self.copy("certified.db", "flipped.db")
            expected[kind] = kind()
            if expected[kind][0] != 0:
                self.fail(f"{kind.__name__} of the sound store: {expected[kind][2]}")
        refused = 0
        for number in range(count):
            kind = kinds[number % len(kinds)]
            what = damage("flipped.db")
            code, out, err = kind()
            lines = [line for line in err.strip().splitlines() if TAKES_LONG not in line]
            if code == 2 and len(lines) == 1 and "flipped.db: " in lines[0] and "internal error" not in lines[0]:
                refused += 1
            elif (code, out) != expected[kind][:2]:
                self.fail(f"{kind.__name__}, {what}: exit code {code}: {err.strip() or 'another result'}")
        print(f"{count} {name}: {refused} refused, the others without effect")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--flips", type=int, default=1000)
    parser.add_argument("--faults", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="lcpbench-attack-") as folder:
        attack = Attack(pathlib.Path(options.program).resolve(), pathlib.Path(folder), options.seed)
        attack.prepare()
        if attack.failures == 0:
            attack.kills(options.kills)
            attack.damages("flips", options.flips, attack.flip)
            attack.damages("faults of pages and rows", options.faults, attack.fault)
    print(f"{attack.failures} failures")
    return 1 if attack.failures else 0


if __name__ == "__main__":
    sys.exit(main())
