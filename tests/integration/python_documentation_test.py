"""The Python in docs/python.md, docs/steering.md and the notebooks in docs/notebooks run as they stand."""

import importlib.util
import os
import re
import subprocess
import sys
import unittest
import unittest.mock
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
        for name in ("configs", "examples"):
            (self.folder / name).symlink_to(ROOT / name)
        path = os.pathsep.join([str(ROOT / "python"), str(ROOT / "deploy")])
        self.environment = {**os.environ, "PYTHONPATH": path, "COPEPOD_BIN_DIR": str(PROGRAMS), "MPLBACKEND": "Agg"}

    def output_of(self, *command):
        done = subprocess.run(
            [sys.executable, *command], cwd=self.folder, env=self.environment, capture_output=True, text=True
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_all_public_names_are_exported(self):
        names = "public = [n for n, v in vars(copepod).items() if n[0] != '_' and not inspect.ismodule(v)]"
        self.output_of("-c", f"import copepod, inspect; {names}; assert sorted(public) == sorted(copepod.__all__)")

    def test_page_about_python(self):
        page = (ROOT / "docs/python.md").read_text()
        blocks = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
        said = self.output_of("-c", "\n".join(blocks))
        self.assertIn("step [s]", said)
        self.assertTrue((self.folder / "runs/slow_rotator/summary.json").exists())
        self.assertEqual(len(list((self.folder / "runs/lags").glob("lags_*/summary.json"))), 25)
        self.assertTrue((self.folder / "lags.pdf").exists())

    def test_page_about_steering(self):
        page = (ROOT / "docs/steering.md").read_text()
        simulation, services, environment = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
        last = float(self.output_of("-c", simulation).split()[-1])
        self.assertAlmostEqual(last, -8e-6 / 3 + 0.1396e-6, delta=1e-9)  # the middle at the start is at −8/3 µm
        forces = re.findall(r"-?\d\S*e\S*\d", self.output_of("-c", services))
        self.assertGreater(max(abs(float(force)) for force in forces), 0)
        rewards = self.output_of("-c", environment.replace("rods.close()", "print(reward)"))
        self.assertNotEqual(float(rewards), 0.0)

    def test_notebooks_run_and_show_their_figures(self):
        if importlib.util.find_spec("nbclient") is None or importlib.util.find_spec("ipykernel") is None:
            self.skipTest("python3-nbclient and python3-ipykernel are not installed (deploy/copepod setup --ci)")
        import nbclient
        import nbformat

        place = self.folder / "docs/notebooks"
        place.mkdir(parents=True)
        del self.environment["MPLBACKEND"]
        for path in sorted((ROOT / "docs/notebooks").glob("*.ipynb")):
            notebook = nbformat.read(path, 4)
            self.assertEqual([cell for cell in notebook.cells if cell.get("outputs")], [], "commit it without outputs")
            with self.subTest(path.name), unittest.mock.patch.dict(os.environ, self.environment):
                nbclient.NotebookClient(notebook, resources={"metadata": {"path": str(place)}}).execute()
                outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
                self.assertTrue([output for output in outputs if "image/png" in output.get("data", {})])


if __name__ == "__main__":
    unittest.main()
