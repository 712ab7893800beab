"""The swimmers of configs/examples in Stokes flow move as their comments promise, one of them as its page shows."""

import json
import os
import re
import sys
import unittest
from pathlib import Path

import numpy as np
from copepod_session import ROOT, CommandTest, WholeRunTest

sys.path[:0] = [str(ROOT / "python"), str(ROOT / "examples/python")]

import h5py  # noqa: E402
import solenoidal_flow  # noqa: E402

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


class FlowRuns(WholeRunTest):
    """Runs of a case that a test has written."""

    CELLS = (20, 16, 12)
    FLUID = {
        "solver": "lattice_boltzmann",
        "density_kg_per_m3": 1000,
        "kinematic_viscosity_m2_per_s": 1e-6,
        "cell_size_m": 1e-3,
        "relaxation_time": 0.53,
        "domain_cells": CELLS,
        "boundaries": {"x": "periodic", "y": "periodic", "z": "periodic"},
        "initial_flow": {"kind": "file", "file": "flow.h5"},
    }

    def decay(self, *settings, steps=300, transport="in_process"):
        """Folder of a run."""
        return self.run_of(
            self.folder / "decay.yaml", f"services.transport={transport}", f"run.steps={steps}", *settings
        )

    def digest(self, run):
        return json.loads((run / "summary.json").read_text())["digest"]


class FlowFromFile(FlowRuns):
    """The example that draws a flow, and cases that begin with what a file holds."""

    SPEED = 0.005  # 0.05 cells per step

    def write_case(self, **fluid):
        case = {"case": "decay", "fluid": {**self.FLUID, **fluid}, "run": {"steps": 300}}
        (self.folder / "decay.yaml").write_text(json.dumps(case))

    def write_flow(self, cells=FlowRuns.CELLS):
        u = self.SPEED * solenoidal_flow.solenoidal(cells, 1e-3, 2 * np.pi * 2 / 0.02)
        solenoidal_flow.write(self.folder / "flow.h5", u, solenoidal_flow.pressure(u, 1e-3, 1000.0), 1e-3)
        return u

    def velocity(self, run, step):
        with h5py.File(run / "fields.h5") as h5:
            return np.array(h5[f"step_{step:09}/velocity_m_per_s"])

    def test_drawn_flow_has_no_divergence_and_the_spectrum_that_was_asked_for(self):
        cells, peak = (48, 48, 48), 2 * np.pi * 4
        u = solenoidal_flow.solenoidal(cells, 1 / 48, peak, seed=3)
        of_u = solenoidal_flow.gradient(u, 1 / 48)
        self.assertLess(np.abs(np.einsum("iizyx->zyx", of_u)).max(), 1e-12 * np.abs(of_u).max())
        np.testing.assert_array_equal(u, solenoidal_flow.solenoidal(cells, 1 / 48, peak, seed=3))
        self.assertLess(np.corrcoef(u.ravel(), solenoidal_flow.solenoidal(cells, 1 / 48, peak).ravel())[0, 1], 0.1)
        waves = np.abs(np.fft.fftn(u, axes=(1, 2, 3)) / 48**3) ** 2
        k = np.stack(np.meshgrid(*[np.fft.fftfreq(48, 1 / 48)] * 3))
        shell = np.rint(np.sqrt((k**2).sum(axis=0))).astype(int)
        energy = np.bincount(shell.ravel(), 0.5 * waves.sum(axis=0).ravel())
        self.assertAlmostEqual(energy.sum(), 1.5)
        wanted = solenoidal_flow.spectrum(np.arange(energy.size), 4.0)
        np.testing.assert_allclose(energy[2:9], 1.5 * wanted[2:9] / wanted.sum(), rtol=0.4)
        self.assertEqual(energy[:9].argmax(), 4)

    def test_flow_that_is_read_decays_as_the_one_that_was_written(self):
        drawn = self.write_flow()
        self.write_case()
        fields = "output.fields={every_steps: 100, quantities: [density, velocity]}"
        undisturbed = self.decay(fields)
        np.testing.assert_allclose(self.velocity(undisturbed, 0), np.moveaxis(drawn, 0, -1), atol=1e-12)
        change = np.abs(self.velocity(undisturbed, 300) - self.velocity(undisturbed, 100)).max()
        again = self.decay(
            fields,
            f"fluid.initial_flow.file={undisturbed}/fields.h5",
            "fluid.initial_flow.group=step_000000100",
            steps=200,
        )
        difference = np.abs(self.velocity(again, 200) - self.velocity(undisturbed, 300)).max()
        self.assertLess(difference, 0.01 * change)

    def test_bits_are_those_of_one_rank(self):
        self.write_flow()
        self.write_case(boundaries={"x": "no_slip", "y": "periodic", "z": "free_slip"}, symmetry_planes=["z"])
        alone = self.digest(self.decay(steps=50))
        for ranks, transport in ((2, "ipc"), (3, "in_process")):
            run = self.decay(f"services.fluid.ranks={ranks}", steps=50, transport=transport)
            self.assertEqual(self.digest(run), alone)

    def test_resumed_run_needs_no_file(self):
        self.write_flow()
        self.write_case()
        expected = self.digest(self.decay(steps=40))
        run = self.decay("output.checkpoint.every_steps=20", steps=30)
        self.assertEqual(self.digest(self.run_of(run / "case.yaml", "run.steps=40")), expected)
        (self.folder / "flow.h5").unlink()
        arguments = ("--set", "services.transport=in_process", "--set", "run.steps=40", "--out", run)
        settings = ("--set", "output.checkpoint.every_steps=20")
        self.finish("run", self.folder / "decay.yaml", *settings, *arguments, "--resume")
        self.assertEqual(self.digest(run), expected)
        refused = self.finish("run", self.folder / "decay.yaml", code=2)
        self.assertIn("flow.h5: cannot open it", refused.last_line)

    def test_files_that_cannot_be_used_are_named(self):
        self.write_case()
        file = self.folder / "flow.h5"
        self.write_flow((20, 16, 10))
        self.assert_refused("has 10 × 16 × 20 × 3 values in step_000000000/velocity_m_per_s, not 12 × 16 × 20 × 3")
        self.write_flow()
        whole = file.read_bytes()
        file.write_bytes(whole[: len(whole) // 2])
        self.assert_refused("truncated file")
        file.write_bytes(np.random.default_rng(1).bytes(5000))
        self.assert_refused("file signature not found")
        file.write_bytes(b"")
        self.assert_refused("file signature not found")
        changes = {
            "in cell (3, 2, 1) that cannot be computed (speed nan": lambda h5: self.put(h5, "velocity_m_per_s", np.nan),
            "(speed 173 cells per step, at most 0.4": lambda h5: self.put(h5, "velocity_m_per_s", 10.0),
            "density inf times the fluid's": lambda h5: self.put(h5, "pressure_Pa", np.inf),
            "cannot open dataset step_000000000/velocity_m_per_s": lambda h5: h5.pop("step_000000000/velocity_m_per_s"),
            "has no group of a step": lambda h5: h5.move("step_000000000", "flow"),
            "cannot open dataset step_000000007/velocity": lambda h5: h5.create_dataset("step_000000007", data=[1.0]),
            "cannot read dataset step_000000000/velocity_m_per_s": lambda h5: self.replace_by_text(h5),
        }
        for sentence, change in changes.items():
            file.write_bytes(whole)
            with h5py.File(file, "r+") as h5:
                change(h5)
            with self.subTest(sentence):
                self.assert_refused(sentence)
        file.write_bytes(whole)
        self.assert_refused("has no group mean", "--set", "fluid.initial_flow.group=mean")

    def write_inflow(self, **more):
        """A case with an inflow of 16 × 12 cells."""
        inflow = {"velocity_m_per_s": [0.002, 0, 0], **more}
        boundaries = {"x": {"low": inflow, "high": "outflow"}, "y": "no_slip", "z": "periodic"}
        self.write_case(boundaries=boundaries, initial_flow={"kind": "rest"})

    def test_profile_of_an_inflow_from_a_file(self):
        table = self.folder / "inflow.csv"
        self.write_inflow()
        uniform = self.digest(self.decay(steps=30))
        self.write_inflow(profile="parabolic")
        parabola = self.velocity(self.decay("output.fields={every_steps: 30}", steps=30), 30)
        self.write_inflow(profile={"file": "inflow.csv"})
        np.savetxt(table, np.ones(16 * 12), header="factor", comments="")
        self.assertEqual(self.digest(self.decay(steps=30)), uniform)
        s = (np.arange(16) + 0.5) / 16
        np.savetxt(table, np.repeat(4 * s * (1 - s), 12))
        run = self.decay("output.fields={every_steps: 30}", "services.fluid.ranks=3", steps=30)
        np.testing.assert_allclose(self.velocity(run, 30), parabola, atol=0.01 * 0.002)
        table.unlink()
        self.assertEqual(self.digest(self.run_of(run / "case.yaml", "services.fluid.ranks=1")), self.digest(run))
        self.assert_refused("inflow.csv cannot be read")
        table.write_text("1\n" * 191)
        self.assert_refused("profile has 191 factors, the face 192 cells")
        table.write_text("1\n" * 191 + "nan\n")
        self.assert_refused("'nan' is not a finite number")
        table.write_text("1\n" * 191 + "300\n")
        self.assert_refused("the speed of the wall is 6 cells per step")

    def assert_refused(self, sentence, *arguments):
        checked = self.finish("check", "decay.yaml", *arguments, code=2)
        self.assertIn(sentence, "".join(checked.stdout + checked.stderr))

    @staticmethod
    def put(h5, name, value):
        h5[f"step_000000000/{name}"][1, 2, 3] = value

    @staticmethod
    def replace_by_text(h5):
        shape = h5["step_000000000/velocity_m_per_s"].shape
        del h5["step_000000000/velocity_m_per_s"]
        h5["step_000000000/velocity_m_per_s"] = np.full(shape, b"fast")


class BodiesThatLeave(FlowRuns):
    """Through an outflow, one after the other; the last one is held by a spring and ends the run."""

    def write_stream(self, **more):
        along = [4e-4, 0, 0]  # 0.04 cells per step
        boundaries = {
            "x": {"low": {"velocity_m_per_s": along}, "high": {"outflow": {"bodies": "remove"}}},
            "y": "free_slip",
            "z": "periodic",
        }
        ball = {"radius_m": 3e-3, "density_kg_per_m3": 1000, "velocity_m_per_s": along}
        fluid = {**self.FLUID, "relaxation_time": 0.8, "domain_cells": [32, 16, 16], "boundaries": boundaries}
        fluid["initial_flow"] = {"kind": "uniform", "velocity_m_per_s": along}
        case = {
            "case": "leaving",
            "fluid": fluid,
            "bodies": [{"name": f"ball_{x}", "position_m": [x * 1e-3, 8e-3, 8e-3], **ball} for x in (8, 16, 26)],
            "contact": {},
            "run": {"steps": 400},
            **more,
        }
        (self.folder / "decay.yaml").write_text(json.dumps(case))

    def removed(self, run):
        return json.loads((run / "summary.json").read_text())["removed_bodies"]

    def test_any_ranks_any_transport_and_a_resumed_run_have_the_same_bits(self):
        self.write_stream()
        expected = self.decay(steps=400)
        self.assertEqual(self.removed(expected), ["ball_16", "ball_26"])
        self.assertIn("body 'ball_16' left through an outflow", (expected / "logs/coupler.log").read_text())
        for settings in (("services.fluid.ranks=2", "services.transport=ipc"), ("services.fluid.ranks=4",)):
            self.assertEqual(self.digest(self.decay(*settings, steps=400)), self.digest(expected))
        run = self.decay("output.checkpoint.every_steps=50", steps=150)
        self.assertEqual(self.removed(run), ["ball_26"])
        settings = ("services.transport=in_process", "services.fluid.ranks=3", "output.checkpoint.every_steps=50")
        words = [word for setting in settings for word in ("--set", setting)]
        self.finish("run", self.folder / "decay.yaml", *words, "--out", run, "--resume")
        self.assertEqual(self.digest(run), self.digest(expected))

    def test_other_bodies_end_the_run_by_name(self):
        spring = {"bodies": ["ball_16", "ball_26"], "stiffness_N_per_m": 1e-9, "rest_length_m": 0.01}
        self.write_stream(springs=[spring])
        ended = self.finish("run", self.folder / "decay.yaml", code=70)
        self.assertIn("body 2 runs into the upper face normal to x", "".join(ended.stderr))


if __name__ == "__main__":
    unittest.main()
