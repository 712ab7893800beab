#!/usr/bin/python3
"""Reads fields.h5 and fields.xdmf as a user would: with h5py, with VTK's XDMF reader, and after a kill -9.

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


def start(folder, snapshots, scale):
    return subprocess.Popen(
        [*MPIRUN, PROGRAM, folder, str(snapshots), str(scale)],
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


def vtk_xdmf_reader():
    """VTK's or ParaView's XDMF 2 reader, or None."""
    for module in ("vtkmodules.vtkIOXdmf2", "paraview.modules.vtkIOXdmf2"):
        try:
            return __import__(module, fromlist=["vtkXdmfReader"]).vtkXdmfReader()
        except ImportError:
            continue
    return None


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
        items = [item for item in xml.parse(self.path / "fields.xdmf").iter("DataItem") if item.get("Format") == "HDF"]
        self.assertEqual(len(items), 9)
        for item in items:
            name, dataset = item.text.split(":")
            with h5py.File(self.path / name) as file:
                self.assertEqual(file[dataset].shape, tuple(map(int, item.get("Dimensions").split())))
                self.assertEqual(str(file[dataset].dtype.itemsize), item.get("Precision"))

    def test_vtk_opens_the_xdmf(self):
        reader = vtk_xdmf_reader()
        if reader is None:
            self.skipTest("no VTK with an XDMF reader is installed")
        reader.SetFileName(str(self.path / "fields.xdmf"))
        reader.Update()
        blocks = reader.GetOutputDataObject(0)
        snapshot = blocks.GetBlock(0)
        while snapshot.IsA("vtkMultiBlockDataSet"):
            snapshot = snapshot.GetBlock(0)
        self.assertEqual(snapshot.GetNumberOfCells(), 8 * 6 * 5)
        density = snapshot.GetCellData().GetArray("density_kg_per_m3")
        self.assertEqual([density.GetValue(i) for i in range(240)], list(expected_fields()[0].ravel()))
        self.assertEqual(snapshot.GetCellData().GetArray("velocity_m_per_s").GetNumberOfComponents(), 3)
        np.testing.assert_allclose(snapshot.GetBounds(), (0, 8e-6, 0, 6e-6, 0, 5e-6))

    def test_snapshots_written_before_a_kill_stay_readable(self):
        for seconds in (0.0, 0.01, 0.02, 0.03, 0.05):
            with tempfile.TemporaryDirectory() as folder, self.subTest(seconds=seconds):
                run = start(folder, 100000, 4)
                try:
                    deadline = time.monotonic() + 30
                    while not (Path(folder) / "fields.xdmf").exists() and time.monotonic() < deadline:
                        time.sleep(0.005)
                    time.sleep(seconds)
                finally:
                    os.killpg(run.pid, signal.SIGKILL)
                    run.wait()
                with h5py.File(Path(folder) / "fields.h5") as file:
                    steps = [name for name in file if name.startswith("step_")]
                    self.assertTrue(steps)
                    for name in steps:
                        self.assertEqual(file[name]["density_kg_per_m3"][0, 0, 0], 1000.0)
                        self.assertEqual(file[name]["density_kg_per_m3"][19, 23, 31], 1019.0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
