#!/usr/bin/env -S python3 -I -S
"""An external solver that does what the problem's name says: it answers right, lies, or misbehaves."""
import json
import os
import signal
import sys
import tempfile
import time


def right(problem):
    return {"claim": "solved", "z": [max(0.0, -q / row[i]) for i, (row, q) in enumerate(zip(problem["M"], problem["q"]))]}


def say(text):
    sys.stdout.write(text)
    sys.stdout.flush()


def raw(text):
    def answer(problem):
        say(text + "\n")

    return answer


def bounded_rows(problem):
    if "rows" not in problem:
        return {"claim": "unsupported", "detail": f"got {len(problem['N'][0])} contact"}
    rows, (inertia,), (v,) = problem["rows"], *problem["G"], problem["v"]
    return {"claim": "solved", "z": [max(0.0, -inertia * (rows["R"][0][0] * v + rows["b"][0]))]}


def with_fields(**fields):
    return lambda problem: {**right(problem), **fields}


def sleep_for_ever(problem):
    while True:
        time.sleep(1000)


def chatter(problem):
    for _ in range(3000):
        sys.stderr.write("x" * 1000 + "\n")
    sys.stderr.flush()
    return right(problem)


def huge(problem):
    while True:
        say("[" * 65536)


def fork_a_child(problem):
    if os.fork() == 0:
        sleep_for_ever(problem)
    return right(problem)


def stop_reading(problem):
    os.close(0)
    sleep_for_ever(problem)


def twice(problem):
    say(json.dumps(right(problem)) + "\n" + json.dumps(right(problem)) + "\n")


def closed_output(problem):
    os.close(1)
    sleep_for_ever(problem)


def not_utf_8(problem):
    sys.stdout.buffer.write(b'{"claim": "iteration_limit", "detail": "\xff"}\n')
    sys.stdout.buffer.flush()


def where(problem):
    return {"claim": "solved", "z": right(problem)["z"], "detail": os.getcwd()}


kept = {}


def keep(key, problem):
    if key not in kept:
        time.sleep(0.05)
        kept[key] = right(problem)
    return kept[key]


def cache(problem):
    return keep(json.dumps(problem), problem)


def start_daemon():
    read_end, write_end = os.pipe()
    if os.fork() == 0:
        os.setsid()
        daemon = os.fork()
        if daemon == 0:
            sleep_for_ever(None)
        os.write(write_end, str(daemon).encode())
        os._exit(0)
    os.wait()
    return int(os.read(read_end, 20))


def daemon(problem):
    return {"claim": "iteration_limit", "iterations": start_daemon()}


def daemon_and_sleep(problem):
    start_daemon()
    sleep_for_ever(problem)


def process(problem):
    return {"claim": "iteration_limit", "iterations": os.getpid()}


def write(problem):
    with tempfile.TemporaryFile() as file:
        file.write(b"x" * 8192)
    return right(problem)


behaviours = {
    "right": right,
    "delays": right,
    "bounded_rows": bounded_rows,
    "process": process,
    "cache": cache,
    "write": write,
    "daemon": daemon,
    "daemon and sleep": daemon_and_sleep,
    "late line": lambda problem: say(last_answer) or sleep_for_ever(problem),
    "key twice": raw('{"claim": "solved", "z": [1, 1, 1, 1, 1], "z": [0.5, 0.5, 0.5, 0.5, 0.5]}'),
    "wrong number": with_fields(sequence=1),
    "no number": with_fields(sequence=None),
    "start": lambda problem: {**right(problem), "detail": str(request.get("start"))},
    "where": where,
    "chatter": chatter,
    "fork": fork_a_child,
    "no z": lambda problem: {"claim": "iteration_limit"},
    "unsupported": lambda problem: {"claim": "unsupported", "detail": "no such problems"},
    "exception": lambda problem: problem["no such field"],
    "segfault": lambda problem: os.kill(os.getpid(), signal.SIGSEGV),
    "exit 0": lambda problem: os._exit(0),
    "sleep": sleep_for_ever,
    "no line end": lambda problem: say("{") or sleep_for_ever(problem),
    "stop": lambda problem: os.kill(os.getpid(), signal.SIGSTOP),
    "close the output": closed_output,
    "stop reading": stop_reading,
    "huge": huge,
    "twice": twice,
    "debug": lambda problem: say("here I am\n" + json.dumps(right(problem)) + "\n"),
    "garbage": raw("solved!"),
    "not utf-8": not_utf_8,
    "an array": raw("[1, 2]"),
    "nan": raw('{"claim": "solved", "z": [NaN, 0, 0, 0, 0]}'),
    "null": raw('{"claim": "solved", "z": [null, 0, 0, 0, 0]}'),
    "overflow": raw('{"claim": "solved", "z": [1e999, 0, 0, 0, 0]}'),
    "short": with_fields(z=[1.0]),
    "long": with_fields(z=[1.0] * 2000),
    "z is a text": with_fields(z="0 0 0 0 0"),
    "velocity": with_fields(velocity=[1.0]),
    "solved without z": lambda problem: {"claim": "solved"},
    "no claim": lambda problem: {"z": right(problem)["z"]},
    "claims a crash": lambda problem: {"claim": "crashed"},
    "unknown claim": lambda problem: {"claim": "optimal"},
    "unknown field": with_fields(zeta=1),
    "negative counter": with_fields(iterations=-5),
    "counters": with_fields(iterations=3, pivots=5, factorizations=7, detail="three\nlines\x1b[31m"),
}

version = 1 if "--version-1" in sys.argv or "--only-version-1" in sys.argv else 2
problem = None
last_answer = ""
for line in sys.stdin:
    request = json.loads(line)
    reply = {}
    if "--only-version-1" in sys.argv and (request.get("version", 1) != 1 or "sequence" in request):
        sys.exit("unknown version")
    if request["verb"] == "problem":
        problem = request["problem"]
    if problem and problem["name"] == "delays":
        time.sleep({"problem": 0.2, "setup": 0.1, "solve": 0.05}[request["verb"]])
    if request["verb"] == "solve":
        reply = behaviours[problem["name"]](problem)
    if reply is None:
        continue
    if version == 2:
        reply = {"sequence": request["sequence"], **reply}
        if reply["sequence"] is None:
            del reply["sequence"]
    say(json.dumps(reply) + "\n")
    if request["verb"] == "solve":
        last_answer = json.dumps(reply) + "\n"
