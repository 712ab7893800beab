"""What ParaView opens: bodies.pvd, fields.xdmf and fields_mean.xdmf of whole runs, read without ParaView."""

import csv
import json
import re
import struct
import unittest
import xml.etree.ElementTree as xml
from pathlib import Path

import h5py
import numpy as np
from run_test import QUICK, RealRun

_TYPES = {"Float32": np.float32, "Int32": np.int32, "String": np.uint8}
_FIELDS = ("--set", "output.fields.every_steps=50", "--set", "output.fields.mean_over_steps=[0, 200]")
_CAPSULE = ("--set", "swimmers.0.beads.1={shape: capsule, radius_m: 4.0e-6, length_m: 4.0e-6, orientation: parallel}")


class PolyData:
    """A .vtp file: arrays by name, those of cells and points with a row for each."""

    def __init__(self, path: Path):
        text, _, data = path.read_bytes().partition(b"\n_")
        self.piece = xml.fromstring(text.partition(b"<AppendedData")[0] + b"</VTKFile>").find("PolyData/Piece")
        self.arrays = {}
        for array in self.piece.iter("DataArray"):
            offset = int(array.get("offset"))
            (size,) = struct.unpack_from("<Q", data, offset)
            values = np.frombuffer(
                data, _TYPES[array.get("type")], size // _TYPES[array.get("type")]().nbytes, offset + 8
            )
            self.arrays[array.get("Name")] = values.reshape(-1, 3) if array.get("NumberOfComponents") else values
        self.names = bytes(self.arrays["name"]).decode().split("\0")[:-1]

    def points_of(self, body):
        """Corners of the surface of a body, counted from 0."""
        ends = [0, *self.arrays["offsets"]]
        return self.arrays["points"][np.unique(self.arrays["connectivity"][ends[body] : ends[body + 1]])]


def frames_of(path: Path):
    """{time: file}"""
    sets = xml.parse(path).iter("DataSet")
    return {float(frame.get("timestep")): path.parent / frame.get("file") for frame in sets}


def times_of(path: Path):
    return [float(time.get("Value")) for time in xml.parse(path).iter("Time")]


class ParaView(RealRun):
    def run_quick(self, out, *arguments):
        session = self.start("run", QUICK, *_CAPSULE, "--out", out, *arguments)
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        return self.folder / out

    def test_finds_bodies_with_size_and_orientation_at_the_times_of_the_snapshots(self):
        run = self.run_quick(
            "out", *_FIELDS, "--set", "run.steps=200", "--set", "output.bodies.every_steps=50",
            "--set", "swimmers.0.axis=[1, 0, 0]", "--set", "fluid.domain_cells=[96, 24, 24]",
            "--set", "swimmers.0.center_m=[48e-6, 12e-6, 12e-6]", "--set", "fluid.symmetry_planes=[]",
        )  # fmt: skip
        case_step_s = json.loads((run / "summary.json").read_text())["step_s"]
        self.assertEqual(times_of(run / "fields.xdmf"), [step * case_step_s for step in (0, 50, 100, 150, 200)])
        self.assertEqual(times_of(run / "fields_mean.xdmf"), [])
        frames = frames_of(run / "bodies.pvd")
        self.assertEqual(list(frames), times_of(run / "fields.xdmf"))
        rows = [
            row for row in csv.DictReader((run / "trajectory.csv").read_text().splitlines()) if row["step"] == "200"
        ]
        bodies = PolyData(list(frames.values())[-1])
        self.assertEqual(bodies.names, [row["body"] for row in rows])
        self.assertEqual(bodies.arrays["body"].tolist(), [1, 2, 3])
        for number, (row, half_lengths) in enumerate(zip(rows, ([4e-6] * 3, [6e-6, 4e-6, 4e-6], [4e-6] * 3))):
            center, velocity = ([float(row[name.format(axis)]) for axis in "xyz"] for name in ("{}_m", "v{}_m_per_s"))
            points = bodies.points_of(number)
            np.testing.assert_allclose(np.ptp(points, axis=0) / 2, half_lengths, rtol=1e-5)
            np.testing.assert_allclose(points.max(axis=0) + points.min(axis=0), 2 * np.array(center), rtol=1e-5)
            np.testing.assert_allclose(bodies.arrays["velocity_m_per_s"][number], velocity, rtol=1e-6)

    def test_finds_every_snapshot_once_after_a_resumed_run_with_the_numbers_of_an_undisturbed_one(self):
        steps = lambda count: ("--set", f"run.steps={count}")  # noqa: E731
        checkpoints = ("--set", "output.checkpoint.every_steps=120")
        bodies = ("--set", "output.bodies.every_steps=40")
        undisturbed = self.run_quick("undisturbed", *_FIELDS, *steps(300), *bodies)
        self.run_quick("resumed", *_FIELDS, *steps(230), *checkpoints, *bodies)
        resumed = self.run_quick("resumed", *_FIELDS, *steps(300), *checkpoints, *bodies, "--resume")
        names = [f"step_{step:09}" for step in range(0, 301, 50)]
        with h5py.File(undisturbed / "fields.h5") as expected, h5py.File(resumed / "fields.h5") as file:
            self.assertEqual(set(file), {*names, "mean"})
            for group in (*names, "mean"):
                for dataset in ("density_kg_per_m3", "velocity_m_per_s", "body"):
                    np.testing.assert_array_equal(file[group][dataset], expected[group][dataset])
        for name in ("fields.xdmf", "fields_mean.xdmf", "bodies.pvd"):
            self.assertEqual((resumed / name).read_text(), (undisturbed / name).read_text())

    def test_finds_a_compressed_slice_and_no_uncompressed_copy_beside_it(self):
        run = self.run_quick(
            "out", *_FIELDS, "--set", "run.steps=200", "--set", "output.fields.compression=deflate",
            "--set", "output.fields.region_cells={y: 12}", "--set", "output.fields.quantities=[velocity, vorticity]",
        )  # fmt: skip
        self.assertEqual(
            sorted(path.name for path in run.glob("fields*")),
            ["fields", "fields.h5", "fields.xdmf", "fields_mean.xdmf"],
        )
        self.assertEqual({path.suffix for path in (run / "fields").iterdir()}, {".h5"})
        with h5py.File(run / "fields.h5") as file:
            self.assertEqual(set(file["mean"]), {"velocity_m_per_s", "vorticity_per_s", "body"})
            self.assertEqual(file["step_000000200/vorticity_per_s"].shape, (96, 1, 48, 3))
            self.assertEqual(file["step_000000200/vorticity_per_s"].compression, "gzip")

    def test_is_told_about_regions_outside_the_domain_and_unknown_quantities(self):
        for setting, words in (
            ("region_cells={x: [5, 4]}", "no cell lies in it"),
            ("region_cells={z: 9999}", "Use cells of the domain"),
            ("quantities=[speed]", "known: density, velocity, pressure, vorticity"),
        ):
            session = self.start("check", QUICK, "--set", f"output.fields.{setting}")
            self.assertEqual(session.end(), 2)
            self.assertRegex(re.sub(r"\s+", " ", "".join(session.stderr)), words)


if __name__ == "__main__":
    unittest.main()
