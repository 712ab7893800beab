"""trajectory.npy beside trajectory.csv: the same numbers, while a run writes, once it was killed, on a full disk."""

import importlib.util
import os
import shlex
import shutil
import signal
import subprocess
import sys
import unittest
from unittest import mock

import numpy as np

from copepod_session import COMMAND, PROGRAMS, ROOT, WholeRunTest, wait_until
from copepod_report.report import page_of
from copepod_report.run_record import RunRecord
from copepod_report.swarm import Swarm
from copepod_report.trajectory import COLUMNS, GrowingTrajectory, Trajectory, trajectory_in
from copepod_run.plan import drawn_case
from copepod_watch.follower import TrajectoryFollower

VACUUM = ROOT / "configs/quick/vacuum.yaml"
NPY = "output.trajectory.format=npy"
SWARM = """
case: swarm
fluid: {solver: vacuum, cell_size_m: 1.0e-6}
step_s: 7.548309999899218e-10
swarm:
  template:
    name: swimmer
    beads: [&bead {radius_m: 4.0e-6}, *bead, *bead]
    bead_mass_kg: 5.44e-13
    rest_gap_m: [8.0e-6, 8.0e-6]
    spring: {stiffness_N_per_m: 16.3, damping_N_s_per_m: 1.57e-7}
    stroke: {amplitude_N: 2.0e-5, period_steps: 400, phase_lag_steps: 100, cycles: 5}
  count: 40
  region_m: {x: [0, 4.0e-4], y: [0, 4.0e-4], z: [0, 4.0e-4]}
  minimal_gap_m: 6.0e-6
  phases: random
run: {steps: 2000}
output: {trajectory: {every_steps: 20}, bodies: {every_steps: 0}}
"""


def content_of(path):
    """Every field, as any program sees it."""
    samples = np.load(path)
    return {name: samples[name] for name in samples.dtype.names}


class TrajectoryTest(WholeRunTest):
    def setUp(self):
        super().setUp()
        os.environ["COPEPOD_BIN_DIR"] = str(PROGRAMS)  # of the coupler that resolves cases

    def run_of_swarm(self, *settings):
        case = self.folder / "swarm.yaml"
        case.write_text(SWARM)
        return self.run_of(case, *settings)

    def test_many_bodies_have_datasets_with_the_numbers_of_the_table(self):
        compact, text = self.run_of_swarm(), self.run_of_swarm("output.trajectory.format=csv")
        self.assertEqual((trajectory_in(compact).name, trajectory_in(text).name), ("trajectory.npy", "trajectory.csv"))
        for directory, form in ((compact, "npy"), (text, "csv")):
            self.assertEqual(drawn_case(directory / "case.yaml")["output"]["trajectory"]["format"], form)
        one, other = Trajectory(compact), Trajectory(text)
        self.assertEqual(one.bodies, other.bodies)
        self.assertEqual((one.bodies[0], len(one.bodies), len(one)), ("swimmer_01.B2", 120, 101))
        np.testing.assert_array_equal(one.columns(), other.columns())
        with mock.patch("copepod_report.trajectory._MOST_VALUES", 0):  # as in a table too large to be read whole
            place_m = Trajectory(compact).of(one.bodies[5])["position_m"]
        np.testing.assert_array_equal(place_m, other.all_of("position_m")[:, 5])
        samples = np.load(compact / "trajectory.npy", mmap_mode="r")
        self.assertEqual(samples["orientation_wxyz"].shape, (101, 120, 4))
        np.testing.assert_array_equal(samples["step"], other.steps)
        np.testing.assert_array_equal(samples["time_s"], other.time_s)
        np.testing.assert_array_equal(samples["drive_N"][7:9, 5], other.of(other.bodies[5])["driving_N"][7:9])
        np.testing.assert_array_equal(one.some_of("force_N", np.array([3, 5])), other.all_of("force_N")[[3, 5]])

    def test_report_of_a_swarm_is_that_of_its_table(self):
        compact, text = self.run_of_swarm(), self.run_of_swarm("output.trajectory.format=csv")
        one, other = (Swarm(RunRecord(directory, drawn_case)) for directory in (compact, text))
        for name in ("centroids_m", "axes", "power_W", "along", "power_by_cycle_W"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name), name)
            self.assertTrue(np.any(getattr(one, name)), name)
        for values, expected in (
            (one.polar_order(), other.polar_order()),
            (one.nematic_order(), other.nematic_order()),
            (one.mean_square_displacement(), other.mean_square_displacement()),
        ):
            np.testing.assert_array_equal(values, expected)
        names = [name for name, _, _ in one.figures()]
        self.assertEqual(names, ["swarm", "speeds", "power", "orientations", "pairs", "spreading"])
        pages = [page_of(directory, drawn_case) for directory in (compact, text)]
        motions = [page.partition('"motion"')[2].partition("}")[0] for page in pages]
        self.assertTrue(motions[0])
        self.assertEqual(*motions)

    def test_killed_run_leaves_a_readable_file_and_resumes_to_the_same_one(self):
        settings = ["run.steps=400000", "output.trajectory.every_steps=20", "output.bodies.every_steps=0", NPY]
        words = [word for setting in settings for word in ("--set", setting)]
        words += ["--set", "output.checkpoint.every_steps=3000"]
        session = self.start("run", VACUUM, "--out", "out", *words)
        path = self.folder / "out/trajectory.npy"
        growing, follower = GrowingTrajectory(path.parent), TrajectoryFollower(path.parent)
        seen = []

        def has_grown():
            seen.append(sum(1 for _ in growing.look()))
            follower.update()
            return len([count for count in seen if count]) > 2 and list(path.parent.glob("checkpoints/*/manifest.json"))

        wait_until(has_grown, "samples that come in turn")
        session.kill(signal.SIGKILL, "coupler")
        self.assert_ends(session, 69)
        left = content_of(path)
        count = len(left["step"])
        self.assertGreaterEqual(count, sum(seen))
        self.assertEqual(left["step"].tolist(), list(range(0, 20 * count, 20)))
        self.assertEqual(follower.samples().steps[0], 0)
        steps = 20 * count + 2000
        self.finish("run", VACUUM, "--out", "out", *words, "--set", f"run.steps={steps}", "--resume")
        self.finish("run", VACUUM, "--out", "whole", *words, "--set", f"run.steps={steps}")
        resumed, whole = content_of(path), content_of(self.folder / "whole/trajectory.npy")
        self.assertEqual(resumed.keys(), whole.keys())
        for name, values in resumed.items():
            np.testing.assert_array_equal(values, whole[name], name)
            np.testing.assert_array_equal(left[name], values[: len(left[name])], name)
        for _ in growing.look():
            pass
        self.assertEqual(growing.count, steps // 20 + 1)

    def test_a_file_that_a_resumed_run_cuts_is_read_anew(self):
        directory = self.run_of(VACUUM, "run.steps=800", "output.trajectory.every_steps=10", NPY)
        path = directory / "trajectory.npy"
        whole, bytes_of_sample = path.read_bytes(), np.load(path).dtype.itemsize
        growing = GrowingTrajectory(directory)
        self.assertEqual(len(list(growing.look())), 81)
        path.write_bytes(whole[: 1024 + 50 * bytes_of_sample + 3])  # the head still announces all of them
        self.assertEqual([step for step, _ in growing.look()], list(range(0, 500, 10)))
        self.assertEqual(len(Trajectory(directory)), 50)
        path.write_bytes(whole)
        steps, times_s = zip(*((step, values()[0, COLUMNS.index("time_s")]) for step, values in growing.look()))
        self.assertEqual(steps, tuple(range(500, 801, 10)))
        np.testing.assert_array_equal(times_s, np.load(path)["time_s"][50:])

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("unshare"), "mounts a file system")
    def test_full_disk_is_named(self):
        words = [f"--set={word}" for word in (NPY, "output.trajectory.every_steps=1", "output.bodies.every_steps=0")]
        mount = f"mount -t tmpfs -o size=3m none {self.folder}"
        run = [COMMAND, "run", VACUUM, "--out", self.folder / "out", *words]
        answer = subprocess.run(
            ["unshare", "--mount", "sh", "-c", f"{mount} && {shlex.join(map(str, run))}"],
            env={**os.environ, "COPEPOD_BIN_DIR": str(PROGRAMS)},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
        )
        self.assertEqual(answer.returncode, 73, answer.stderr)
        self.assertIn("trajectory.npy cannot be written (No space left on device)", answer.stderr.splitlines()[-1])

    @unittest.skipIf(importlib.util.find_spec("pandas") is None, "pandas is not installed")
    def test_python_package_reads_either_form(self):
        sys.path.insert(0, str(ROOT / "python"))  # before the generated modules, which are in a package of this name
        import copepod

        runs = [copepod.load(self.run_of(VACUUM, f"output.trajectory.format={form}")) for form in ("npy", "csv")]
        self.assertTrue(runs[0].trajectory.equals(runs[1].trajectory))
        samples = [list(copepod.follow(run)) for run in runs]
        self.assertEqual([sample.step for sample in samples[0]], [sample.step for sample in samples[1]])
        self.assertTrue(all(one.bodies.equals(other.bodies) for one, other in zip(*samples)))


if __name__ == "__main__":
    unittest.main()
