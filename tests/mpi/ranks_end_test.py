#!/usr/bin/python3
"""kill -9 of mpirun, or of one rank, leaves no rank behind.

    ranks_end_test.py PROGRAM MPIRUN…      PROGRAM is write_fields, which runs for minutes
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

PROGRAM, MPIRUN = sys.argv[1], sys.argv[2:]


def ranks_with(argument):
    """Pids of the ranks that have `argument` on their command line; mpirun itself does not count."""
    pids = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if argument.encode() in words and os.path.basename(words[0]).decode() == os.path.basename(PROGRAM):
            pids.append(int(entry.name))
    return pids


def wait_for(condition, seconds):
    deadline = time.monotonic() + seconds
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.02)
    return condition()


class RanksEnd(unittest.TestCase):
    def kill(self, choose):
        with tempfile.TemporaryDirectory() as folder:
            run = subprocess.Popen(
                [*MPIRUN, PROGRAM, folder, "1000000", "4"],
                start_new_session=True,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            try:
                self.assertTrue(wait_for((Path(folder) / "fields.xdmf").exists, 30))
                os.kill(choose(run.pid, ranks_with(folder)), signal.SIGKILL)
                self.assertTrue(wait_for(lambda: not ranks_with(folder), 4), "ranks were left behind")
                self.assertNotEqual(run.wait(5), 0)
            finally:
                for pid in ranks_with(folder):
                    os.kill(pid, signal.SIGKILL)
                if run.poll() is None:
                    os.killpg(run.pid, signal.SIGKILL)
                    run.wait()

    def test_when_mpirun_is_killed(self):
        self.kill(lambda mpirun, ranks: mpirun)

    def test_when_a_rank_is_killed(self):
        self.kill(lambda mpirun, ranks: max(ranks))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
