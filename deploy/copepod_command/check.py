"""`copepod check`: everything about a case that can be known before it runs."""

import json
from argparse import Namespace
from dataclasses import asdict

from copepod_campaign.check import findings
from copepod_run.errors import ExitCode, Stop


def check(options: Namespace) -> int:
    """Prints the key figures of a case, sweep or campaign that can run; errors end in Stop(2)."""
    found = findings(options)
    if options.json:
        print(json.dumps(asdict(found)))
    else:
        print(f"{options.case}: {found.name}, {found.text()}")
    if found.problems:
        raise Stop(ExitCode.BAD_CASE)
    if not options.json:
        print("ok")
    return ExitCode.FINISHED
