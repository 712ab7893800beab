#!/usr/bin/python3
"""Palabos as the fluid, Yade as the bodies: both build against the installed kit, conform, and run together.

    foreign_engines_test.py BUILD      folder of a build that is complete

Each part is skipped where Debian's packages libplb-dev or yade are not installed.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(sys.argv.pop()).resolve()
COPEPOD = ROOT / "deploy/copepod"
CASES = ROOT / "configs/examples/foreign"
YADE = f"/usr/bin/python3 {ROOT}/examples/yade_body/yade_body.py"
os.environ["COPEPOD_BUILT_PROGRAMS"] = str(BUILD / "bin")
sys.path.insert(0, str(ROOT / "tests/faults"))
import hurt_run  # noqa: E402

HAS_PALABOS = Path("/usr/include/palabos/palabos3D.h").exists()
HAS_YADE = Path("/usr/lib/x86_64-linux-gnu/yade-double/py").is_dir()


def command(*words, code=0):
    """Runs it and returns all that it printed."""
    variables = {**os.environ, "COPEPOD_BIN_DIR": str(BUILD / "bin"), "OMPI_ALLOW_RUN_AS_ROOT": "1"}
    ended = subprocess.run(
        [*map(str, words)],
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env={**variables, "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"},
        text=True,
        timeout=400,
        check=False,
    )
    assert ended.returncode == code, ended.stdout
    return ended.stdout


class ForeignEngines(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        if not HAS_PALABOS:
            return
        command("cmake", "--install", BUILD, "--component", "kit", "--prefix", cls.folder / "kit")
        prefix = f"-DCMAKE_PREFIX_PATH={cls.folder / 'kit'}"
        command("cmake", "-S", ROOT / "examples/palabos_fluid", "-B", cls.folder / "palabos", prefix)
        command("cmake", "--build", cls.folder / "palabos")
        cls.palabos = cls.folder / "palabos/palabos_fluid"

    def run_case(self, name, *options):
        out = self.folder / "out"
        command("rm", "-rf", out)
        command(COPEPOD, "run", CASES / f"{name}.yaml", "--out", out, *options)
        return json.loads((out / "summary.json").read_text())

    @unittest.skipUnless(HAS_PALABOS, "Debian's package libplb-dev is not installed")
    def test_palabos_conforms_on_two_ranks(self):
        ranks = ("mpirun", "-n", "2", "--oversubscribe", self.palabos)
        self.assertIn("\nconformant: ", command(COPEPOD, "conformance", "--role", "fluid", "--quick", "--", *ranks))

    @unittest.skipUnless(HAS_PALABOS, "Debian's package libplb-dev is not installed")
    def test_digest_of_palabos_does_not_depend_on_the_number_of_ranks(self):
        digests = {
            self.run_case(
                "settling_sphere_palabos", "--fluid", self.palabos, "--ranks", ranks, "--set", "run.steps=40"
            )["digest"]
            for ranks in (1, 2, 3)
        }
        self.assertEqual(len(digests), 1)

    @unittest.skipUnless(HAS_PALABOS, "Debian's package libplb-dev is not installed")
    def test_what_palabos_lacks_is_refused_by_name_before_the_first_step(self):
        case = CASES / "settling_sphere_palabos.yaml"
        lacking = ("--fluid", self.palabos, "--set", "fluid.symmetry_planes=[x]")
        output = command(COPEPOD, "run", case, "--out", self.folder / "refused", *lacking, code=2)
        self.assertIn("Palabos", output)
        self.assertIn("symmetry_planes", output)

    @unittest.skipUnless(HAS_YADE, "Debian's package yade is not installed")
    def test_yade_conforms(self):
        groups = [
            word for group in ("checkpoints", "exactly once", "physics", "processes") for word in ("--only", group)
        ]
        output = command(COPEPOD, "conformance", "--role", "body", "--quick", *groups, "--", *YADE.split())
        self.assertIn("\nconformant: ", output)

    @unittest.skipUnless(HAS_PALABOS and HAS_YADE, "Debian's packages libplb-dev and yade are not both installed")
    def test_spheres_that_collide_in_palabos_come_to_rest_on_the_floor_of_yade(self):
        self.run_case("colliding_spheres_palabos_yade", "--fluid", self.palabos, "--body", YADE)
        *_, last = (self.folder / "out/trajectory.csv").read_text().splitlines()
        self.assertAlmostEqual(float(last.split(",")[5]), 7.5e-3, delta=2e-7)

    @unittest.skipUnless(HAS_PALABOS and HAS_YADE, "Debian's packages libplb-dev and yade are not both installed")
    def test_what_is_killed_or_frozen_is_named_and_the_run_resumes_with_the_same_digest(self):
        options = ("--fluid", self.palabos, "--ranks", "2", "--body", YADE, "--set", "run.steps=60")
        options += ("--set", "output.checkpoint.every_steps=20")
        whole = self.run_case("colliding_spheres_palabos_yade", *options)
        kill, freeze = (signal.SIGKILL, "killed by signal 9"), (signal.SIGSTOP, "frozen")
        for victim, name, (number, words) in (
            ("fluid 0", "fluid service on host .*, rank 0", kill),
            ("fluid 1", "fluid service on host .*, rank 1", freeze),
            ("body", "body service on host", kill),
            ("body", "body service on host", freeze),
        ):
            with self.subTest(victim=victim, fault=words), tempfile.TemporaryDirectory() as folder:
                folder = Path(folder).resolve()
                self.hurt(folder, options, victim, number, f"{name}.*{words}")
                resumed = self.run_in(folder, *options, "--resume")
                self.assertEqual(resumed.end(hurt_run.LONGEST_S), 0, resumed.last_line)
                self.assertEqual(hurt_run.digest(folder), whole["digest"])

    @unittest.skipUnless(HAS_PALABOS and HAS_YADE, "Debian's packages libplb-dev and yade are not both installed")
    def test_work_without_progress_for_longer_than_its_deadline_is_a_hang(self):
        options = ("--fluid", self.palabos, "--body", YADE, "--set", "services.progress_deadline_s=0.004")
        with tempfile.TemporaryDirectory() as folder:
            run = self.run_in(Path(folder).resolve(), *options)
            self.assertEqual(run.end(hurt_run.LONGEST_S), 69, run.last_line)
            self.assertRegex(run.last_line, "(fluid|body) service on host .* hangs")
            self.assertEqual(run.final_leftovers(), [])

    def run_in(self, folder, *options):
        case = CASES / "colliding_spheres_palabos_yade.yaml"
        return hurt_run.HurtRun(folder, "--out", "out", *options, case=case)

    def hurt(self, folder, options, victim, number, words):
        """Sends a signal once there is a checkpoint; the run has to end soon, with the words, and clean up."""
        run = self.run_in(folder, *options)
        self.assertTrue(hurt_run.wait_for(lambda: hurt_run.has_checkpoint(folder), hurt_run.LONGEST_S))
        os.kill(run.pid(victim), number)
        self.assertEqual(run.end(hurt_run.PROMPT_S), 69, run.last_line)
        self.assertRegex(run.last_line, words)
        self.assertEqual(run.final_leftovers(), [])


if __name__ == "__main__":
    unittest.main()
