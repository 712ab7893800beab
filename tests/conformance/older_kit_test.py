#!/usr/bin/python3
"""The examples of earlier releases work with the kit of this one, changed as docs/moving_to_a_newer_kit.md has it.

    older_kit_test.py BUILD      folder of a build that is complete
"""

import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BUILD = Path(sys.argv.pop()).resolve()
CASE = ["--set", "fluid.solver=external", "--set", "fluid.density_kg_per_m3=1360", "--set", "run.steps=200"]
CASE += ["--set", "fluid.kinematic_viscosity_m2_per_s=7.36e-5"]


class ComponentsOf10(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name).resolve()
        run(["cmake", "--install", BUILD, "--component", "kit", "--prefix", cls.folder / "kit"])
        with tarfile.open(HERE / "components_of_1.0.tar.gz") as archive:
            archive.extractall(cls.folder)
        cls.sources = cls.folder / "components_of_1.0"
        page = (ROOT / "docs/moving_to_a_newer_kit.md").read_text()
        section = page.split("\n## From 1.0 ")[1].split("\n## ")[0]
        for change in re.findall(r"```diff\n(.*?)```", section, re.DOTALL):
            run(["git", "apply", "--unidiff-zero", "-"], cwd=cls.sources, input=change)

    def digest(self, name, fluid):
        """Of a run of a few steps with the changed bodies and this fluid."""
        case = [ROOT / "deploy/copepod", "run", ROOT / "configs/quick/vacuum.yaml", *CASE, "--out", self.folder / name]
        body = f"/usr/bin/python3 {self.sources}/point_masses.py"
        path = {"PYTHONPATH": str(self.folder / "kit/share/copepod/python"), "COPEPOD_BIN_DIR": str(BUILD / "bin")}
        run([*case, "--fluid", fluid, "--body", body], env={**os.environ, **path})
        return json.loads((self.folder / name / "summary.json").read_text())["digest"]

    def test_components_in_python_run(self):
        fluid = f"/usr/bin/python3 {self.sources}/stokes_drag_fluid.py"
        self.assertEqual(self.digest("first", fluid), self.digest("second", fluid))

    def test_a_component_in_cpp_is_built_and_runs(self):
        run(["cmake", "-S", self.sources, "-B", self.folder / "build", f"-DCMAKE_PREFIX_PATH={self.folder / 'kit'}"])
        run(["cmake", "--build", self.folder / "build"])
        self.assertEqual(len(self.digest("cpp", self.folder / "build/external_fluid")), 16)


def run(command, **options):
    """A command that must succeed."""
    ended = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=220, **options)
    if ended.returncode != 0:
        raise AssertionError(f"{command}: {ended.stdout}{ended.stderr}")


if __name__ == "__main__":
    unittest.main()
