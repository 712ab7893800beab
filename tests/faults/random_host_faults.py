#!/usr/bin/python3
"""Hurts runs over three hosts at random: processes killed or frozen, networks cut; all drawn from a seed.

    python3 tests/faults/random_host_faults.py [--faults N] [--seed N] [--record FILE.jsonl] [--report FILE.jsonl…]
"""

import argparse
import dataclasses
import json
import os
import random
import signal
import statistics
import sys
import time
from pathlib import Path

from hurt_hosts import VICTIMS, HostsRun, finish, outcome_of, three_hosts
from hurt_run import LONGEST_S, digest, wait_for

LATEST_S = 6.5  # after the start; a run takes about seven seconds, half of them for its start
SILENCE_S = 6.0
LONGEST_CUT_S = 9.0
STEPS = ("--set", "run.steps=200")


def hurt_at_random(seed, expected_digest):
    """What came of the fault of this seed, as a dictionary; None if the run had finished before."""
    choose = random.Random(seed)
    fault = choose.choice(("kill", "kill", "freeze", "cut"))
    with three_hosts() as (hosts, folder):
        silence = ("--set", f"services.silence_s={SILENCE_S}")
        run = HostsRun(hosts, folder, "--out", "out", "--hosts", "a,b,c", *STEPS, *silence)
        time.sleep(choose.uniform(0.0, LATEST_S))
        start = time.monotonic()
        host, what = _cut(hosts, run, choose) if fault == "cut" else _signal(run, choose, fault)
        found = {"seed": seed, "fault": fault, "host": host, "what": what}
        outcome = outcome_of(run, start)
        hosts.mend()
        if what is None:
            return None
        outcome.digest = digest(folder) if outcome.code == 0 else finish(hosts, folder, *STEPS)
        words = "" if (fault, what) == ("kill", "command") else "host [abc]" if host == "a" else f"host {host}"
        return {**found, "problems": outcome.problems(words, expected_digest), **dataclasses.asdict(outcome)}


def _signal(run, choose, fault):
    """(host, kind) of the process, None if the run has ended; a frozen command continues after a while (Ctrl-Z)."""
    for host, kind in choose.sample(sorted(VICTIMS), len(VICTIMS)):
        for pid in run.victims(host, kind):
            try:
                os.kill(pid, signal.SIGKILL if fault == "kill" else signal.SIGSTOP)
            except ProcessLookupError:
                continue
            if fault == "freeze" and kind == "command":
                time.sleep(choose.uniform(0.5, 2 * SILENCE_S))
                os.kill(pid, signal.SIGCONT)
                run.process.send_signal(signal.SIGCONT)  # nsenter has stopped with it
            return host, kind
    return None, None


def _cut(hosts, run, choose):
    """(host, direction) of a cut, None if the run has ended."""
    host, direction = choose.choice("abc"), choose.choice(("both", "out", "in"))
    seconds = choose.uniform(0.5, LONGEST_CUT_S)
    if run.process.poll() is not None:
        return None, None
    hosts.cut(host, direction)
    wait_for(lambda: run.process.poll() is not None, seconds)
    if run.process.poll() is None:
        hosts.mend()
    return host, direction


def undisturbed_digest():
    """What every run must end with."""
    with three_hosts() as (hosts, folder):
        run = HostsRun(hosts, folder, "--out", "out", *STEPS)
        if run.end(LONGEST_S) != 0:
            raise SystemExit(f"the undisturbed run failed: {run.last_line}")
        return digest(folder)


def report(found):
    """Prints what came of all faults; the number of those with a problem."""
    print("| fault | hit | times | finished | median | worst | clean after, worst |\n|---|---|---|---|---|---|---|")
    ended = [one for one in found if one["code"] is not None]
    for fault, what in sorted({(one["fault"], one["what"]) for one in ended}):
        alike = [one for one in ended if (one["fault"], one["what"]) == (fault, what)]
        seconds = [one["seconds"] for one in alike]
        figures = f"{statistics.median(seconds):.1f} | {max(seconds):.1f} | {max(one['clean_s'] for one in alike):.1f}"
        print(f"| {fault} | {what} | {len(alike)} | {sum(one['code'] == 0 for one in alike)} | {figures} |")
    wrong = [one for one in found if one["problems"]]
    print(f"\n{len(found)} faults, {len(wrong)} with a problem")
    for one in wrong:
        print(f"seed {one['seed']}: {one['fault']} {one['what']} on {one['host']}: {'; '.join(one['problems'])}")
    return len(wrong)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", type=int, default=200, metavar="N", help="so many (200)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the first (1)")
    parser.add_argument("--record", type=Path, metavar="FILE", help="add what happened to this file")
    parser.add_argument("--report", type=Path, nargs="+", metavar="FILE", help="only print what was recorded")
    options = parser.parse_args()
    if options.report:
        return 1 if report([json.loads(line) for file in options.report for line in file.open()]) else 0
    expected, found, seed = undisturbed_digest(), [], options.seed
    while len(found) < options.faults:
        one = hurt_at_random(seed, expected)
        seed += 1
        if one is None:
            continue
        found.append(one)
        if options.record:
            with options.record.open("a") as file:
                file.write(json.dumps(one) + "\n")
    return 1 if report(found) else 0


if __name__ == "__main__":
    sys.exit(main())
