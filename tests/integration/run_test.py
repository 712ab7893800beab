"""Whole runs with the real coupler, fluid service and body service."""

import csv
import json
import math
import os
import signal
import socket
import time
import unittest
from pathlib import Path

import h5py

from copepod_session import ROOT, CommandTest

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
QUICK = ROOT / "configs/quick/three_sphere.yaml"
VACUUM = ROOT / "configs/quick/vacuum.yaml"
SHORT = ("--set", "run.steps=300", "--set", "output.fields.mean_over_steps=[0, 0]")
RUN = "runs/quick_three_sphere"


FALLING_BALL = """
case: falling_ball
fluid: {solver: external, density_kg_per_m3: 1000, kinematic_viscosity_m2_per_s: 1.0e-4}
step_s: 1.0e-9
bodies:
  - {name: ball, shape: sphere, radius_m: 4.0e-6, mass_kg: 5.0e-13, position_m: [0, 0, 0], motion: free}
actuators:
  - {kind: world_force, body: ball, direction: [0, 0, -1], signal: {kind: constant, amplitude_N: 1.0e-9}}
coupling: {scheme: serial_explicit, load_averaging: none}
run: {steps: 400}
output: {trajectory: {every_steps: 100}}
"""


class RealRun(CommandTest):
    programs = PROGRAMS

    def finish(self, *arguments):
        """Summary of a run that must finish."""
        session = self.start("run", *arguments, "--out", "out")
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        self.assert_nothing_left(session)
        summary = json.loads((self.folder / "out/summary.json").read_text())
        (self.folder / "out").rename(self.folder / f"out_{time.monotonic_ns()}")
        return summary

    def start_quick_run(self, *arguments):
        """The quick case with its fields off, after its start."""
        session = self.start("run", QUICK, "--set", "output.fields.mean_over_steps=[0, 0]", *arguments)
        session.wait_for("copepod: step 0 of")
        return session


FOREIGN_MPIRUN = """#!/bin/sh
# Starts programs that do not find each other, like the mpirun of an MPI with which they were not built.
ranks=$2; shift 3
while [ $((ranks -= 1)) -ge 0 ]; do "$@" & done
wait
"""


class Finishing(RealRun):
    def test_modules_of_the_user_do_not_hide_those_of_the_command(self):
        (self.folder / "google").mkdir()
        for file in ("google/__init__.py", "enum.py"):
            (self.folder / file).write_text("")
        for arguments in (
            ("check", VACUUM),
            ("conformance", "--role", "body", "--only", "handshake", "--quick", "--", PROGRAMS / "body_service"),
        ):
            session = self.start(*arguments, environment={"PYTHONPATH": str(self.folder)})
            self.assert_ends(session, 0, timeout_s=100)

    def test_ranks_find_each_other_whichever_mpirun_comes_first_in_path(self):
        (self.folder / "mpirun").write_text(FOREIGN_MPIRUN)
        (self.folder / "mpirun").chmod(0o755)
        session = self.start(
            "run", QUICK, *SHORT, "--ranks", "2", "--out", "out", environment={"PATH": f"{self.folder}:/usr/bin:/bin"}
        )
        self.assert_ends(session, 0, timeout_s=100)
        self.assertEqual(json.loads((self.folder / "out/summary.json").read_text())["ranks"], 2)

    def test_vacuum_run_writes_everything_it_promises(self):
        session = self.start("run", VACUUM, "--out", "out")
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        for name in (
            "case.yaml",
            "provenance.json",
            "trajectory.csv",
            "cycles.csv",
            "summary.json",
            "logs/coupler.log",
        ):
            self.assertTrue((self.folder / "out" / name).exists(), name)
        self.assertEqual(json.loads((self.folder / "out/provenance.json").read_text())["status"], "finished")
        self.assertIn("finished, results in out", "".join(session.stdout))

    def test_same_digest_on_any_number_of_ranks(self):
        for precision in ("double", "single"):
            digests = {
                self.finish(QUICK, *SHORT, "--ranks", str(ranks), "--set", f"fluid.precision={precision}")["digest"]
                for ranks in (1, 2, 3, 4)
            }
            self.assertEqual(len(digests), 1, f"{precision}: {digests}")

    def test_resolved_case_gives_the_same_run(self):
        first = self.finish(QUICK, *SHORT)
        resolved = next(self.folder.glob("out_*")) / "case.yaml"
        self.assertEqual(self.finish(resolved)["digest"], first["digest"])

    def test_fluid_can_be_replaced_by_another_command(self):
        replaced = self.finish(QUICK, *SHORT, "--ranks", "1", "--fluid", PROGRAMS / "fluid_service")
        self.assertEqual(replaced["digest"], self.finish(QUICK, *SHORT, "--ranks", "1")["digest"])

    def test_fluid_component_in_python_lets_a_ball_fall_with_stokes_speed(self):
        (self.folder / "case.yaml").write_text(FALLING_BALL)
        fluid = f"/usr/bin/python3 {ROOT}/examples/python/stokes_drag_fluid.py"
        self.finish("case.yaml", "--fluid", fluid)
        trajectory = next(self.folder.glob("out_*")) / "trajectory.csv"
        *_, last = csv.DictReader(trajectory.read_text().splitlines())
        stokes_m_per_s = -1e-9 / (6 * math.pi * 0.1 * 4e-6)  # relaxation time m/(6 pi eta r) = 66 steps
        self.assertAlmostEqual(float(last["vz_m_per_s"]) / stokes_m_per_s, 1.0, delta=0.01)

    def test_check_tells_the_key_figures(self):
        session = self.start("check", QUICK)
        self.assertEqual(session.end(), 0, "".join(session.stderr))
        self.assertIn("relaxation time", "".join(session.stdout))

    def test_report_reads_a_real_run(self):
        self.finish(QUICK, *SHORT, "--set", "output.fields.mean_over_steps=[100, 300]")
        directory = next(self.folder.glob("out_*"))
        session = self.start("report", directory, "--out", "report")
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        self.assertTrue((self.folder / "report/quick_three_sphere_mean_flow.png").exists())


class Resuming(RealRun):
    LENGTH = ("--set", "run.steps=3000", "--set", "output.fields.mean_over_steps=[0, 0]")

    def summary_of(self, directory):
        return json.loads((self.folder / directory / "summary.json").read_text())

    def test_sigterm_leaves_a_checkpoint_from_which_the_run_ends_as_if_nothing_had_happened(self):
        undisturbed = self.finish(QUICK, *self.LENGTH)
        session = self.start("run", QUICK, *self.LENGTH, "--out", "stopped")
        session.wait_for("copepod: step 0 of")
        session.process.send_signal(signal.SIGTERM)
        self.assertEqual(session.end(), 143, "".join(session.stderr))
        self.assert_nothing_left(session)
        self.assertIn("--out stopped", session.last_line)
        self.assertTrue(session.last_line.endswith("--resume"), session.last_line)
        session = self.start("run", QUICK, *self.LENGTH, "--out", "stopped", "--ranks", "1", "--resume")
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        self.assertEqual(self.summary_of("stopped")["digest"], undisturbed["digest"])

    def test_killed_rank_is_restarted_from_the_last_checkpoint(self):
        undisturbed = self.finish(QUICK, *self.LENGTH)
        checkpoints = ("--set", "output.checkpoint.every_steps=200")
        session = self.start("run", QUICK, *self.LENGTH, *checkpoints, "--out", "killed", "--restarts", "1")
        session.wait_for_file("killed/checkpoints/*/manifest.json")
        session.kill(signal.SIGKILL, "fluid", "1")
        session.wait_for("starting again from the last checkpoint")
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        self.assertEqual(self.summary_of("killed")["digest"], undisturbed["digest"])
        self.assert_nothing_left(session)


class InOneProcess(RealRun):
    """Coupler, bodies and fluid in one process, the fluid's ranks as threads."""

    IN_PROCESS = ("--set", "services.transport=in_process")
    NO_FIELDS = ("--set", "output.fields.mean_over_steps=[0, 0]")

    def test_digest_and_fields_are_those_of_services_on_any_number_of_ranks(self):
        fields = ("--set", "output.fields.mean_over_steps=[100, 300]", "--set", "output.trace=true")
        expected = self.finish(QUICK, *SHORT, *fields)
        for ranks in (1, 2, 3):
            summary = self.finish(QUICK, *SHORT, *fields, *self.IN_PROCESS, "--ranks", ranks)
            self.assertEqual((summary["digest"], summary["ranks"]), (expected["digest"], ranks))
        of_services, *in_process = [mean_of(path) for path in sorted(self.folder.glob("out_*/fields.h5"))]
        self.assertEqual([fields == of_services for fields in in_process], [True] * 3)
        names = sorted(path.name for path in max(self.folder.glob("out_*")).glob("trace/*/*"))
        self.assertEqual(names, ["coupler.rank0.rec", *(f"fluid.rank{rank}.rec" for rank in range(3))])

    def test_checkpoints_of_services_and_of_one_process_are_the_same(self):
        case = (QUICK, *self.NO_FIELDS, "--set", "output.checkpoint.every_steps=300")
        undisturbed = self.finish(*case, "--set", "run.steps=900")
        for first, then in (((), self.IN_PROCESS), (self.IN_PROCESS, ())):
            self.assert_ends(self.start("run", *case, *first, "--set", "run.steps=600", "--out", "out"), 0)
            resumed = self.finish(*case, *then, "--set", "run.steps=900", "--resume")
            self.assertEqual((resumed["digest"], resumed["resumed_from_step"]), (undisturbed["digest"], 300))

    def test_signals_end_it_with_their_codes_after_a_checkpoint(self):
        for number, code in ((signal.SIGHUP, 129), (signal.SIGINT, 130), (signal.SIGTERM, 143)):
            session = self.start_quick_run(*self.IN_PROCESS, "--out", f"stopped_{code}")
            session.process.send_signal(number)
            self.assert_ends(session, code)
            self.assertEqual(len(list(self.folder.glob(f"stopped_{code}/checkpoints/*/manifest.json"))), 1)

    def test_a_rank_that_fails_is_named_as_that_of_a_service(self):
        session = self.start("run", QUICK, *SHORT, *self.IN_PROCESS, "--set", "fluid.body_force_N_per_m3=[0, 0, 1e16]")
        self.assert_ends(session, 70)
        self.assertRegex(
            session.last_line, "fluid service on host .*, rank [01], at step [0-9]+: the flow diverged at cell"
        )

    def test_a_body_that_outruns_the_lattice_in_the_last_step_ends_the_run(self):
        """Its surface moves at 0.6 cells per step, faster than sound, 0.577; a vacuum has no such limit."""
        fluid = {"density_kg_per_m3": 1, "kinematic_viscosity_m2_per_s": 0.1, "cell_size_m": 1}
        torque = {"kind": "constant", "amplitude_N_m": 384}  # of a moment of inertia of 2560
        case = {
            "case": "top",
            "fluid": {"solver": "lattice_boltzmann", "domain_cells": [16, 16, 16], **fluid},
            "step_s": 1,
            "bodies": [{"name": "top", "radius_m": 4, "mass_kg": 400, "position_m": [8, 8, 8]}],
            "actuators": [{"kind": "world_torque", "body": "top", "direction": [0, 0, 1], "signal": torque}],
            "run": {"steps": 1},
        }
        (self.folder / "top.yaml").write_text(json.dumps(case))
        session = self.start("run", "top.yaml", *self.IN_PROCESS, "--out", "out")
        self.assert_ends(session, 70)
        self.assertRegex(session.last_line, "at step 0: .*body 'top' has a surface that moves at 0.6 m/s")
        vacuum = self.start("run", "top.yaml", *self.IN_PROCESS, "--set", "fluid.solver=vacuum", "--out", "vacuum")
        self.assert_ends(vacuum, 0)


class OverTcp(RealRun):
    """Key files are made per run and role; a component without the right one is rejected."""

    LENGTH = ("--set", "run.steps=300", "--set", "output.fields.mean_over_steps=[0, 0]", "--ranks", "1")

    def transport(self, host="127.0.0.1"):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            return "--set", f"services.transport=tcp://{host}:{free.getsockname()[1]}"

    def fluid_with(self, change):
        """Command of a fluid service whose arguments ("$@") a line of bash changes first."""
        script = self.folder / "fluid.sh"
        script.write_text(f'#!/bin/bash\n{change}\nexec {PROGRAMS}/fluid_service "$@"\n')
        script.chmod(0o755)
        return "--fluid", script

    def test_keys_are_private_never_on_a_command_line_and_gone_with_the_run(self):
        session = self.start("run", QUICK, "--ranks", "1", *self.transport(), "--out", "out")
        session.wait_for("copepod: step 0 of")
        folder = self.folder / "out/.keys"
        self.assertEqual(folder.stat().st_mode & 0o777, 0o700)
        files = sorted(folder.glob("*.key"))
        self.assertEqual([file.name for file in files], ["body.key", "coupler.key", "fluid.key"])
        words = {word for file in files for word in file.read_text().split() if len(word) == 40}
        self.assertEqual(len(words), 6)
        for pid in session.processes():
            command = Path(f"/proc/{pid}/cmdline").read_text() + Path(f"/proc/{pid}/environ").read_text()
            self.assertFalse([word for word in words if word in command])
        self.assertEqual({file.stat().st_mode & 0o777 for file in files}, {0o600})
        session.process.send_signal(signal.SIGINT)
        self.assert_ends(session, 130)
        self.assertFalse(folder.exists())

    def test_digest_is_that_of_a_run_over_ipc(self):
        over_ipc = self.finish(QUICK, *self.LENGTH)
        for host in ("127.0.0.1", "localhost"):
            self.assertEqual(self.finish(QUICK, *self.LENGTH, *self.transport(host))["digest"], over_ipc["digest"])

    def test_addresses_on_which_the_coupler_cannot_listen_are_refused_by_check_too(self):
        reasons = {
            "192.0.2.1": "cannot listen on tcp://192.0.2.1:",
            "no.such.name": "(no.such.name: ",
            "*": "components cannot connect to all interfaces",
        }
        for host, reason in reasons.items():
            for command in ("run", "check"):
                session = self.start(command, QUICK, *self.transport(host))
                self.assert_ends(session, 2)
                self.assertIn(reason, "".join(session.stderr))

    def test_fluid_with_the_key_of_the_body_is_refused(self):
        fluid = self.fluid_with('set -- "${@//fluid.key/body.key}"')
        session = self.start("run", QUICK, *self.LENGTH, *self.transport(), *fluid)
        self.assert_ends(session, 65)
        self.assertIn("it holds the key of the body component", session.last_line)

    def test_fluid_without_a_key_is_turned_away(self):
        fluid = self.fluid_with(
            "arguments=(); for word; do case $word in --keys | *.key) ;; "
            '*) arguments+=("$word") ;; esac; done; set -- "${arguments[@]}"'
        )
        session = self.start("run", QUICK, *self.LENGTH, *self.transport(), *fluid)
        self.assert_ends(session, 65)
        self.assertIn("turned this component away", session.last_line)


def mean_of(path):
    """{name: bytes} of the mean fields in a file."""
    with h5py.File(path) as file:
        return {name: values[:].tobytes() for name, values in file["mean"].items()}


class Failing(RealRun):
    def assert_loss(self, session, component, rank):
        self.assert_ends(session, 69)
        self.assertRegex(
            session.last_line,
            f"^copepod: {component} on host {os.uname().nodename}, rank {rank}, (at|after) step [0-9]+: ",
        )
        provenance = json.loads((self.folder / RUN / "provenance.json").read_text())
        self.assertEqual((provenance["status"], provenance["exit_code"]), ("failed", 69))

    def test_killed_coupler(self):
        session = self.start_quick_run()
        session.kill(signal.SIGKILL, "coupler")
        self.assert_loss(session, "coupler", "0")

    def test_killed_body_service(self):
        session = self.start_quick_run()
        session.kill(signal.SIGKILL, "body")
        self.assert_loss(session, "body service", "0")

    def test_killed_mpirun(self):
        session = self.start_quick_run()
        session.kill(signal.SIGKILL, "fluid")
        self.assert_loss(session, "fluid service", "0-1")

    def test_killed_fluid_rank(self):
        for rank in ("0", "1"):
            session = self.start_quick_run("--out", RUN if rank == "0" else f"{RUN}-2")
            session.kill(signal.SIGKILL, "fluid", rank)
            self.assert_loss(session, "fluid service", rank)

    def test_frozen_body_service_is_reported_within_seconds(self):
        session = self.start_quick_run()
        session.kill(signal.SIGSTOP, "body")
        self.assert_ends(session, 69)
        self.assertIn("body service", session.last_line)
        self.assertIn("frozen", session.last_line)

    def test_frozen_fluid_rank_is_reported_by_its_number(self):
        session = self.start_quick_run()
        session.kill(signal.SIGSTOP, "fluid", "0")
        self.assert_ends(session, 69)
        self.assertIn("fluid service", session.last_line)
        self.assertIn("rank 0", session.last_line)

    def test_ctrl_c(self):
        session = self.start_quick_run()
        os.killpg(session.process.pid, signal.SIGINT)
        self.assert_ends(session, 130)
        provenance = json.loads((self.folder / RUN / "provenance.json").read_text())
        self.assertEqual(provenance["exit_code"], 130)

    def test_killed_command_takes_everything_along(self):
        session = self.start_quick_run()
        session.process.kill()
        session.end()
        session.wait_until_clean()

    def test_bad_case_starts_nothing(self):
        session = self.start("run", QUICK, "--set", "fluid.relaxation_time=0.3")
        self.assert_ends(session, 2)
        self.assertIn("error:", "".join(session.stderr))
        self.assertFalse((self.folder / "runs").exists())

    def test_file_that_is_no_text_is_refused_with_a_reason(self):
        (self.folder / "case.yaml").write_bytes(b'case: "\\\xba"\n')
        session = self.start("run", "case.yaml")
        self.assert_ends(session, 2)
        self.assertIn("case.yaml:1: error: this is not valid YAML", "".join(session.stderr))

    def test_more_ranks_than_the_machine_can_bear_are_refused(self):
        session = self.start("run", QUICK, "--ranks", str(33 * len(os.sched_getaffinity(0))))
        self.assert_ends(session, 2)
        self.assertIn("fluid ranks are too many (each is a process", session.last_line)
        self.assertFalse((self.folder / "runs").exists())

    def test_diverging_case_names_solver_and_step(self):
        session = self.start("run", QUICK, *SHORT, "--set", "fluid.body_force_N_per_m3=[0, 0, 1e16]")
        self.assertEqual(session.end(timeout_s=60), 70, "".join(session.stderr))
        self.assertRegex(session.last_line, "fluid service on host .*, rank [0-9]+, at step [0-9]+")
        self.assert_nothing_left(session)


if __name__ == "__main__":
    unittest.main()
