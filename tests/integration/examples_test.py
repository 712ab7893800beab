"""The swimmers of configs/examples in Stokes flow move as their comments promise, one of them as its page shows."""

import json
import os
import re
import unittest
from pathlib import Path

from copepod_session import ROOT, CommandTest

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
SPEEDS = {  # in cells per step, along the own axis
    "asymmetric_swimmer": "6.42e-6",
    "beside_a_wall": "6.38e-6",
    "cargo": "2.36e-6",
    "flagellum": "1.7e-6",
    "four_bead_chain": "9.85e-6",
    "pair_in_phase": "5.65e-6",
    "prescribed_stroke": "3.81e-6",
}


class Examples(CommandTest):
    programs = PROGRAMS

    def kinematics(self, case):
        """Of the first swimmer in its last cycle, and the printed table."""
        session = self.start("run", case, "--out", "out")
        self.assert_ends(session, 0, timeout_s=100)
        summary = json.loads((self.folder / "out/summary.json").read_text())
        (self.folder / "out").rename(self.folder / case.stem)
        return (summary["swimmers"] or summary["groups"])[0]["kinematics"], "".join(session.stdout)

    def test_speeds(self):
        for name, speed in SPEEDS.items():
            case = ROOT / f"configs/examples/{name}.yaml"
            self.assertIn(speed, case.read_text())
            with self.subTest(name):
                digits = len(speed.partition("e")[0].partition(".")[2])
                found = f"{self.kinematics(case)[0]['u_along_cells_per_step']:.{digits}e}"
                self.assertEqual(float(found), float(speed))

    def test_first_own_swimmer_is_the_triangular_rotator_and_prints_what_the_page_shows(self):
        page = (ROOT / "docs/your_first_own_swimmer.md").read_text()
        text = re.search(r"^```yaml\n(case: .*?)^```", page, re.DOTALL | re.MULTILINE)[1]
        example = (ROOT / "configs/examples/triangular_rotator.yaml").read_text()
        self.assertEqual(example.partition("\nfluid:")[2], text.partition("\nfluid:")[2])
        case = self.folder / "my_swimmer.yaml"
        case.write_text(text)
        kinematics, table = self.kinematics(case)
        self.assertEqual(round(1e3 * kinematics["rotation_rad"][1]), 46)
        shown = re.search(r"^```\n  rotator .*?^```", page, re.DOTALL | re.MULTILINE)[0].splitlines()[1:-1]
        printed = [" ".join(line.split()) for line in table.splitlines()]
        for line in shown:
            if "…" not in line and "change in last cycle" not in line:  # the change is rounding
                self.assertIn(" ".join(line.split()), printed)

    def test_swarm_is_placed(self):
        session = self.start("run", ROOT / "configs/examples/swarm.yaml", "--set", "run.steps=20", "--out", "out")
        self.assert_ends(session, 0, timeout_s=100)
        self.assertEqual((self.folder / "out/case.yaml").read_text().count("center_m"), 16)
        names = {row.split(",")[2] for row in (self.folder / "out/trajectory.csv").read_text().splitlines()[1:]}
        self.assertEqual(len(names), 48)
        self.assertIn("swimmer_16.B2", names)


if __name__ == "__main__":
    unittest.main()
