"""`copepod report` on swarms whose motion is known in closed form, and what it calculates of many swimmers."""

import json
import re
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from surfaces import with_surfaces
from synthetic_run import STEP_S, write_snapshot, write_swarm
from copepod_report.fields import read_components
from copepod_report.report import page_of
from copepod_report.run_record import RunRecord
from copepod_report.swarm import Swarm, energy_spectrum, pair_distribution


def read_case(path):
    """As the stand-in coupler does."""
    return with_surfaces(json.loads(path.read_text())["case"])


class SwarmReport(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_hundred_swimmers_are_shown_as_a_swarm(self):
        write_swarm(self.folder / "run")
        text = page_of(self.folder / "run", read_case)
        self.assertEqual(text.count("<h3>"), 0)
        captions = re.findall(r"<figcaption>(.*?)</figcaption>", text)
        for beginning in ("100 swimmers from the side", "Order of 100 swimmers", "Pair distribution", "Mean-square"):
            self.assertEqual(sum(caption.startswith(beginning) for caption in captions), 1, captions)
        self.assertLess(len(text), 3e6)

    def test_more_than_six_swimmers_share_a_table(self):
        for count, headings in ((6, 6), (7, 0)):
            folder = self.folder / f"run{count}"
            write_swarm(folder, swimmers=count)
            summary = json.loads((folder / "summary.json").read_text())
            for number, entry in enumerate(summary["swimmers"]):
                entry["u_swim_lattice"] = 0.001 * number
            (folder / "summary.json").write_text(json.dumps(summary))
            text = page_of(folder, read_case)
            self.assertEqual(text.count("<h3>"), headings)
            self.assertEqual(len(re.findall(r"<tr><td>s\d</td>", text)), 0 if headings else count)
            self.assertEqual("<tr><td>s5</td><td>0.005</td></tr>" in text, not headings)

    def test_figures_of_a_swarm_hold_what_its_trajectory_does(self):
        write_swarm(self.folder / "run", swimmers=20)
        swarm = Swarm(RunRecord(self.folder / "run", read_case))
        self.assertEqual(swarm.centroids_m.shape, (60, 20, 3))
        np.testing.assert_allclose(swarm.axes[5, 0], [1, 0, 0], atol=1e-12)
        np.testing.assert_allclose(swarm.polar_order(), 0, atol=1e-12)  # a ring points everywhere
        np.testing.assert_allclose(swarm.nematic_order(), 0.25)  # in one plane
        lags_s, squares_m2 = swarm.mean_square_displacement()
        expected = np.mean([(1e-8 * number) ** 2 for number in range(20)]) * (lags_s / STEP_S) ** 2
        np.testing.assert_allclose(squares_m2, expected, rtol=1e-9)

    def test_points_spread_evenly_have_a_pair_distribution_of_one(self):
        random = np.random.default_rng(1)
        lengths = np.array([1.0, 2.0, 0.5])
        for periodic, flat in (([0, 0, 0], 1), ([1, 2, 0.5], 1), ([0, 2, 0], 1), ([0, 0, 0], 0)):
            points = random.random((40, 150, 3)) * lengths * (1, 1, flat)
            distances, ratio = pair_distribution(points, periodic, bins=10)
            self.assertAlmostEqual(distances[-1] + distances[0], 0.25 if periodic[2] else 1.0, delta=0.02)
            np.testing.assert_allclose(ratio[3:], 1, atol=0.1)

    def test_pair_distribution_peaks_where_pairs_are(self):
        random = np.random.default_rng(1)
        points = random.random((20, 50, 3))
        points = np.concatenate([points, np.mod(points + (0.1, 0, 0), 1)], axis=1)  # partners across the face, too
        distances, ratio = pair_distribution(points, [1, 1, 1], bins=25)
        self.assertAlmostEqual(distances[np.argmax(ratio)], 0.1, delta=0.02)
        self.assertEqual(pair_distribution(points[:, :1], [1, 1, 1])[0].size, 0)

    def test_power_of_a_swarm_is_that_of_all_drives(self):
        write_swarm(self.folder / "run", swimmers=8, samples=10)
        trajectory = self.folder / "run/trajectory.csv"
        header, *rows = trajectory.read_text().splitlines()
        columns = header.split(",")
        for number, row in enumerate(rows):
            fields = row.split(",")
            fields[columns.index("vy_m_per_s")], fields[columns.index("drive_fy_N")] = "2.0", f"{fields[0]}.0"
            rows[number] = ",".join(fields)
        trajectory.write_text("\n".join([header, *rows]) + "\n")
        swarm = Swarm(RunRecord(self.folder / "run", read_case))
        np.testing.assert_allclose(swarm.power_W, 2 * 24 * np.arange(10))
        names = [name for name, _, _ in swarm.figures()]
        self.assertEqual(names, ["swarm", "power", "orientations", "pairs", "spreading"])

    def spectra(self):
        captions = re.findall(r"<figcaption>(.*?)</figcaption>", page_of(self.folder / "run", read_case))
        return [caption.partition(":")[0] for caption in captions if caption.startswith("Energy spectrum")]

    def test_spectrum_of_the_last_snapshot_holds_its_energy(self):
        write_swarm(self.folder / "run", swimmers=10)
        random = np.random.default_rng(1)
        velocity = random.normal(size=(12, 10, 8, 3))
        write_snapshot(self.folder / "run/fields.h5", 0, 0 * velocity)
        write_snapshot(self.folder / "run/fields.h5", 400, velocity)
        self.assertEqual(self.spectra(), ["Energy spectrum of the flow at step 400"])
        components, cells = read_components(self.folder / "run/fields.h5", 400)
        self.assertEqual(cells, 1)
        for axis in range(3):
            np.testing.assert_array_equal(components[axis], velocity[..., axis].astype(np.float32))

    def test_spectrum_has_no_figure_for_fluid_at_rest(self):
        write_swarm(self.folder / "run", swimmers=10)
        write_snapshot(self.folder / "run/fields.h5", 0, np.zeros((12, 10, 8, 3)))
        self.assertEqual(self.spectra(), [])


class Spectrum(unittest.TestCase):
    def test_of_a_vortex_is_one_line(self):
        points = 2 * np.pi * (np.arange(24) + 0.5) / 24
        x, y, z = np.meshgrid(points, points, points, indexing="ij")
        velocity = (np.sin(3 * x) * np.cos(4 * y), -0.75 * np.cos(3 * x) * np.sin(4 * y), 0 * z + 7.0)
        k, density = energy_spectrum(velocity, 0.5, (True, True, True))
        spacing = 2 * np.pi / 12
        np.testing.assert_allclose(k, spacing * np.arange(1, len(k) + 1))
        energy = density * spacing
        self.assertAlmostEqual(energy[4], 0.125 * (1 + 0.75**2))  # at (3, 4, 0), without what is uniform
        np.testing.assert_allclose(np.delete(energy, 4), 0, atol=1e-12)

    def test_between_walls_is_that_of_cosines(self):
        z = (np.arange(20) + 0.5) / 20
        velocity = [np.broadcast_to(np.cos(5 * np.pi * z), (1, 6, 20))]
        k, density = energy_spectrum(velocity, 1 / 20, (False, True, False))
        width = 2 * np.pi / 0.3  # of the shorter, periodic axis
        self.assertAlmostEqual((density * width)[0], 0.25)
        self.assertAlmostEqual(density.sum() * width, 0.25)

    def test_has_the_energy_of_the_flow_whatever_the_box(self):
        random = np.random.default_rng(2)
        for shape in ((7, 10, 12), (1, 9, 8), (16, 1, 1)):
            for periodic in ((True, True, True), (False, False, False), (False, True, False)):
                velocity = random.normal(size=(3, *shape))
                k, density = energy_spectrum(velocity, 0.1, periodic)
                fluctuation = velocity - velocity.mean(axis=(1, 2, 3), keepdims=True)
                expected = 0.5 * (fluctuation**2).mean(axis=(1, 2, 3)).sum()
                self.assertAlmostEqual(density.sum() * k[0], expected)
        self.assertEqual(energy_spectrum(np.ones((3, 1, 1, 1)), 0.1, (True,) * 3)[0].size, 0)

    def test_of_white_noise_grows_with_the_surface_of_the_shells(self):
        k, density = energy_spectrum(np.random.default_rng(3).normal(size=(3, 48, 48, 48)), 1.0, (True,) * 3)
        expected = 3 * 4 * np.pi / (2 * (2 * np.pi) ** 3)
        within = slice(8, 22)  # beyond, shells reach out of the box of modes
        self.assertAlmostEqual((density[within] / k[within] ** 2).mean() / expected, 1.0, delta=0.03)

    def test_of_a_large_field_averages_over_blocks(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "fields.h5"
            z = np.arange(10.0)[:, None, None, None]
            with h5py.File(path, "w") as file:
                file["step_000000000/velocity_m_per_s"] = np.broadcast_to(z, (10, 1000, 1001, 3)).astype(np.float32)
            components, cells = read_components(path, 0)
            self.assertEqual((components[0].shape, cells), ((5, 500, 500), 2))
            np.testing.assert_allclose(components[2][:, 3, 4], 2 * np.arange(5) + 0.5)


if __name__ == "__main__":
    unittest.main()
