#!/usr/bin/python3
"""Disturbs a run in every way in every phase, and reports the time until detection and whether the run could continue.

    python3 tests/faults/matrix.py [--only REGEX] [--repeat N] [--jobs N] [--record FILE.jsonl] [--report FILE.jsonl…]
"""

import argparse
import dataclasses
import json
import re
import statistics
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from hurt_run import FAULTS, PHASES, VICTIMS, Finding, hurt, makes_sense, undisturbed_digest


def cells(only):
    """(victim, phase, fault) of the matrix whose words match `only`."""
    everything = [(victim, phase, fault) for fault in FAULTS for victim in VICTIMS for phase in PHASES]
    return [cell for cell in everything if makes_sense(*cell) and re.search(only, " ".join(cell))]


def problems(finding, expected_digest):
    """What is wrong with a finding; empty if nothing is."""
    wrong = []
    if finding.leftovers:
        wrong.append(f"left behind: {', '.join(finding.leftovers)}")
    if not finding.is_named:
        wrong.append(f"not named: {finding.message}")
    if finding.code == 0 and (finding.victim, finding.fault) != ("command", "freeze"):
        wrong.append("not noticed")
    if finding.digest != expected_digest:
        wrong.append(f"digest {finding.digest or 'missing'} instead of {expected_digest} ({finding.went_on})")
    return wrong


def report(findings):
    """The matrix as Markdown tables, one per fault; seconds per cell are medians."""
    for fault in FAULTS:
        print(f"\n| {fault} | {' | '.join(PHASES)} | median | worst |")
        print("|---" * (len(PHASES) + 3) + "|")
        for victim in VICTIMS:
            row = [f for f in findings if (f.victim, f.fault) == (victim, fault)]
            if row:
                seconds = [f.seconds for f in row]
                figures = " | ".join(_cell(row, phase) for phase in PHASES)
                print(f"| {victim} | {figures} | {statistics.median(seconds):.2f} | {max(seconds):.2f} |")
    went_on = [f.went_on for f in findings]
    print(f"\n{len(findings)} faults; " + ", ".join(f"{went_on.count(how)} {how}" for how in sorted(set(went_on))))


def _cell(row, phase):
    seconds = [f.seconds for f in row if f.phase == phase]
    return f"{statistics.median(seconds):.2f}" if seconds else "–"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", metavar="REGEX", help="cells whose «victim phase fault» matches")
    parser.add_argument("--repeat", type=int, default=1, metavar="N", help="times per cell")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="runs at a time")
    parser.add_argument("--record", type=Path, metavar="FILE", help="add the findings to this file")
    parser.add_argument("--report", type=Path, nargs="+", metavar="FILE", help="only print what was recorded")
    options = parser.parse_args()
    if options.report:
        lines = [line for file in options.report for line in file.read_text().splitlines()]
        report([Finding(**json.loads(line)) for line in lines])
        return 0
    expected = undisturbed_digest()
    findings, failed = [], 0
    with ThreadPoolExecutor(options.jobs) as pool:
        for finding in pool.map(lambda cell: hurt(*cell), cells(options.only) * options.repeat):
            findings.append(finding)
            wrong = problems(finding, expected)
            failed += bool(wrong)
            words = f"{finding.fault} {finding.victim}, {finding.phase}: {finding.seconds:.2f} s, {finding.went_on}"
            print("; ".join([words, *wrong]), file=sys.stderr, flush=True)
            if options.record:
                with options.record.open("a") as file:
                    file.write(json.dumps(dataclasses.asdict(finding)) + "\n")
    report(findings)
    print(f"{failed} with a problem")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
