#!/usr/bin/python3
"""Kills a random process of a run at a random moment, resumes, and compares the end with an undisturbed run.

    python3 tests/faults/random_kills.py [--kills N] [--seed N] [--jobs N] [--bodies own|bullet|mujoco]
                                         [--record FILE.jsonl] [--report FILE.jsonl…]
"""

import argparse
import json
import os
import random
import signal
import statistics
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from hurt_run import LONGEST_S, VICTIMS, digest, go_on, has_checkpoint, start_again, undisturbed_digest, wait_for

LATEST_S = 2.5  # a run takes about two seconds
AT_START = 0.25  # of the kills hit a rank that has just started, when MPI is easily hurt
JUST_STARTED_S = 0.02
MOST_KILLS_PER_RUN = 3


def run_under_fire(seed, bodies="own"):
    """One run that is killed up to three times before it may end; one dictionary per kill."""
    choose = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="copepod_faults_") as folder:
        folder = Path(folder).resolve()
        kills = []
        for _ in range(choose.randint(1, MOST_KILLS_PER_RUN)):
            kill = _kill_once(folder, choose, bodies)
            if kill is None:
                break
            kills.append(kill)
        ending = "by itself" if kill is None else go_on(folder, *_arguments(choose, bodies))
        return [{**kill, "seed": seed, "ending": ending, "digest": digest(folder)} for kill in kills]


def _kill_once(folder, choose, bodies):
    """What was killed and how the command took it; None if the run finished before."""
    run, _ = start_again(folder, *_arguments(choose, bodies))
    victims = list(VICTIMS)
    choose.shuffle(victims)
    if choose.random() < AT_START:
        victims.sort(key=lambda victim: not victim.startswith("fluid"))
        wait_for(lambda: run.has(victims[0]) or run.process.poll() is not None, LATEST_S)
        time.sleep(choose.uniform(0.0, JUST_STARTED_S))
    else:
        time.sleep(choose.uniform(0.0, LATEST_S))
    victim = next((victim for victim in victims if run.has(victim)), None)
    if victim is None or run.process.poll() is not None:
        run.end(LONGEST_S)
        return None
    start = time.monotonic()
    try:
        os.kill(run.pid(victim), signal.SIGKILL)
    except (AssertionError, ProcessLookupError):  # it ended in this very moment
        run.end(LONGEST_S)
        return None
    if not wait_for(lambda: run.process.poll() is not None, LONGEST_S):
        run.process.terminate()
    code = run.end(LONGEST_S)
    seconds = time.monotonic() - start
    if victim != "command":
        leftovers = run.leftovers()
    else:  # a resume waits by itself until the guard has cleaned up
        leftovers = [] if has_checkpoint(folder) else run.final_leftovers()
    message = run.stderr[-1].strip() if run.stderr else ""
    return {"victim": victim, "seconds": seconds, "code": code, "message": message, "leftovers": leftovers}


def _arguments(choose, bodies):
    return ["--ranks", str(choose.randint(1, 3)), "--set", f"body.solver={bodies}"]


def report(kills, expected):
    """Prints what came of all kills; the number of problems."""
    print("| killed | times | median | worst |\n|---|---|---|---|")
    for victim in VICTIMS:
        seconds = [kill["seconds"] for kill in kills if kill["victim"] == victim]
        if seconds:
            print(f"| {victim} | {len(seconds)} | {statistics.median(seconds):.2f} | {max(seconds):.2f} |")
    wrong = [kill for kill in kills if kill["digest"] != expected or kill["leftovers"]]
    runs = {kill["seed"]: kill["ending"] for kill in kills}
    endings = ", ".join(f"{list(runs.values()).count(ending)} {ending}" for ending in sorted(set(runs.values())))
    print(f"\n{len(kills)} kills in {len(runs)} runs ({endings}); {len(wrong)} with a problem")
    for kill in wrong:
        print(f"problem: {kill}")
    return len(wrong)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200, metavar="N", help="at least so many (200)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the first run (1)")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="runs at a time")
    parser.add_argument("--bodies", default="own", choices=("own", "bullet", "mujoco"), help="body.solver (own)")
    parser.add_argument("--record", type=Path, metavar="FILE", help="add what happened to this file")
    parser.add_argument("--report", type=Path, nargs="+", metavar="FILE", help="only print what was recorded")
    options = parser.parse_args()
    expected = undisturbed_digest("--set", f"body.solver={options.bodies}")
    kills, seed = [], options.seed
    for file in options.report or []:
        kills += [json.loads(line) for line in file.read_text().splitlines()]
    with ThreadPoolExecutor(options.jobs) as pool:
        while not options.report and len(kills) < options.kills:
            seeds = range(seed, seed + options.jobs)
            seed += options.jobs
            fresh = [
                kill
                for kills_of_run in pool.map(run_under_fire, seeds, [options.bodies] * options.jobs)
                for kill in kills_of_run
            ]
            kills += fresh
            if options.record:
                with options.record.open("a") as file:
                    file.writelines(json.dumps(kill) + "\n" for kill in fresh)
    return 1 if report(kills, expected) else 0


if __name__ == "__main__":
    sys.exit(main())
