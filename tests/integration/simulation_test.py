"""Simulations in this process, by `import copepod` and from C: steps, steering, snapshots, environments."""

import ctypes
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings
from pathlib import Path

import numpy
from copepod_session import ROOT

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
os.environ["COPEPOD_BIN_DIR"] = str(PROGRAMS)
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "examples/learning")]

import copepod  # noqa: E402
import steer_triangle  # noqa: E402
import three_spheres  # noqa: E402
import two_swimmers  # noqa: E402
from copepod_run.processes import family_of  # noqa: E402

STROKE = ROOT / "configs/examples/prescribed_stroke.yaml"
TABLE = {"kind": "table", "times_steps": [0, 100], "values": [0.0, -4.0e-6]}


class SimulationTest(unittest.TestCase):
    def test_ends_with_the_digest_of_the_command_and_leaves_a_whole_run(self):
        with tempfile.TemporaryDirectory() as folder:
            settings = {
                "run.steps": 900,
                "output.fields.mean_over_steps": [100, 800],
                "output.fields.mean_every_steps": 50,
                "output.flow": {
                    "every_steps": 7,
                    "probes": [{"name": "side, left", "position_m": [1e-5, 2.1e-5, 5e-5]}],
                },
            }
            case = ROOT / "configs/quick/three_sphere.yaml"
            run = copepod.run(case, f"{folder}/run", set=settings, quiet=True)
            with warnings.catch_warnings(action="ignore"):
                sim = copepod.Simulation(case, f"{folder}/sim", set=settings, ranks=2)
            with sim:
                sim.step(300)
                middle = sim.snapshot()
                sim.step(333)
                sim.restore(middle)
                sim.step(600)
                positions, flow = sim.bodies.position_m, sim.flow
            other = copepod.load(f"{folder}/sim")
            self.assertEqual(other.status, "finished")
            self.assertEqual(other.summary["digest"], run.summary["digest"])
            self.assertTrue(other.trajectory.equals(run.trajectory))
            self.assertTrue(other.flow.equals(run.flow))
            self.assertEqual(list(run.flow.index), list(range(0, 900, 7)))
            self.assertEqual(flow, run.flow.drop(columns="time_s").loc[896].to_dict())
            numpy.testing.assert_array_equal(other.trajectory.xs(900, level="step")[["x_m", "y_m", "z_m"]], positions)

    def test_samples_of_the_flow_are_those_of_its_fields(self):
        """An octant of a vortex: totals from all cells, probes linear between them, also in the mirror image."""
        fluid = {"solver": "lattice_boltzmann", "density_kg_per_m3": 1000, "kinematic_viscosity_m2_per_s": 1e-5}
        fluid |= {"cell_size_m": 1e-3, "domain_cells": [16, 16, 16], "symmetry_planes": ["x", "y", "z"]}
        fluid["boundaries"] = dict.fromkeys("xyz", "free_slip")
        fluid["initial_flow"] = {"kind": "taylor_green_3d", "speed_m_per_s": 0.02}
        probes = [
            {"name": "cell", "position_m": [2.5e-3, 4.5e-3, 3.5e-3]},
            {"name": "mirrored", "position_m": [13.5e-3, 4.5e-3, 3.5e-3]},
            {"name": "between", "position_m": [3.0e-3, 4.5e-3, 3.5e-3]},
        ]
        output = {"flow": {"every_steps": 20, "probes": probes}, "fields": {"every_steps": 20}}
        output["fields"]["quantities"] = ["density", "velocity", "pressure", "vorticity"]
        case = {"case": "vortex", "fluid": fluid, "step_s": 2e-3, "bodies": [], "run": {"steps": 60}, "output": output}
        with tempfile.TemporaryDirectory() as folder:
            run = copepod.run(case, f"{folder}/run", quiet=True)
            fields, flow = run.fields.isel(time=2), run.flow.loc[40]
            rho, u = fields["density_kg_per_m3"].values, fields["velocity_m_per_s"].values
            omega, pressure = fields["vorticity_per_s"].values, fields["pressure_Pa"].values
            self.assertAlmostEqual(
                flow["kinetic_energy_J"] / (0.5e-9 * (rho[..., None] * u**2).sum()), 1, delta=1e-12
            )
            self.assertAlmostEqual(flow["enstrophy_m3_per_s2"] / (0.5e-9 * (omega**2).sum()), 1, delta=1e-12)
            # Without walls ε = 2 ρ ν · enstrophy, but for the differences of a wave of 16 cells and its compression.
            self.assertAlmostEqual(flow["dissipation_W"] / (2 * 0.01 * flow["enstrophy_m3_per_s2"]), 1, delta=1e-3)
            first, later = run.flow["kinetic_energy_J"].loc[[20, 40]]
            self.assertAlmostEqual((first - later) / (20 * 2e-3) / run.flow["dissipation_W"].loc[[20, 40]].mean(), 1, 1)
            for name, (z, y, x), sign in (("cell", (3, 4, 2), 1), ("mirrored", (3, 4, 2), -1)):
                found = [flow[f"{name}.v{axis}_m_per_s"] for axis in "xyz"]
                numpy.testing.assert_allclose(found, u[z, y, x] * [sign, 1, 1], rtol=1e-12)
                self.assertAlmostEqual(flow[f"{name}.pressure_Pa"] / pressure[z, y, x], 1, delta=1e-9)
            numpy.testing.assert_allclose(flow["between.vx_m_per_s"], u[3, 4, 2:4, 0].mean(), rtol=1e-12)
            self.assertEqual(flow["px_kg_m_per_s"], 0)

    def test_a_joint_follows_as_it_would_a_signal_of_the_case(self):
        with copepod.Simulation(STROKE, set={"joints.0.signal": TABLE}) as given:
            with copepod.Simulation(
                STROKE, set={"joints.0.signal": {"kind": "constant", "amplitude_m": 3.0e-6}}
            ) as sim:
                self.assertEqual(sim.actuators.paths, ["joints.0", "joints.1"])
                sim.actuators.move("joints.0", -4.0e-6, 100)
                for one in (given, sim):
                    one.step(150)
                numpy.testing.assert_array_equal(sim.bodies.position_m, given.bodies.position_m)
                rods_m = numpy.diff(sim.bodies.position_m[:, 2])
                self.assertAlmostEqual(rods_m[0], 76.0e-6, delta=1e-12)
                self.assertEqual((sim.steps, len(sim.actuators)), (150, 2))
                self.assertAlmostEqual(sim.time_s, 150 * 7.5e-10)

    def test_a_prescribed_body_moves_as_by_a_signal_of_the_case(self):
        """Of 1, then within 20 steps to −0.5, kept through a snapshot."""
        ball = {"name": "ball", "radius_m": 2e-6, "mass_kg": 5e-14, "position_m": [8e-6, 8e-6, 8e-6]}
        motion = {"velocity_m_per_s": [3.0, 0, 0], "angular_velocity_rad_per_s": [0, 2e6, 0]}
        table = {"kind": "table", "times_steps": [0, 10, 30], "values": [1.0, 1.0, -0.5]}
        fluid = {"solver": "lattice_boltzmann", "density_kg_per_m3": 1360, "kinematic_viscosity_m2_per_s": 7.36e-5}
        fluid |= {"cell_size_m": 1e-6, "domain_cells": [16, 16, 16]}
        fluid["boundaries"] = dict.fromkeys("xyz", "periodic")

        def opened(signal):
            moved = {**ball, "motion": {"prescribed": {**motion, "signal": signal}}}
            case = {"case": "ball", "fluid": fluid, "step_s": 7.5e-10, "bodies": [moved], "run": {"steps": 60}}
            return copepod.Simulation(case)

        with opened(table) as given, opened({"kind": "constant", "amplitude": 1.0}) as sim:
            self.assertEqual(sim.actuators.paths, ["bodies.0.motion.prescribed"])
            sim.step(10)
            sim.actuators.move(0, -0.5, 20)
            sim.step(5)
            middle = sim.snapshot()
            sim.actuators[0] = 7.0
            sim.step(5)
            sim.restore(middle)
            sim.step(45)
            given.step(60)
            self.assertAlmostEqual(given.bodies.position_m[0, 0], 8e-6 + 3.0 * 7.5e-10 * (10 + 5 - 15), delta=1e-20)
            for name in ("position_m", "orientation_wxyz", "velocity_m_per_s", "force_N", "torque_N_m"):
                numpy.testing.assert_allclose(getattr(sim.bodies, name), getattr(given.bodies, name), rtol=1e-9, atol=0)

    def test_figures_of_cycles_are_those_of_the_summary(self):
        """Of swimmer and group as soon as a cycle ends, in the next one the same, after a return those of the state."""
        pair = {"name": "pair", "bodies": ["swimmer.B1", "swimmer.B3"], "axis": [0, 0, 1], "period_steps": 1000}
        with tempfile.TemporaryDirectory() as folder:
            with copepod.Simulation(ROOT / "configs/quick/vacuum.yaml", f"{folder}/run", set={"groups": [pair]}) as sim:
                for steps, cycles in ((0, (None, None)), (2000, (None, 1)), (2000, (0, 3)), (4999, (1, 7))):
                    sim.step(steps)
                    found = [sim.cycles[name]["cycle"] for name in ("swimmer", "pair")]
                    self.assertEqual(found, list(cycles), sim.steps)
                middle, before = sim.snapshot(), sim.cycles
                sim.step(3001)
                self.assertNotEqual(sim.cycles, before)
                sim.restore(middle)
                self.assertEqual(sim.cycles, before)
                sim.step(3001)
                last = sim.cycles
            summary = copepod.load(f"{folder}/run").summary
            self.assertEqual(last["swimmer"], summary["swimmers"][0]["kinematics"])
            self.assertEqual(last["pair"], summary["groups"][0]["kinematics"])
            self.assertEqual((last["swimmer"]["cycle"], last["pair"]["cycle"]), (2, 11))

    def test_an_interrupt_ends_a_long_step_at_once_with_the_state_whole(self):
        before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it
        self.addCleanup(signal.signal, signal.SIGINT, before)
        with copepod.Simulation(STROKE) as sim:
            start = sim.snapshot()
            sent_s = []

            def interrupt():
                time.sleep(0.3)
                sent_s.append(time.monotonic())
                os.kill(os.getpid(), signal.SIGINT)

            thread = threading.Thread(target=interrupt)
            thread.start()
            with self.assertRaises(KeyboardInterrupt):
                sim.step(10**9)
            late_s = time.monotonic() - sent_s[0]
            thread.join()
            self.assertLess(late_s, 1.0)  # 0.05 s, but for the load of this machine
            steps, positions = sim.steps, sim.bodies.position_m
            self.assertGreater(steps, 0)
            sim.restore(start)
            sim.step(steps)
            numpy.testing.assert_array_equal(sim.bodies.position_m, positions)

    def test_a_checkpoint_is_resumed_as_if_nothing_had_been(self):
        """By another simulation, and by the command; what was steered stays so, in the run directory, too."""
        settings = {"run.steps": 150, "output.trajectory.every_steps": 10}

        def steered(sim):
            sim.step(20)
            sim.actuators.move("joints.0", -4.0e-6, 60)
            sim.step(30)

        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(action="ignore"):
            with copepod.Simulation(STROKE, f"{folder}/whole", set=settings) as whole:
                steered(whole)
                whole.step(100)
            with copepod.Simulation(STROKE, f"{folder}/cut", set=settings) as cut:
                with self.assertRaisesRegex(copepod.Error, "checkpoint cannot be written"):
                    cut.write_checkpoint()
                steered(cut)
                cut.write_checkpoint()
                cut.step(7)
            shutil.copytree(f"{folder}/cut", f"{folder}/command")
            with copepod.Simulation.resume(f"{folder}/cut") as resumed:
                self.assertEqual(resumed.steps, 50)
                with self.assertRaisesRegex(copepod.CaseError, "is in use"):
                    copepod.Simulation.resume(f"{folder}/cut")
                with self.assertRaisesRegex(copepod.Error, "in use"):
                    copepod.run(STROKE, f"{folder}/cut", set=settings, resume=True, quiet=True)
                resumed.step(100)
            copepod.run(STROKE, f"{folder}/command", set=settings, resume=True, quiet=True)
            runs = [copepod.load(f"{folder}/{name}") for name in ("whole", "cut", "command")]
            self.assertEqual(len({run.summary["digest"] for run in runs}), 1)
            for run in runs[1:]:
                self.assertTrue(run.trajectory.equals(runs[0].trajectory))
            with self.assertRaisesRegex(copepod.CaseError, "holds a run already"):
                copepod.Simulation(STROKE, f"{folder}/cut")
            with self.assertRaisesRegex(copepod.Error, "holds no checkpoint"):
                copepod.Simulation.resume(f"{folder}/whole")
            with self.assertRaises(copepod.CaseError):
                copepod.Simulation.resume(f"{folder}/nowhere")
            with copepod.Simulation(STROKE) as kept_nowhere:
                kept_nowhere.step()
                with self.assertRaisesRegex(copepod.Error, "checkpoint cannot be written"):
                    kept_nowhere.write_checkpoint()

    def test_coefficients_are_those_of_the_command_on_any_ranks_whether_cut_short_or_not(self):
        """A square stream past half a ball and a swimmer's bead; the other half is the ball's mirror image."""
        fluid = {"solver": "lattice_boltzmann", "density_kg_per_m3": 1000, "kinematic_viscosity_m2_per_s": 1e-6}
        fluid |= {"cell_size_m": 1e-3, "domain_cells": [12, 24, 12], "relaxation_time": 0.8}
        inflow = {"low": {"velocity_m_per_s": [0, 5e-4, 0]}, "high": "outflow"}
        fluid |= {"symmetry_planes": ["z"], "boundaries": {"x": "free_slip", "y": inflow, "z": "free_slip"}}
        ball = {"name": "ball", "radius_m": 2e-3, "density_kg_per_m3": 1000, "position_m": [6e-3, 9e-3, 6e-3]}
        rock = {"name": "rock", "shape": "sphere", "radius_m": 2e-3, "position_m": [6e-3, 16e-3, 3e-3], "loads": True}
        of_stream = {"speed_m_per_s": 5e-4, "area_m2": 1e-5, "length_m": 4e-3}
        output = {"trajectory": {"every_steps": 4, "format": "npy"}}
        output["coefficients"] = [{"of": name, **of_stream, "from_step": 30} for name in ("ball", "rock")]
        output["flow"] = {"every_steps": 3, "totals": False, "faces": True, "from_step": 30}
        case = {"case": "stream", "fluid": fluid, "bodies": [{**ball, "motion": "fixed"}], "obstacles": [rock]}
        case |= {"run": {"steps": 120}, "output": output}
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(action="ignore"):
            run = copepod.run(case, f"{folder}/run", quiet=True)
            settings = {"services.transport": "in_process"}
            copepod.run(case, f"{folder}/ranks", set=settings, ranks=2, quiet=True)
            with copepod.Simulation(case, f"{folder}/cut") as cut:
                cut.step(50)
                cut.write_checkpoint()
                cut.step(7)
            with copepod.Simulation.resume(f"{folder}/cut", set={"output.coefficients.0.from_step": 40}) as resumed:
                resumed.step(70)
            with self.assertRaisesRegex(copepod.CaseError, "another case .output.coefficients.0.area_m2 is 2.0, was"):
                copepod.Simulation.resume(f"{folder}/cut", set={"output.coefficients.0.area_m2": 2})
            image = {**rock, "name": "image", "position_m": [6e-3, 16e-3, 9e-3]}
            settings = {"fluid.symmetry_planes": [], "obstacles": [rock, image]}
            whole = copepod.run(case, f"{folder}/whole", set=settings, quiet=True)
            tables = {path.parent.name: path.read_text() for path in Path(folder).glob("*/coefficients.csv")}
            self.assertEqual(tables["run"], tables["ranks"])
            self.assertEqual(tables["run"], tables["cut"])
            ball_of_cut, rock_of_cut = copepod.load(f"{folder}/cut").summary["coefficients"]
            figures, rock_of_run = run.summary["coefficients"]
            self.assertEqual(copepod.load(f"{folder}/ranks").summary["coefficients"], [figures, rock_of_run])
            self.assertEqual(rock_of_cut, rock_of_run)
            for other in ("ranks", "cut"):
                self.assertTrue(copepod.load(f"{folder}/{other}").flow.equals(run.flow))
                self.assertEqual(copepod.load(f"{folder}/{other}").summary["flow"], run.summary["flow"])
            for column, of_column in zip(run.flow.drop(columns="time_s").loc[30:].items(), run.summary["flow"]):
                name, samples = column
                expected = [samples.mean(), samples.std(ddof=0), samples.min(), samples.max()]
                numpy.testing.assert_allclose(list(of_column.values())[1:], expected, 1e-9, 1e-20, err_msg=name)
                self.assertEqual((of_column["name"], list(of_column)[1:]), (name, ["mean", "rms", "min", "max"]))
                numpy.testing.assert_allclose(whole.flow[name], run.flow[name], 1e-9, 1e-18, err_msg=name)
            self.assertAlmostEqual(run.flow["y_low.inflow_m3_per_s"].iloc[0] / (5e-4 * 12e-3 * 12e-3), 1, 12)
            self.assertNotEqual(ball_of_cut["drag"], figures["drag"])
            for name, table, found in (("ball", run.trajectory, figures), ("rock", run.obstacles, rock_of_run)):
                forces = table.loc[name].loc[32:116]
                self.assertAlmostEqual(found["drag"]["mean"], forces["fy_N"].mean() / (500 * 5e-4**2 * 1e-5), 12)
                self.assertAlmostEqual(found["lift"]["rms"], forces["fz_N"].std(ddof=0) / (500 * 5e-4**2 * 1e-5), 12)
            self.assertGreater(figures["drag"]["mean"], 1.0)
            for of_half, of_whole in zip(run.summary["coefficients"], whole.summary["coefficients"]):
                self.assertAlmostEqual(of_whole["drag"]["mean"], of_half["drag"]["mean"], 6)
            self.assertAlmostEqual(figures["lift"]["mean"], 0.0, 12)
            self.assertIn("drag coefficient", str(run))
            self.assertNotIn("y_low.fy_N", str(run))  # of 24 columns
            with copepod.Simulation(case) as kept_nowhere:
                kept_nowhere.step(5)

    def test_one_that_ends_before_its_first_step_is_a_whole_run(self):
        ball = {"name": "still", "shape": "sphere", "radius_m": 2e-6, "position_m": [8e-6, 8e-6, 8e-6], "loads": True}
        fluid = {"solver": "lattice_boltzmann", "density_kg_per_m3": 1360, "kinematic_viscosity_m2_per_s": 7.36e-5}
        fluid |= {"cell_size_m": 1e-6, "domain_cells": [16, 16, 16], "relaxation_time": 0.8}
        channel = {"case": "channel", "fluid": fluid, "obstacles": [ball], "bodies": [], "run": {"steps": 9}}
        drag = {"of": "still", "speed_m_per_s": 1, "area_m2": 1, "length_m": 1}
        channel["output"] = {"trajectory": {"every_steps": 1}, "coefficients": [drag]}
        with tempfile.TemporaryDirectory() as folder:
            for name, case in (("stroke", STROKE), ("channel", channel)):
                copepod.Simulation(case, f"{folder}/{name}").close()
                run = copepod.load(f"{folder}/{name}")
                self.assertEqual((run.status, run.summary["steps"]), ("finished", 0))
                table = run.trajectory if name == "stroke" else run.obstacles
                self.assertEqual({step for _, step in table.index}, {0})
            self.assertEqual(run.summary["coefficients"], [{"name": "still", "note": "the run ended before step 4"}])

    def test_mistakes_are_named(self):
        with self.assertRaisesRegex(copepod.CaseError, "fluid.solver is missing"):
            copepod.Simulation({"case": "empty"})
        with copepod.Simulation(STROKE) as sim, copepod.Simulation(STROKE) as other:
            for wrong in ("joints.7", 2, -1):
                with self.assertRaises(copepod.Error):
                    sim.actuators[wrong] = 1.0
            with self.assertRaisesRegex(copepod.Error, "finite"):
                sim.actuators[0] = float("nan")
            snapshot = other.snapshot()
            other.snapshot()
            with self.assertRaisesRegex(copepod.Error, "of another simulation"):
                sim.restore(snapshot)
        with self.assertRaisesRegex(copepod.Error, "is not open"):
            sim.step()
        sim.close()  # a second time nothing

    def test_a_failure_names_the_step_and_a_snapshot_leads_back(self):
        with copepod.Simulation(STROKE) as sim:
            sim.step(10)
            before = sim.snapshot()
            sim.actuators[0] = 1.0  # a rod of a metre
            with self.assertRaisesRegex(copepod.RunError, "at step 10: .*moved by"):
                sim.step(100)
            sim.restore(before)
            sim.step(5)
            self.assertEqual(sim.steps, 15)

    def test_a_snapshot_that_finds_that_the_flow_diverged_is_the_one_failure(self):
        fluid = {"solver": "lattice_boltzmann", "density_kg_per_m3": 1000, "kinematic_viscosity_m2_per_s": 1e-6}
        fluid |= {"cell_size_m": 1e-5, "relaxation_time": 0.51, "domain_cells": [24, 24, 24]}
        body = {"name": "fast", "shape": "sphere", "radius_m": 4e-5, "mass_kg": 1e-9, "motion": "prescribed"}
        body |= {"position_m": [1.22e-4] * 3, "velocity_m_per_s": [11.7, 0, 0]}  # 0.39 cells per step
        with warnings.catch_warnings(action="ignore"):
            sim = copepod.Simulation({"case": "fast", "fluid": fluid, "bodies": [body], "run": {"steps": 100}})
        with self.assertRaisesRegex(copepod.RunError, "the flow diverged at cell"):
            for _ in range(9):
                sim.step()
                sim.snapshot()
        with self.assertRaisesRegex(copepod.Error, "this simulation has failed"):
            sim.step()
        sim.close()

    def test_the_examples_in_c_and_fortran(self):
        warn = ("-Wall", "-Wextra", "-Werror", "-fsanitize=address")
        for command, example in (
            (("cc", "-std=c99", "-Wpedantic", f"-I{ROOT}/in_process"), "c/steer.c"),
            (("gfortran", "-std=f2018"), "fortran/steer.f90"),
        ):
            with self.subTest(example), tempfile.TemporaryDirectory() as folder:
                link = [f"-L{PROGRAMS}", f"-Wl,-rpath,{PROGRAMS}", "-lcopepod", "-o", "steer"]
                subprocess.run([*command, *warn, ROOT / "examples" / example, *link], cwd=folder, check=True)
                ended = subprocess.run([f"{folder}/steer", STROKE], capture_output=True, text=True, check=True)
                self.assertRegex(ended.stdout, r"cycle 1: \+0?\.137\d um")
                ended = subprocess.run([f"{folder}/steer", "missing.yaml"], capture_output=True, text=True)
                self.assertEqual(ended.returncode, 2)
                self.assertIn("missing.yaml", ended.stderr)

    def test_only_its_functions_are_visible(self):
        ended = subprocess.run(
            ["nm", "-D", "--defined-only", PROGRAMS / "libcopepod.so"], capture_output=True, text=True, check=True
        )
        names = {line.split()[-1] for line in ended.stdout.splitlines()}
        headers = "".join((ROOT / "in_process" / f"{name}.h").read_text() for name in ("copepod", "copepod_component"))
        self.assertEqual(names, {name for name in names if f"{name}(" in headers})
        self.assertLessEqual({"copepod_open", "copepod_component_open"}, names)

    def test_the_state_has_the_layout_of_the_header(self):
        self.assertEqual(ctypes.sizeof(copepod.simulation._State), 10 * 8)


SHORT = {
    "run.steps": 120,
    "output.fields.mean_over_steps": [20, 100],
    "output.fields.mean_every_steps": 10,
}
MASSES = """import sys
sys.path.insert(0, sys.argv.pop(1))
from point_masses import PointMasses, FEATURES, Capabilities, run_body_component
class Masses(PointMasses):
    alive = 0
    def __init__(self, setup, context):
        assert Masses.alive == 0, "there are two"
        Masses.alive += 1
        super().__init__(setup, context)
    def __del__(self):
        Masses.alive -= 1
lacks = sys.argv.pop(1)
sys.exit(run_body_component(Masses, Capabilities("Masses", "1.0", [name for name in FEATURES if name != lacks])))
"""


def services():
    """Process ids of all services that this process has had started, by the name in their log's."""
    found = {}
    for pid in family_of(os.getpid()):
        words = Path("/proc", str(pid), "cmdline").read_text().split("\0")
        if "--log-file" in words and "mpirun" not in words[0]:
            found[Path(words[words.index("--log-file") + 1]).stem] = pid
    return found


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


class ServicesTest(unittest.TestCase):
    """Simulations whose fluid, bodies and controllers are processes."""

    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.enterContext(warnings.catch_warnings(action="ignore"))
        self.addCleanup(lambda: self.assertEqual(services(), {}))

    def opened(self, case=STROKE, directory=None, **settings):
        simulation = copepod.Simulation(case, directory, services=True, **settings)
        self.addCleanup(simulation.close)
        return simulation

    def masses(self, lacking):
        """Command of a body component without that feature; it has one solver at a time."""
        (self.folder / "masses.py").write_text(MASSES)
        return [sys.executable, str(self.folder / "masses.py"), str(ROOT / "examples/python"), lacking]

    def test_the_bits_are_those_in_this_process(self):
        """On one rank, and on two over the network with keys; after a return to the middle, and to the start."""
        case = ROOT / "configs/quick/three_sphere.yaml"
        network = {"services.transport": f"tcp://127.0.0.1:{free_port()}"}
        ways = ({}, {"services": True, "ranks": 1}, {"services": True, "ranks": 2, "set": SHORT | network})
        runs = []
        for number, way in enumerate(ways):
            directory = self.folder / str(number)
            with copepod.Simulation(case, directory, **{"set": SHORT} | way) as sim:
                start = sim.snapshot()
                sim.step(40)
                middle = sim.snapshot()
                self.assertEqual(len(list(directory.glob("copepod-simulation-*"))), 2 if number == 2 else 0)
                sim.step(25)
                sim.restore(middle)
                sim.step(20)
                sim.restore(start)
                sim.step(120)
                del start, middle
            self.assertEqual(list(directory.glob("copepod-simulation-*")), [])
            runs.append(copepod.load(directory))
        self.assertEqual({run.status for run in runs}, {"finished"})
        self.assertEqual(len({run.summary["digest"] for run in runs}), 1)
        self.assertEqual([run.summary["ranks"] for run in runs], [2, 1, 2])
        for run in runs[1:]:
            self.assertTrue(run.trajectory.equals(runs[0].trajectory))
        for log in ("1/logs/body.log", "2/logs/body.log", "2/logs/fluid.log"):
            self.assertIn("Ending with exit code 0.", (self.folder / log).read_text())

    def test_components_in_python_and_a_controller_return_too(self):
        pilot = [sys.executable, f"{ROOT}/examples/python/triangle_pilot.py"]
        settings = {"run.steps": 120, "controllers.0.every_steps": 20, "controllers.0.command": pilot}
        settings["services.fluid.command"] = [sys.executable, f"{ROOT}/examples/python/stokes_drag_fluid.py"]
        settings["services.body.command"] = self.masses(lacking="nothing")
        ends_m = []
        for returns in (False, True):
            with self.opened(ROOT / "configs/examples/steered_triangle.yaml", set=settings) as sim:
                self.assertEqual(set(services()), {"fluid", "body", "pilot"})
                start = sim.snapshot()
                sim.step(50)
                if returns:
                    middle = sim.snapshot()
                    sim.restore(start)
                    sim.step(30)
                    sim.restore(middle)
                sim.step(70)
                ends_m.append(sim.bodies.position_m)
        numpy.testing.assert_array_equal(*ends_m)
        self.assertGreater(numpy.ptp(ends_m[0], axis=0).max(), 0.0)

    def test_a_component_without_snapshots_is_named_and_steps_on(self):
        command = self.masses(lacking="snapshots")
        case = ROOT / "configs/quick/three_sphere.yaml"
        sim = self.opened(case, self.folder / "run", set=SHORT | {"services.body.command": command})
        for steps in (0, 5):
            sim.step(steps)
            with self.assertRaisesRegex(copepod.CaseError, "body component Masses .*«snapshots».*adding_a_component"):
                sim.snapshot()
        sim.step(5)
        sim.write_checkpoint()
        sim.close()
        self.assertEqual(copepod.load(self.folder / "run").summary["steps"], 10)

    def test_a_pause_is_no_silence_and_who_dies_in_it_is_named(self):
        """Components that would take the coupler for lost after a second; then others resume the checkpoint."""
        impatient = [str(PROGRAMS / "body_service"), "--orphan-after", "1"]
        settings = {"services.transport": "ipc", "services.body.command": impatient}
        with copepod.Simulation(STROKE, self.folder / "whole") as whole:
            whole.step(40)
        sim = self.opened(STROKE, self.folder / "run", set=settings)
        sim.step(10)
        time.sleep(2.5)
        sim.step(10)
        sim.write_checkpoint()
        before = sim.snapshot()
        os.kill(services()["body"], signal.SIGKILL)
        time.sleep(1.0)
        for call in (sim.step, lambda: sim.restore(before)):
            with self.assertRaisesRegex(copepod.RunError, "The body component on host .* is gone") as raised:
                call()
            self.assertEqual(raised.exception.code, 69)
        with self.assertRaisesRegex(copepod.Error, "has failed"):
            sim.snapshot()
        sim.close()
        self.assertEqual(services(), {})
        with copepod.Simulation.resume(self.folder / "run", services=True) as resumed:
            self.assertEqual(resumed.steps, 20)
            resumed.step(20)
        digests = [copepod.load(self.folder / name).summary["digest"] for name in ("run", "whole")]
        self.assertEqual(*digests)

    def test_a_failure_of_the_coupler_leaves_services_to_return_to(self):
        """One that is frozen, too, is named, and ended."""
        with self.opened() as sim:
            sim.step(10)
            before = sim.snapshot()
            sim.actuators[0] = 1.0
            with self.assertRaisesRegex(copepod.RunError, "at step 10: .*moved by"):
                sim.step(100)
            sim.restore(before)
            sim.step(5)
            self.assertEqual(sim.steps, 15)
            os.kill(services()["fluid"], signal.SIGSTOP)
            with self.assertRaisesRegex(copepod.RunError, "at step 15: The fluid component on host .* is frozen"):
                sim.step()
        self.assertEqual(services(), {})

    def test_services_that_do_not_come_are_named_and_none_remains(self):
        answers = f"case $1 in --cap*) exec {PROGRAMS}/body_service --capabilities;; esac; "

        def body(script, **more):
            return {"services.transport": "ipc", "services.body.command": ["sh", "-c", answers + script, "sh"], **more}

        for settings, kind, message in (
            (body("echo error: no licence; exit 3"), copepod.RunError, "body service .* code 3; .*«no licence».$"),
            (
                body("exec sleep 60", **{"services.connect_deadline_s": 1}),
                copepod.RunError,
                "body .* not connect within 1",
            ),
            (
                {"services.transport": "ipc", "services.fluid.command": ["/no"]},
                copepod.CaseError,
                "/no cannot be started",
            ),
            ({"run.steps": -1}, copepod.CaseError, "run.steps"),
            ({"sweep": {"parameters": {"run.steps": [1, 2]}}}, copepod.CaseError, "is a sweep"),
            ({"output.wire": True, "services.transport": "ipc"}, copepod.CaseError, "output.wire"),
        ):
            start_s = time.monotonic()
            with self.subTest(message), self.assertRaisesRegex(kind, message):
                self.opened(set=settings)
            self.assertLess(time.monotonic() - start_s, 20)  # 1 s, but for the load of this machine
            self.assertEqual(services(), {})
        before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it
        self.addCleanup(signal.signal, signal.SIGINT, before)

        def interrupt():
            while "fluid" not in services():
                time.sleep(0.05)
            os.kill(os.getpid(), signal.SIGINT)

        thread = threading.Thread(target=interrupt)
        thread.start()
        start_s = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            self.opened(set=body("exec sleep 60"))
        self.assertLess(time.monotonic() - start_s, 20)
        thread.join()
        self.assertEqual(signal.set_wakeup_fd(-1), -1)

    def test_a_directory_that_is_not_free_is_refused_untouched(self):
        with self.opened(directory=self.folder / "run") as sim:
            sim.step(2)
            sim.write_checkpoint()
            logs = {path: path.read_text() for path in (self.folder / "run/logs").iterdir()}
            with self.assertRaisesRegex(copepod.CaseError, "in use"):
                copepod.Simulation.resume(self.folder / "run", services=True)
            self.assertEqual({path: path.read_text() for path in (self.folder / "run/logs").iterdir()}, logs)
            sim.step()
        shutil.rmtree(self.folder / "run/logs")
        with self.assertRaisesRegex(copepod.CaseError, "holds a run already"):
            self.opened(directory=self.folder / "run")
        self.assertEqual(list((self.folder / "run/logs").iterdir()), [])
        with self.assertRaisesRegex(copepod.CaseError, "nowhere/case.yaml"):
            copepod.Simulation.resume(self.folder / "nowhere", services=True)

    def test_services_that_the_caller_starts(self):
        """As a program in C does: it gives the settings where they connect."""
        endpoint, session = f"ipc://{self.folder}/coupler.ipc", "0123456789"
        connection = ["--endpoint", endpoint, "--session", session]
        own = []
        for role in ("fluid", "body"):
            command = [PROGRAMS / f"{role}_service", *connection, "--log-file", self.folder / f"{role}.log"]
            own.append(subprocess.Popen(command))
        with copepod.Simulation(STROKE, set=[f"--endpoint={endpoint}", f"--session={session}"]) as sim:
            start = sim.snapshot()
            sim.step(20)
            sim.restore(start)
            sim.step(30)
            position_m = sim.bodies.position_m
        self.assertEqual([process.wait(10) for process in own], [0, 0])
        with copepod.Simulation(STROKE) as sim:
            sim.step(30)
            numpy.testing.assert_array_equal(sim.bodies.position_m, position_m)
        soon = "services.connect_deadline_s=0.2"
        for words, code, message in (
            ([f"--endpoint={endpoint}"], 64, "--endpoint or --session is missing"),
            (["--session=1"], 64, "--endpoint or --session is missing"),
            (["--endpoint=nonsense", "--session=1"], 2, "nonsense"),
            ([f"--endpoint=tcp://0.0.0.0:{free_port()}", "--session=1"], 2, "needs keys"),
            ([f"--endpoint=tcp://127.0.0.1:{free_port()}", "--session=1", "--keys=/no.key"], 2, "/no.key"),
            ([f"--endpoint={endpoint}", "--session=1", soon], 74, "fluid and body component did not connect"),
            (["--endpoints=ipc:///a", "--session=1"], 64, "is missing"),
            (["--key=1"], 2, "--key"),
        ):
            with self.subTest(words), self.assertRaisesRegex(copepod.Error, message) as raised:
                copepod.Simulation(STROKE, set=words)
            self.assertEqual(raised.exception.code, code)


MISUSE = r"""
import ctypes, functools, sys, threading
print = functools.partial(print, file=sys.stderr)  # the library prints, too
library = ctypes.CDLL(sys.argv[1])
library.copepod_error.restype = ctypes.c_char_p
request, number = ctypes.create_string_buffer(200), ctypes.c_double()
words = [b"me", *(word.encode() for word in sys.argv[2:])]
argv = (ctypes.c_char_p * len(words))(*words)
def call(name, *arguments):
    code = getattr(library, "copepod_component_" + name)(*arguments)
    return "0" if code == 0 else str(code) + " " + library.copepod_error().decode()
def opened(role, features=b"shape:sphere", name=b"Mine", argc=len(words), argv=argv):
    return call("open", argc, argv, role, name, b"1.0", features)
def asked():
    return call("number", b"/step_s", ctypes.byref(number)), call("report_progress"), call("fail", 70, b"x (y). Z.")
print(call("next", request), *asked(), sep="\n")
print(opened(b"fluid", None), opened(b"pilot"), opened(b"fluid", b"\xff"), opened(b"fluid", name=b"\xff"), sep="\n")
print(opened(b"fluid", argc=0), opened(b"fluid", argc=-1), opened(b"fluid", argv=(ctypes.c_char_p * 9)()), sep="\n")
print(opened(b"fluid"), opened(b"fluid"), *asked(), call("fail", 1, b""), call("next", None), sep="\n")
def wait():
    while "another thread" in call("next", request):  # the main thread may be in a call
        pass
waiting = threading.Thread(target=wait)
if sys.argv[2] == "--endpoint":
    waiting.start()
    while "another thread" not in call("fail", 70, b"x (y). Z."):
        pass
    print(call("next", request), *asked(), sep="\n", flush=True)
    import os; os._exit(0)
import time; time.sleep(0.3)  # the request is there before it is asked for
print(call("next", request), int.from_bytes(request.raw[:8], "little"))
print(call("next", request), *asked(), sep="\n", flush=True)
"""


IDLE = r"""
import ctypes, sys
library = ctypes.CDLL(sys.argv[1])
def call(name, *arguments):
    assert getattr(library, "copepod_component_" + name)(*arguments) == 0, name
class Request(ctypes.Structure):
    _fields_ = [("kind", ctypes.c_int32), ("code", ctypes.c_int32), ("step", ctypes.c_int64)]
    _fields_ += [(name, ctypes.c_int64) for name in ("bodies", "loads", "actuators")] + [("text", ctypes.c_char_p)]
    _fields_ += [(str(number), ctypes.c_void_p) for number in range(9)]
words = [b"idle", *(word.encode() for word in sys.argv[2:])]
argv = (ctypes.c_char_p * len(words))(*words)
features = b"solver:external shape:sphere neglects:boundary"
call("open", len(words), argv, b"fluid", b"Idle", b"1.0", features)
request, number = Request(), ctypes.c_double()
while request.kind or request.text is None:
    call("next", ctypes.byref(request))
    if request.kind == 0:
        with open(sys.argv[0] + ".end", "w") as file:
            print(library.copepod_component_report_progress(), file=file)
        sys.exit(request.code)
    if request.kind == 1:
        call("report_progress")
        wrong = [b"a", b"", b"/~", b"/a", b"/bodies/99", b"/bodies/" + b"9" * 30, b"/\xff", b"/boundaries/0/kind"]
        paths = [(b"/bodies/2/radius_m", 4e-6), (b"/domain_cells/0", 7.0), *((path, None) for path in wrong)]
        for path, value in paths:
            code = library.copepod_component_number(path, ctypes.byref(number))
            assert code == (0 if value is not None else 64) and number.value == (value or number.value), path
"""


class CalledComponentTest(unittest.TestCase):
    def test_what_it_does_not_answer_ends_the_run(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "idle.py").write_text(IDLE)
            settings = {"run.steps": 20, "fluid.solver": "external", "fluid.density_kg_per_m3": 1360}
            settings |= {"fluid.kinematic_viscosity_m2_per_s": 7.36e-5, "fluid.domain_cells": [7, 7, 200]}
            fluid = [sys.executable, f"{folder}/idle.py", f"{PROGRAMS}/libcopepod.so"]
            with self.assertRaisesRegex(copepod.RunError, "The load on body 0 is not a finite number"):
                copepod.run(
                    ROOT / "configs/quick/vacuum.yaml", f"{folder}/run", set=settings, fluid=" ".join(fluid), quiet=True
                )
            self.assertEqual((Path(folder) / "idle.py.end").read_text(), "64\n")  # once it has ended

    def test_a_body_in_c_resumes(self):
        """It is pushed along x, so that its state matters."""
        ball = {"name": "ball", "radius_m": 2e-6, "mass_kg": 5e-14, "position_m": [0, 0, 0]}
        push = {"kind": "world_force", "body": "ball", "direction": [1, 0, 0]}
        push["signal"] = {"kind": "sinusoid", "amplitude_N": 1e-9, "period_steps": 30}
        case = {"case": "ball", "fluid": {"solver": "vacuum", "cell_size_m": 1e-6}, "step_s": 1e-9, "bodies": [ball]}
        case |= {"actuators": [push], "run": {"steps": 40}, "output": {"checkpoint": {"every_steps": 25}}}
        with tempfile.TemporaryDirectory() as folder:
            library = [f"-I{ROOT}/in_process", f"-L{PROGRAMS}", f"-Wl,-rpath,{PROGRAMS}", "-lcopepod"]
            source = ROOT / "examples/c/point_masses.c"
            subprocess.run(["cc", source, *library, "-o", f"{folder}/masses"], check=True)
            settings = {"body": f"{folder}/masses", "quiet": True}
            whole = copepod.run(case, f"{folder}/whole", **settings)
            shutil.copytree(f"{folder}/whole", f"{folder}/cut")
            (Path(folder) / "cut/summary.json").unlink()
            cut = copepod.run(case, f"{folder}/cut", resume=True, **settings)
            self.assertEqual(cut.summary["digest"], whole.summary["digest"])
            self.assertTrue(cut.trajectory.equals(whole.trajectory))

    def test_misuse_is_a_code_with_a_message(self):
        """Of a component that was opened never, wrongly, twice, by a second thread, and has ended."""
        before = [
            *["64 no component is open"] * 4,
            "64 an argument is NULL",
            "64 the role is neither",
            *["64 a text is not UTF-8"] * 2,
            *["64 argc is below 1"] * 2,
            "64 an argument is NULL",
            "0",
            "64 this process has a component already",
            *["64 no request waits"] * 3,
            "64 the code is neither 70 nor 73",
            "64 an argument is NULL",
        ]
        for words, after in (
            (["--capabilities"], ["0 0", "64 the component has ended", *["64 no request waits"] * 3]),
            (["--endpoint", "ipc:///nowhere", "--session", "s"], ["64 another thread is in a call"] * 4),
        ):
            command = [sys.executable, "-c", MISUSE, f"{PROGRAMS}/libcopepod.so", *words]
            ended = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
            lines = [
                line for line in ended.stderr.splitlines() if line.startswith(("0", "64 "))
            ]  # not those of the log
            self.assertEqual(len(lines), len(before + after), ended.stderr)
            for line, start in zip(lines, before + after, strict=True):
                self.assertTrue(line.startswith(start), f"{line} is not {start}")


class Fragile(three_spheres.ThreeSpheres):
    """Fails when its action is 2, if it is the second."""

    def act(self, action):
        if action == 2:
            self.sim.actuators[0] = 1.0
        else:
            super().act(action)


def spheres(kind=three_spheres.ThreeSpheres, episode=6):
    case, steps = three_spheres.stokes_case(three_spheres.FAR)
    return kind(case, three_spheres.FAR, steps, episode)


class EnvironmentTest(unittest.TestCase):
    def test_an_episode_follows_gymnasiums_rules(self):
        environment = spheres()
        with self.assertRaisesRegex(copepod.Error, "Call reset first"):
            environment.step(0)
        seen, info = environment.reset(seed=3, options={})
        self.assertEqual((list(seen[:2]), info), ([0, 0], {}))
        for number in range(6):
            seen, reward, terminated, truncated, info = environment.step(number % 2)
            self.assertEqual((type(reward), type(terminated), truncated), (float, bool, number == 5))
        with self.assertRaisesRegex(copepod.Error, "Call reset first"):
            environment.step(0)
        environment.close()

    def test_the_same_seed_and_actions_give_the_same_bits(self):
        environment = spheres()
        episodes = []
        for _ in range(2):
            first, _ = environment.reset(seed=1)
            draw = environment.np_random.random()
            episodes.append([draw, *first, *(x for action in (0, 1, 1, 0, 1) for x in environment.step(action)[0])])
        self.assertEqual(*episodes)
        environment.close()

    def test_several_agents_follow_pettingzoos_rules(self):
        """Parallel API: five dictionaries by agent, and no agent is left when the episode is over."""
        swimmers = two_swimmers.TwoSwimmers(actions_per_episode=8)
        episodes = []
        for _ in range(2):
            seen, infos = swimmers.reset(seed=1)
            self.assertEqual((list(seen), infos), (["left", "right"], {"left": {}, "right": {}}))
            rewards = []
            for number in range(8):
                self.assertEqual(swimmers.agents, ["left", "right"])
                answers = swimmers.step({"left": number % 2, "right": number % 2})
                self.assertEqual([list(each) for each in answers], 5 * [["left", "right"]])
                rewards.append(answers[1])
                self.assertEqual(set(answers[3].values()), {number == 7})
            self.assertEqual(swimmers.agents, [])
            with self.assertRaisesRegex(copepod.Error, "Call reset first"):
                swimmers.step({"left": 0, "right": 0})
            episodes.append(rewards)
        swimmers.close()
        self.assertEqual(*episodes)
        left, right = (sum(each[name] for each in episodes[0][4:]) for name in ("left", "right"))
        self.assertAlmostEqual(left, right, delta=1e-9)  # mirror images
        self.assertGreater(left, 1.01 * three_spheres.mobility_cycle(three_spheres.FAR))  # they help each other

    def test_one_that_diverges_ends_its_own_episode_only(self):
        together = copepod.Environments([lambda: spheres(Fragile)] * 3)
        alone = spheres()
        alone.reset(seed=5)
        together.reset(seed=5)
        expected, _, _, _, _ = alone.step(0)
        seen, rewards, terminated, truncated, info = together.step([0, 2, 0])
        self.assertEqual(list(truncated), [False, True, False])
        self.assertFalse(terminated.any())
        self.assertRegex(info["reason"][1], "moved by")
        for number in (0, 2):
            numpy.testing.assert_array_equal(seen[number], expected)
        expected, _, _, _, _ = alone.step(1)
        seen, rewards, terminated, truncated, info = together.step([1, 1, 1])  # the second is reset
        self.assertEqual((list(truncated), rewards[1], list(seen[1][:2]), info), ([False] * 3, 0.0, [0, 0], {}))
        numpy.testing.assert_array_equal(seen[0], expected)
        seen, rewards, _, _, _ = together.step([0, 0, 0])
        self.assertNotEqual(rewards[1], 0.0)
        together.close()
        alone.close()

    def test_each_of_several_has_a_seed_of_its_own(self):
        together = copepod.Environments([spheres] * 2)
        together.reset(seed=7)
        drawn = [environment.np_random.random() for environment in together.environments]
        self.assertEqual(drawn, [numpy.random.default_rng(seed).random() for seed in (7, 8)])
        together.close()

    def test_a_controller_that_rewinds_brings_a_triangle_to_its_target(self):
        path, strokes = steer_triangle.swim(9)
        distances_m = numpy.linalg.norm(path - path[0] - steer_triangle.TARGET, axis=1)
        self.assertGreater(distances_m[0], 1.2e-6)
        self.assertLess(distances_m[-1], 2.0e-8)
        self.assertGreater(len(set(strokes)), 2)

    def test_a_learner_finds_the_stroke_of_najafi_and_golestanian(self):
        environment, judge = spheres(episode=40), spheres(episode=0)
        Q, path = three_spheres.learn(environment, 400, seed=1)
        moved, actions = three_spheres.play_greedily(judge, Q)
        self.assertEqual(actions, 4 * [0, 1])
        self.assertEqual(moved, three_spheres.play_open_loop(judge, [0, 1, 0, 1]))
        theory = three_spheres.mobility_cycle(three_spheres.FAR)
        self.assertAlmostEqual(theory, 0.16502, delta=5e-6)
        self.assertAlmostEqual(moved, theory, delta=0.001 * theory)
        self.assertEqual(len(path), 401)
        environment.close()
        judge.close()

    def test_waiting_earns_nothing_in_stokes_flow(self):
        """One that can wait observes it, and learns not to."""
        case, steps = three_spheres.stokes_case(three_spheres.FAR)
        environment = three_spheres.ThreeSpheres(case, three_spheres.FAR, steps, 40, can_wait=True)
        environment.reset()
        answers = [environment.step(action)[:2] for action in (0, 2, 2, 2, 1)]
        self.assertEqual([list(seen[:3]) for seen, _ in answers], [[1, 0, n] for n in (0, 1, 2, 2)] + [[1, 1, 0]])
        numpy.testing.assert_allclose([reward for _, reward in answers[1:4]], 0.0, atol=1e-3)
        Q, _ = three_spheres.learn(environment, 1500, seed=1)
        environment.actions_per_episode = 0
        moved, actions = three_spheres.play_greedily(environment, Q)
        self.assertNotIn(2, actions)
        self.assertAlmostEqual(moved, three_spheres.mobility_cycle(three_spheres.FAR), delta=2e-4)
        environment.close()


if __name__ == "__main__":
    unittest.main()
