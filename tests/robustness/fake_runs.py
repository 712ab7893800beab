"""Whole runs with the fakes as components: everything of the product but the solvers."""

import json
import os
import re
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests/integration"))

from copepod_session import Session  # noqa: E402  (the path above must be set first)

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))

_CASE = """
case: fakes
fluid: {solver: vacuum}
step_s: 1.0e-9
bodies:
  - {name: one, shape: sphere, radius_m: 4.0e-6, mass_kg: 5.0e-13, position_m: [0, 0, 0], velocity_m_per_s: [0.1, 0, 0]}
  - {name: two, shape: sphere, radius_m: 4.0e-6, mass_kg: 5.0e-13, position_m: [0, 0, 1.0e-4]}
  - {name: three, shape: sphere, radius_m: 4.0e-6, mass_kg: 5.0e-13, position_m: [0, 0, 2.0e-4]}
coupling: {scheme: serial_explicit, load_averaging: none}
"""


class FakeRun:
    """One `copepod run` of the case above, in a folder of its own."""

    def __init__(self, folder, steps):
        self.folder = Path(folder).resolve()
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "case.yaml").write_text(
            _CASE + f"run: {{steps: {steps}}}\noutput: {{trajectory: {{every_steps: {steps}}}}}\n"
        )
        self.start = time.monotonic()
        self.session = Session(
            ["run", "case.yaml", "--out", "out", "--fluid", PROGRAMS / "fake_fluid", "--body", PROGRAMS / "fake_body"],
            self.folder,
            PROGRAMS,
        )

    def end(self, timeout_s):
        """(exit code, wall seconds, digest or the last line of what went wrong)."""
        code = self.session.end(timeout_s)
        wall_s = time.monotonic() - self.start
        if code != 0:
            return code, wall_s, self.session.last_line
        return code, wall_s, json.loads((self.folder / "out/summary.json").read_text())["digest"]

    def step(self):
        """The newest step reported by the run."""
        for line in reversed(list(self.session.stderr)):
            if told := re.search(r"step (\d+) of", line):
                return int(told[1])
        return 0
