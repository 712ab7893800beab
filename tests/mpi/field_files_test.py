#!/usr/bin/python3
"""Reads fields.h5 and fields.xdmf as a user would: with h5py, and after a kill -9.

    field_files_test.py PROGRAM MPIRUN…      PROGRAM is write_fields
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import xml.etree.ElementTree as xml
from pathlib import Path

import h5py
import numpy as np

PROGRAM, MPIRUN = sys.argv[1], sys.argv[2:]


def start(folder, snapshots, scale, *selected):
    return subprocess.Popen(
        [*MPIRUN, PROGRAM, folder, str(snapshots), str(scale), *selected],
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def expected_fields():
    """density, velocity, body of the whole 8 × 6 × 5 cells, arrays (z, y, x)."""
    z, y, x = np.meshgrid(np.arange(5), np.arange(6), np.arange(8), indexing="ij")
    computed_x, computed_y = np.minimum(x, 7 - x), np.minimum(y, 5 - y)
    velocity = np.stack(
        [np.where(x < 4, 1, -1) * (computed_x + 0.5), np.where(y < 3, 1, -1) * (computed_y + 0.5), z + 0.5], axis=-1
    )
    return 1000.0 + 10000 * computed_x + 100 * computed_y + z, velocity, computed_x % 2


class FieldFiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        assert start(cls.folder.name, 2, 1).wait(60) == 0
        cls.path = Path(cls.folder.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_h5py_finds_the_whole_domain(self):
        density, velocity, body = expected_fields()
        with h5py.File(self.path / "fields.h5") as file:
            self.assertEqual(set(file), {"step_000001000", "step_000002000", "mean"})
            for group in file.values():
                np.testing.assert_array_equal(group["density_kg_per_m3"], density)
                np.testing.assert_array_equal(group["velocity_m_per_s"], velocity)
                np.testing.assert_array_equal(group["body"], body)
            self.assertEqual(file["step_000002000"].attrs["step"], 2000)
            self.assertEqual(file["step_000002000"].attrs["time_s"], 2000 * 2e-10)
            self.assertEqual(file["mean"].attrs["samples"], 2)

    def test_every_item_of_the_xdmf_is_in_the_hdf5_file_with_its_shape(self):
        self.assertEqual(self.check_items(self.path / "fields.xdmf"), 6)
        self.assertEqual(self.check_items(self.path / "fields_mean.xdmf"), 3)

    def check_items(self, path):
        """Number of datasets that the file names; each is there."""
        items = [item for item in xml.parse(path).iter("DataItem") if item.get("Format") == "HDF"]
        for item in items:
            name, dataset = item.text.split(":")
            with h5py.File(path.parent / name) as file:
                self.assertEqual(file[dataset].shape, tuple(map(int, item.get("Dimensions").split())))
                self.assertEqual(str(file[dataset].dtype.itemsize), item.get("Precision"))
        return len(items)

    def test_snapshots_have_times_and_the_mean_has_none(self):
        times = [float(time.get("Value")) for time in xml.parse(self.path / "fields.xdmf").iter("Time")]
        self.assertEqual(times, [1000 * 2e-10, 2000 * 2e-10])
        self.assertEqual(list(xml.parse(self.path / "fields_mean.xdmf").iter("Time")), [])

    def test_a_compressed_slice_holds_the_same_numbers_and_what_follows_from_them(self):
        density, velocity, body = expected_fields()
        part = (slice(None), slice(4, 5), slice(2, 7))
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(start(folder, 1, 1, "selected").wait(60), 0)
            self.assertEqual(self.check_items(Path(folder) / "fields.xdmf"), 4)
            self.assertEqual(
                {path.relative_to(folder).as_posix() for path in Path(folder).rglob("*")},
                {"fields.h5", "fields.xdmf", "fields_mean.xdmf"}
                | {"fields", "fields/step_000001000.h5", "fields/mean.h5"},
            )
            origin = next(xml.parse(Path(folder) / "fields.xdmf").iter("Geometry"))[0].text
            np.testing.assert_allclose(list(map(float, origin.split())), [0, 4e-6, 2e-6])
            with h5py.File(Path(folder) / "fields.h5") as file:
                for group in file.values():
                    self.assertEqual(set(group), {"pressure_Pa", "velocity_m_per_s", "vorticity_per_s", "body"})
                    self.assertEqual(group["velocity_m_per_s"].compression, "gzip")
                    np.testing.assert_array_equal(group["velocity_m_per_s"], velocity[part])
                    np.testing.assert_array_equal(group["body"], body[part])
                    speed = 1e-6 / 2e-10
                    np.testing.assert_allclose(
                        group["pressure_Pa"], (density[part] - 1000) * speed**2 / 3, rtol=1e-12
                    )
                    np.testing.assert_allclose(group["vorticity_per_s"], self.expected_vorticity()[part], atol=1e-6)

    @staticmethod
    def expected_vorticity():
        """Central differences of the whole velocity, zero in bodies; beyond the walls at rest lies −u."""
        _, velocity, body = expected_fields()
        around = np.pad(velocity, ((1, 1), (1, 1), (1, 1), (0, 0)), "edge")
        for face in np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1], np.s_[:, :, 0], np.s_[:, :, -1]:
            around[face] *= -1
        z, y, x = (np.gradient(around, 1e-6, axis=axis)[1:-1, 1:-1, 1:-1] for axis in range(3))
        vorticity = np.stack([y[..., 2] - z[..., 1], z[..., 0] - x[..., 2], x[..., 1] - y[..., 0]], axis=-1)
        return np.where(body[..., None] == 0, vorticity, 0)

    @unittest.skipUnless("1" in MPIRUN, "one rank writes what is counted")
    def test_kill_before_any_write_loses_no_snapshot(self):
        library = self.path / "kill_before_write.so"
        source = Path(__file__).with_name("kill_before_write.c")
        subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
        seen = set()
        # About 210 for each snapshot. When all were in one file, 965 to 968 lost those before.
        for write in (*range(0, 950, 61), *range(950, 1070, 3)):
            with tempfile.TemporaryDirectory() as folder, self.subTest(write=write):
                environment = {**os.environ, "LD_PRELOAD": str(library), "KILL_BEFORE_WRITE": str(write)}
                killed = subprocess.run([PROGRAM, folder, "8", "1"], env=environment, stdout=subprocess.DEVNULL)
                self.assertEqual(killed.returncode, -signal.SIGKILL)
                seen.add(self.check_what_is_left(Path(folder)))
        self.assertGreater(max(seen), 3)

    def check_what_is_left(self, folder):
        """Number of snapshots; fields.h5 has each one that ParaView is shown, and all can be read."""
        if not (folder / "fields.h5").exists():
            self.assertFalse((folder / "fields.xdmf").exists())
            return 0
        shown = xml.parse(folder / "fields.xdmf").iter("Grid") if (folder / "fields.xdmf").exists() else ()
        with h5py.File(folder / "fields.h5") as file:
            steps = {name for name in file if name.startswith("step_")}
            self.assertLessEqual({grid.get("Name") for grid in shown}, {"snapshots", *steps})
            for name in steps:
                self.assertEqual(file[name]["velocity_m_per_s"][0, 0, 0, 2], 0.5)
                self.assertEqual(file[name]["velocity_m_per_s"][-1, -1, -1, 2], file[name]["body"].shape[0] - 0.5)
            return len(steps)

    def test_snapshots_written_before_a_kill_stay_readable(self):
        for seconds, selected in ((0.0, ()), (0.02, ()), (0.05, ()), (0.01, ("selected",)), (0.04, ("selected",))):
            with tempfile.TemporaryDirectory() as folder, self.subTest(seconds=seconds, selected=selected):
                run = start(folder, 100000, 4, *selected)
                try:
                    deadline = time.monotonic() + 30
                    while not (Path(folder) / "fields.xdmf").exists() and time.monotonic() < deadline:
                        time.sleep(0.005)
                    time.sleep(seconds)
                finally:
                    os.killpg(run.pid, signal.SIGKILL)
                    run.wait()
                self.assertGreater(self.check_what_is_left(Path(folder)), 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
