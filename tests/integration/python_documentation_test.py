"""The Python in docs/python.md and the notebooks in docs/notebooks run as they stand."""

import importlib.util
import os
import re
import subprocess
import sys
import unittest
from pathlib import Path

from copepod_session import ROOT, CommandTest

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
PACKAGES = ("pandas", "xarray", "yaml")
if any(importlib.util.find_spec(name) is None for name in PACKAGES):
    raise unittest.SkipTest(f"{', '.join(PACKAGES)} are not installed (deploy/copepod setup --ci)")


class Documentation(CommandTest):
    programs = PROGRAMS

    def setUp(self):
        super().setUp()
        (self.folder / "configs").symlink_to(ROOT / "configs")
        path = os.pathsep.join([str(ROOT / "python"), str(ROOT / "deploy")])
        self.environment = {**os.environ, "PYTHONPATH": path, "COPEPOD_BIN_DIR": str(PROGRAMS), "MPLBACKEND": "Agg"}

    def output_of(self, *command):
        done = subprocess.run(
            [sys.executable, *command], cwd=self.folder, env=self.environment, capture_output=True, text=True
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_page_about_python(self):
        page = (ROOT / "docs/python.md").read_text()
        blocks = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
        said = self.output_of("-c", "\n".join(blocks))
        self.assertIn("step [s]", said)
        self.assertTrue((self.folder / "runs/slow_rotator/summary.json").exists())


if __name__ == "__main__":
    unittest.main()
