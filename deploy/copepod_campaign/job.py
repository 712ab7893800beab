"""One `copepod run` of a campaign, as a process of its own."""

import os
import signal
import subprocess
import sys

from copepod_campaign.entry import State
from copepod_run.checkout import ROOT
from copepod_run.progress import EventReader
from copepod_run.local_launcher import end_with_parent

RESTARTS = 3  # by itself, when a component is lost


class Job:
    """A running case: its process, and the last that it said about its progress."""

    def __init__(self, entry, ranks, environment):
        self.entry = entry
        self._resumed = entry.state is State.HALF_DONE
        entry.state = State.RUNNING
        parent = os.getpid()
        logs = entry.path.parent / "logs"
        self._log = open(logs / f"{entry.name}.log", "ab")
        self._process = subprocess.Popen(
            self._command(entry, ranks),
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=subprocess.PIPE,
            start_new_session=True,
            preexec_fn=lambda: end_with_parent(parent),
        )
        self.descriptor = self._process.stderr.fileno()
        self._reader = EventReader(on_other=lambda line: self._note(line.decode(errors="replace")))
        self._last_words = ""
        self.share = 0.0
        self.remaining_s = None
        self.weight_per_s = None
        self.ended = False

    def read(self):
        """Takes what the run has said; at its end, `ended` is set and the entry knows how it went."""
        received = os.read(self.descriptor, 65536)
        if not received:
            self._finish()
            return
        for event in self._reader.feed(received):
            if event["event"] == "progress":
                self._take(event)
            elif event["event"] == "notice":
                self._note(f"copepod: {event['text']}")

    def _note(self, line):
        """A line for people; the last one tells why a run failed."""
        self._last_words = line.removeprefix("copepod: ") or self._last_words
        self._log.write(f"{line}\n".encode())
        self._log.flush()

    def stop(self):
        """Lets the run write a checkpoint and end."""
        self._process.send_signal(signal.SIGTERM)

    def kill(self):
        self._process.kill()

    def _take(self, event):
        self.share = event["step"] / max(event["steps"], 1)
        if event["steps_per_s"]:
            self.remaining_s = event["remaining_s"]
            self.weight_per_s = event["steps_per_s"] * self.entry.weight / max(event["steps"], 1)

    def _finish(self):
        self.ended = True
        code = self._process.wait()
        self._process.stderr.close()
        self._log.close()
        if code == 0 and self.entry.summary:
            self.entry.state = State.DONE
            return
        self.entry.state = State.FAILED
        self.entry.exit_code = code if code > 0 else 128 - code
        self.entry.remark = self._last_words or f"ended with code {code} and said nothing"

    def _command(self, entry, ranks):
        words = [sys.executable, str(ROOT / "deploy/copepod_command/__main__.py"), "run", entry.file]
        for setting in entry.settings:
            words += ["--set", setting]
        if entry.plan.case.get("fluid", {}).get("solver") == "lattice_boltzmann":
            words += ["--ranks", str(ranks)]
        words += ["--out", str(entry.path), "--restarts", str(RESTARTS), "--progress", "json"]
        return words + (["--resume"] if self._resumed else [])
