"""Every fluid runs with every body component on the same case, swapped by one option each."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

from combinations import BODIES, CASE, FLUIDS, ROOT, run

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
ENVIRONMENT = {**os.environ, "COPEPOD_BIN_DIR": str(PROGRAMS)}
SHORT = (
    "--set",
    "run.steps=300",
    "--set",
    "output.fields.mean_over_steps=[0, 0]",
    "--set",
    "output.trajectory.every_steps=300",
)


def last_rows(directory):
    """z [m] of the three beads in the last sample."""
    header, *rows = (directory / "trajectory.csv").read_text().splitlines()
    column = header.split(",").index("z_m")
    return [float(row.split(",")[column]) for row in rows[-3:]]


class Combinations(unittest.TestCase):
    bodies = [
        body for body in BODIES if body in ("own", "Python") or (PROGRAMS / f"{body.lower()}_body_service").exists()
    ]

    def test_every_fluid_moves_every_kind_of_bodies_alike(self):
        with tempfile.TemporaryDirectory() as folder:
            moved_by = {}
            for fluid in FLUIDS:
                ends = {}
                for body in self.bodies:
                    run(folder, fluid, body, *SHORT, environment=ENVIRONMENT)
                    ends[body] = last_rows(Path(folder) / f"{fluid}_{body}")
                moved = [abs(z - start) for z, start in zip(ends["own"], (32e-6, 48e-6, 64e-6))]
                self.assertGreater(max(moved), 1e-8, fluid)
                for body in self.bodies:
                    # Half a step's way of the first-order integrators in 300 steps from rest: h v/2 < 1/300 of the way.
                    for ours, theirs in zip(ends["own"], ends[body]):
                        self.assertLess(abs(ours - theirs), max(moved) / 100, f"{fluid} with {body}")
                moved_by[fluid] = ends["own"]
            self.assertEqual(len({tuple(ends) for ends in moved_by.values()}), len(FLUIDS), "two fluids are the same")

    def test_a_component_can_be_named_in_the_line_of_the_solver(self):
        with tempfile.TemporaryDirectory() as folder:
            command = FLUIDS["Python"][1]
            case = Path(folder) / "case.yaml"
            case.write_text(CASE.read_text().replace("solver: lattice_boltzmann", f'solver: {{command: "{command}"}}'))
            done = subprocess.run(
                [ROOT / "deploy/copepod", "run", case, "--out", "out", *SHORT],
                cwd=folder,
                env=ENVIRONMENT,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            run(folder, "Python", "own", *SHORT, environment=ENVIRONMENT)
            self.assertEqual(last_rows(Path(folder) / "out"), last_rows(Path(folder) / "Python_own"))


if __name__ == "__main__":
    unittest.main()
