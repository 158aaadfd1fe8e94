#!/usr/bin/env python3
"""Runs the commands of docs/howto/cluster.md, and compares what comes out with one run on one machine.

    cluster_test.py parallel LCPBENCH   GNU parallel, here and over ssh, by a server of this test's own
    cluster_test.py slurm LCPBENCH      a Slurm of this test's own, of one node; cancels and kills

Exit codes: 0 done, 1 a check failed, 77 what the test needs is not there.
"""
import collections
import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PLAN = {
    "format": "lcpbench-plan", "version": 1, "name": "example", "repeat_until_s": 0, "time_limit_s": 300,
    "sets": ["paper/monotone/exp1", "paper/copositive/exp1", {"set": "planted/definite", "trials": 5}],
    "solvers": [{"solver": "lemke", "sweep": "paper"}, {"solver": "contact_lemke", "every": 2, "sets": ["paper/*"]},
                {"solver": "bullet_dantzig", "every": 4, "optional": True}]}
TABLES = ("sets", "solvers", "parameterisations", "problems", "vectors", "cell_groups", "answers", "verdicts",
          "certificates", "proofs")


def skip(reason):
    print("skipped: " + reason)
    sys.exit(77)


def need(*programs):
    for program in programs:
        if shutil.which(program) is None:
            skip(f"{program} is not installed")


def check(holds, what):
    if not holds:
        sys.exit("failed: " + what)
    print("holds: " + what)


def wait_for(condition, what, seconds=600):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            sys.exit("failed: waited in vain for " + what)
        time.sleep(0.1)


class Folder:
    """A scratch folder in which the page's commands are run."""

    def __init__(self, path, lcpbench, trials):
        self.path = path
        self.environment = dict(os.environ, PATH=f"{pathlib.Path(lcpbench).resolve().parent}:{os.environ['PATH']}",
                                HOME=str(path), LC_ALL="C.UTF-8")
        (path / "plan.json").write_text(json.dumps(dict(PLAN, trials=trials)))
        os.symlink(ROOT / "examples", path / "examples")
        (path / ".parallel").mkdir()
        (path / ".parallel/will-cite").touch()

    def run(self, command, expected=0, **environment):
        ended = subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=self.path, stdin=subprocess.DEVNULL,
                               env=dict(self.environment, **environment), stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True)
        if ended.returncode != expected:
            sys.exit(f"failed: exit code {ended.returncode} of\n{command}\n{ended.stdout}")
        return ended.stdout

    def page(self, name, **environment):
        """Runs the block of this name."""
        text = (ROOT / "docs/howto/cluster.md").read_text()
        return self.run(re.search(rf"^```sh {name}\n(.*?)^```$", text, flags=re.S | re.M)[1], **environment)

    def serial(self):
        self.run("lcpbench run plan.json --jobs 1 --store serial.db; lcpbench report serial.db --out serial")

    def query(self, store, sql):
        """A run that was killed while it opened the store leaves a journal, and only a writer may roll that back."""
        for mode in ("ro", "rw"):
            with contextlib.closing(sqlite3.connect(f"file:{self.path / store}?mode={mode}", uri=True)) as database:
                try:
                    return database.execute(sql).fetchall()
                except sqlite3.OperationalError:
                    if mode == "rw":
                        raise

    def cells(self, store):
        """How many cells a store holds. A shard that has only just begun has no file yet, or one without tables."""
        if not (self.path / store).exists() or not self.query(store, "SELECT 1 FROM sqlite_master WHERE name = 'answers'"):
            return 0
        return self.query(store, "SELECT IFNULL(SUM(s.cells), 0) FROM answers a JOIN solvers s ON s.id = a.solver_id "
                          "WHERE a.part = 0")[0][0]

    def compare(self, store, report):
        """With the serial run: rows, and what the report counts."""
        for table in TABLES:
            rows = [collections.Counter(self.query(each, f"SELECT * FROM {table}")) for each in (store, "serial.db")]
            check(rows[0] == rows[1], f"{table}: {sum(rows[0].values())} rows of {store} as in the serial run")
        summaries = []
        for folder in (report, "serial"):
            summary = json.loads((self.path / folder / "summary.json").read_text())
            cells = [{key: value for key, value in cell.items() if "time" not in key} for cell in summary["cells"]]
            summaries.append((summary["coverage"], cells, summary["sweeps"]))
        check(summaries[0] == summaries[1], f"{len(summaries[0][1])} cells of the report as in that of the serial run")
        check(summaries[0][0]["share"] == 1, "nothing is missing")


def test_parallel(folder):
    need("parallel")
    folder.serial()
    folder.page("pilot")
    # A machine without a library names what is missing, and one that has it adds that.
    has_bullet = "Bullet" in folder.run("lcpbench solvers") and folder.query(
        "serial.db", "SELECT COUNT(*) FROM solvers WHERE name = 'bullet_dantzig'")[0][0] > 0
    folder.run("lcpbench run plan.json --shard 1/8 --costs pilot.db --jobs 1 --store shard-1.db",
               LCPBENCH_WORKER_DIR=str(folder.path))
    run = json.loads(folder.query("shard-1.db", "SELECT provenance FROM runs WHERE started <> ''")[0][0])
    check(any(entry.startswith("bullet_dantzig: ") for entry in run["skipped"]), "the run says what it left out")
    if has_bullet:
        folder.run("lcpbench run plan.json --shard 2/8 --costs pilot.db --jobs 1 --store shard-2.db; "
                   "lcpbench merge part.db shard-1.db shard-2.db; lcpbench report part.db --out part")
        left_out = json.loads((folder.path / "part/summary.json").read_text())["coverage"]["left_out"]
        check(len(left_out) == 1 and all(line.startswith("bullet_dantzig: ") and missing > 0
                                         for line, missing in left_out.items()),
              "the report names the missing cells of the solver that a machine does not have")
    folder.page("parallel")
    folder.compare("merged.db", "report")
    if all(map(shutil.which, ("ssh", "ssh-keygen"))) and os.path.exists("/usr/sbin/sshd"):
        for file in folder.path.glob("shard-*.db"):
            file.unlink()
        (folder.path / "merged.db").unlink()
        with ssh_server(folder):
            folder.page("ssh", PARALLEL_SSH=f"ssh -F {folder.path}/ssh_config")
        folder.compare("merged.db", "report")
    else:
        print("left out: over ssh, as openssh-client and openssh-server are not installed")


@contextlib.contextmanager
def daemon(*command, **options):
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL, **options)
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


@contextlib.contextmanager
def ssh_server(folder):
    """Two names for this machine, node1 and node2."""
    for key in ("host_key", "user_key"):
        folder.run(f"ssh-keygen -q -t ed25519 -N '' -f {key}")
    port = free_port()
    (folder.path / "sshd_config").write_text(
        f"Port {port}\nListenAddress 127.0.0.1\nHostKey {folder.path}/host_key\nPidFile none\nUsePAM no\n"
        f"StrictModes no\nPermitRootLogin yes\nAuthorizedKeysFile {folder.path}/user_key.pub\n")
    (folder.path / "ssh_config").write_text(
        f"Host node1 node2\nHostName 127.0.0.1\nPort {port}\nIdentityFile {folder.path}/user_key\n"
        "IdentitiesOnly yes\nStrictHostKeyChecking no\nUserKnownHostsFile /dev/null\nLogLevel ERROR\n")
    if os.geteuid() == 0:
        os.makedirs("/run/sshd", exist_ok=True)  # sshd asks for it
    with daemon("/usr/sbin/sshd", "-D", "-f", str(folder.path / "sshd_config")):
        wait_for(lambda: subprocess.run(["ssh", "-F", str(folder.path / "ssh_config"), "node1", "true"],
                                        stderr=subprocess.DEVNULL).returncode == 0, "sshd")
        yield


@contextlib.contextmanager
def slurm(folder):
    state = folder.path / "slurm"
    for name in ("munge", "state", "spool"):
        (state / name).mkdir(parents=True)
    (state / "munge").chmod(0o700)
    key = state / "munge/key"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o400)
    host = socket.gethostname().split(".")[0]
    (state / "slurm.conf").write_text("\n".join((
        "ClusterName=test", f"SlurmctldHost={host}(127.0.0.1)", "SlurmUser=root", "AuthType=auth/munge",
        f"AuthInfo=socket={state}/munge/socket", f"SlurmctldPort={free_port()}", f"SlurmdPort={free_port()}",
        f"SlurmctldPidFile={state}/slurmctld.pid", f"SlurmdPidFile={state}/slurmd.pid",
        f"StateSaveLocation={state}/state", f"SlurmdSpoolDir={state}/spool", "ProctrackType=proctrack/linuxproc",
        "TaskPlugin=task/none", "SelectType=select/cons_tres", "SelectTypeParameters=CR_Core",
        "SwitchType=switch/none", "MpiDefault=none", "JobAcctGatherType=jobacct_gather/none",
        "AccountingStorageType=accounting_storage/none", "KillWait=5", "ReturnToService=2",
        f"SlurmctldLogFile={state}/slurmctld.log", f"SlurmdLogFile={state}/slurmd.log",
        "SchedulerParameters=batch_sched_delay=0,sched_interval=2",
        f"NodeName={host} NodeAddr=127.0.0.1 CPUs={min(2, os.cpu_count())} RealMemory=8000 State=UNKNOWN",
        f"PartitionName=all Nodes={host} Default=YES State=UP", "")))
    (state / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")  # the only one that starts where none are mounted
    folder.environment["SLURM_CONF"] = str(state / "slurm.conf")

    def answer(command):
        return subprocess.run(command, env=folder.environment, capture_output=True, text=True).stdout.strip()

    munged = ("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={state}/munge/socket",
              f"--pid-file={state}/munge/pid", f"--log-file={state}/munge/log", f"--seed-file={state}/munge/seed")
    with contextlib.ExitStack() as daemons:
        daemons.enter_context(daemon(*munged))
        wait_for((state / "munge/socket").exists, "munged")
        for name in ("slurmctld", "slurmd"):
            daemons.enter_context(daemon(name, "-D", "-f", str(state / "slurm.conf"), env=folder.environment))
        wait_for(lambda: answer(["sinfo", "-h", "-o", "%T"]) == "idle", "an idle node")
        try:
            yield answer
        finally:
            subprocess.run(["scancel", "--user=root"], env=folder.environment)
            wait_for(lambda: answer(["squeue", "-h"]) == "", "the end of all jobs")


def shard_process(folder, most):
    """The process of a running shard that has written something, but no more than `most` cells, and its store."""
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            words = (process / "cmdline").read_bytes().decode().split("\0")
            store = words[words.index("--store") + 1] if "--shard" in words and "--store" in words else ""
            if store.startswith(str(folder.path)) and 0 < folder.cells(store) <= most:
                return int(process.name), pathlib.Path(store).relative_to(folder.path)
    return None


def test_slurm(folder):
    need("munged", "slurmctld", "slurmd", "sbatch")
    if os.geteuid() != 0:
        skip("slurmd starts jobs as root only")
    folder.serial()
    folder.page("pilot")
    whole = folder.cells("serial.db")

    def done():
        return sum(folder.cells(f"shards/shard-{i}.db") for i in range(1, 9))

    with slurm(folder) as answer:
        def idle():
            return answer(["squeue", "-h"]) == ""

        print(folder.page("slurm"))
        wait_for(lambda: done() > whole / 4, "a quarter of the cells")
        subprocess.run(["scancel", "--name=lcpbench-shard"], env=folder.environment, check=True)
        wait_for(idle, "the end of the cancelled array and of what depends on it")
        cancelled = done()
        check(whole / 4 < cancelled < whole and not (folder.path / "shards/merged.db").exists(),
              f"{cancelled} of {whole} cells are kept when the array is cancelled, and nothing is merged")

        print(folder.page("slurm"))
        found = []
        wait_for(lambda: found.append(shard_process(folder, whole / 16)) or found[-1],
                 "a running shard with cells written and to come")
        process, store = found[-1]
        before = folder.cells(store)
        os.kill(process, signal.SIGKILL)
        wait_for(idle, "the end of the array")
        check(before <= folder.cells(store) and not (folder.path / "shards/merged.db").exists(),
              f"{store} keeps its {before} cells when it is killed, and nothing is merged")
        listed = folder.run("lcpbench run plan.json --jobs 1 --list-shards 8 --costs pilot.db "
                            "--store 'shards/shard-{}.db' --format json")
        missing = json.loads(listed[listed.index("{"):])["array"]
        check(missing == re.search(r"\d+", store.name)[0], f"shard {missing} alone is to be run again")

        print(folder.page("slurm"))
        wait_for((folder.path / "shards/report/summary.json").exists, "the report")
        wait_for(idle, "the end of the report")
        folder.compare("shards/merged.db", "shards/report")
        check("shards: none" in folder.page("slurm"), "nothing is left to run")
        wait_for(idle, "the second merge and report")


if __name__ == "__main__":
    kind, program = sys.argv[1:]
    with tempfile.TemporaryDirectory(prefix="lcpbench-") as scratch:
        if kind == "parallel":
            test_parallel(Folder(pathlib.Path(scratch), program, 4))
        else:
            test_slurm(Folder(pathlib.Path(scratch), program, 30))
