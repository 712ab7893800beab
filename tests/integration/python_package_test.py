"""`import copepod`: cases, checks, runs and results from Python."""

import contextlib
import importlib.util
import json
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
import warnings
from pathlib import Path

from copepod_session import ROOT, CommandTest, wait_until

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
PACKAGES = ("jsonschema", "pandas", "xarray", "yaml")
if any(importlib.util.find_spec(name) is None for name in PACKAGES):
    raise unittest.SkipTest(f"{', '.join(PACKAGES)} are not installed (deploy/copepod setup --ci)")

sys.path.insert(0, str(ROOT / "python"))
os.environ["COPEPOD_BIN_DIR"] = str(PROGRAMS)

import jsonschema  # noqa: E402

import copepod  # noqa: E402
from copepod_run.errors import Stop  # noqa: E402
from copepod_run.plan import plan_of  # noqa: E402

QUICK = ROOT / "configs/quick/three_sphere.yaml"
VACUUM = ROOT / "configs/quick/vacuum.yaml"
ROTATOR = ROOT / "configs/examples/triangular_rotator.yaml"
SHORT = {"run.steps": 8000, "services.transport": "in_process"}


def environment(*folders):
    """With these folders in front of those where this test finds its modules."""
    path = [*map(str, folders), str(ROOT / "python"), str(ROOT / "deploy")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path)}


@contextlib.contextmanager
def temporary_folder():
    with tempfile.TemporaryDirectory(prefix="copepod_test_") as folder:
        yield Path(folder).resolve()


class Schema(unittest.TestCase):
    def test_allows_every_case_of_ours(self):
        schema = json.loads((ROOT / "configs/schema/case.schema.json").read_text())
        validator = jsonschema.Draft202012Validator(schema)
        checked = 0
        for file in sorted([*(ROOT / "configs").rglob("*.yaml"), *(ROOT / "examples").rglob("*.yaml")]):
            case = copepod.Case.load(file).to_dict()
            if "case" in case:
                self.assertEqual([error.message for error in validator.iter_errors(case)], [], file)
                checked += 1
        self.assertGreater(checked, 50)
        self.assertFalse(validator.is_valid({**case, "fluid": {"solver": "lattice_boltzman"}}))


class Errors(unittest.TestCase):
    def test_survive_a_process_pool(self):
        for error in (copepod.RunError("it failed", 70, "runs/a"), copepod.CaseError("it is wrong", 2)):
            again = pickle.loads(pickle.dumps(error))
            self.assertEqual((type(again), str(again), vars(again)), (type(error), str(error), vars(error)))


class Cases(unittest.TestCase):
    def test_key_paths_reach_items_by_index_and_by_name(self):
        case = copepod.Case.load(ROTATOR)
        case["swimmers.rotator.arms.1.drive.signal.lag_deg"] = 90
        self.assertEqual(case["swimmers.0.arms.1.drive.signal"]["lag_deg"], 90)
        self.assertIn("swimmers.0.beads.C.radius_m", case)
        self.assertNotIn("swimmers.0.beads.D", case)
        del case["swimmers.0.beads.C"]
        self.assertEqual(len(case["swimmers.0.beads"]), 2)

    def test_setting_a_key_makes_what_is_missing_above_it(self):
        case = copepod.Case({"case": "new"})
        case["output.fields.every_steps"] = 10
        case["bodies.0.name"] = "ball"
        case["bodies.1"] = {"name": "box"}
        self.assertEqual(
            case.to_dict(),
            {"case": "new", "output": {"fields": {"every_steps": 10}}, "bodies": [{"name": "ball"}, {"name": "box"}]},
        )

    def test_key_that_is_not_there_is_refused_with_the_nearest_one(self):
        case = copepod.Case.load(ROTATOR)
        for path, answer in (
            ("swimmers.0.armes", "Did you mean arms?"),
            ("swimmers.3", "a list of 1"),
            ("run.steps.first", "it is 24000"),
        ):
            for access in (lambda: case[path], lambda: case.__delitem__(path)):
                with self.assertRaisesRegex(KeyError, answer.replace("?", r"\?")):
                    access()
        with self.assertRaisesRegex(KeyError, "it is 24000"):
            case["run.steps.first"] = 1

    def test_copies_are_independent(self):
        case = copepod.Case.load(ROTATOR)
        other = case.copy()
        other["swimmers.0.beads.0.radius_m"] = 1.0
        self.assertEqual(case["swimmers.0.beads.0.radius_m"], 4e-6)
        self.assertNotEqual(case, other)

    def test_values_of_numpy_become_those_of_python_and_others_are_refused(self):
        import numpy

        case = copepod.Case()
        case["a"] = {"b": (numpy.float64(0.1), numpy.arange(2)), "c": Path("x")}
        self.assertEqual(json.dumps(case.to_dict()), '{"a": {"b": [0.1, [0, 1]], "c": "x"}}')
        with self.assertRaisesRegex(copepod.CaseError, "a.b.0 cannot be"):
            case["a.b"] = [object()]

    def test_every_case_is_the_same_after_it_was_loaded_and_saved(self):
        with temporary_folder() as folder:
            for path in sorted((ROOT / "configs").glob("[qes]*/*.yaml")):
                if path.name == "campaign.yaml":
                    continue
                copy = folder / "case.yaml"
                copepod.Case.load(path).save(copy)
                with self.subTest(path.name):
                    self.assertEqual(plan_of(copy).case, plan_of(path).case)

    def test_yaml_is_read_as_the_coupler_reads_it(self):
        with temporary_folder() as folder:
            path = folder / "case.yaml"
            path.write_text(
                "a: 1e-6\nb: no\nc: &x {d: 010, e: 1:30}\nf: {<<: *x, d: '1'}\ng: .5\nh: ~\ni: 2020-01-01\n"
            )
            case = copepod.Case.load(path)
            expected = {"a": 1e-6, "b": "no", "c": {"d": 10, "e": "1:30"}, "f": {"d": "1", "e": "1:30"}}
            self.assertEqual(case.to_dict(), {**expected, "g": 0.5, "h": None, "i": "2020-01-01"})
            case.save(path)
            self.assertEqual(copepod.Case.load(path), case)

    def test_file_that_is_not_a_case_is_refused(self):
        with temporary_folder() as folder:
            path = folder / "case.yaml"
            for text, reason in (("a: 1\na: 2\n", "«a» appears twice"), ("- 1\n", "not a case"), ("a: [\n", "line 2")):
                path.write_text(text)
                with self.assertRaisesRegex(copepod.CaseError, reason):
                    copepod.Case.load(path)
            with self.assertRaisesRegex(copepod.CaseError, "No such file"):
                copepod.Case.load(folder / "none.yaml")

    def test_the_coupler_and_python_refuse_the_same_files(self):
        text = (ROOT / "configs/quick/vacuum.yaml").read_text()
        kinds = {
            "as it is": (text.encode(), True),
            "byte-order mark": (b"\xef\xbb\xbf" + text.encode(), True),
            "UTF-16": (text.encode("utf-16"), False),
            "two documents": (f"{text}\n---\n{text}".encode(), False),
            "too small": (re.sub(r"stiffness_N_per_m: \S+", "stiffness_N_per_m: 1.7e-400", text).encode(), False),
            "too large": (re.sub(r"stiffness_N_per_m: \S+", "stiffness_N_per_m: 1.7e400", text).encode(), False),
        }
        for kind, (content, is_good) in kinds.items():
            with self.subTest(kind), temporary_folder() as folder:
                path = folder / "case.yaml"
                path.write_bytes(content)
                if is_good:
                    plan_of(path)
                    copepod.Case.load(path)
                else:
                    self.assertRaises(Stop, plan_of, path)
                    self.assertRaises(copepod.CaseError, copepod.Case.load, path)

    def test_names_that_look_like_numbers_are_refused_where_they_are_ambiguous_and_stay_texts_in_tables(self):
        case = copepod.Case({"bodies": [{"name": "1", "x": 0}, {"name": "b", "x": 0}, {"name": "2", "x": 0}]})
        with self.assertRaisesRegex(KeyError, "ambiguous"):
            case["bodies.1.x"] = 3
        case["bodies.2.x"] = 3
        with temporary_folder() as folder:
            (folder / "results.csv").write_text("case,swimmer,u,note\n007,NA,1.5,\n1e3,null,,x\n")
            table = copepod.Campaign(folder).results
            self.assertEqual(table["case"].tolist(), ["007", "1e3"])
            self.assertEqual(table["swimmer"].tolist(), ["NA", "null"])
            self.assertEqual(table["u"].isna().tolist(), [False, True])

    def test_files_that_a_case_names_are_still_found_from_elsewhere(self):
        with temporary_folder() as folder:
            (folder / "case.yaml").write_text("signal: {kind: table, file: waves/one.csv}\n")
            case = copepod.Case.load(folder / "case.yaml")
            self.assertEqual(case["signal.file"], str(folder / "waves/one.csv"))


class PackageTest(CommandTest):
    programs = PROGRAMS

    def setUp(self):
        super().setUp()
        warnings.simplefilter("error", copepod.CaseWarning)

    def run_of(self, case, name="out", **arguments):
        return copepod.run(case, self.folder / name, quiet=True, **arguments)

    def assert_nothing_runs(self):
        for path in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                self.assertNotIn(str(self.folder), path.read_bytes().decode(errors="replace"))
            except OSError:
                pass


class Checks(PackageTest):
    def test_figures_and_warnings_of_a_good_case(self):
        found = copepod.check(QUICK, set={"run.steps": 12000}, ranks=50)
        self.assertEqual((found.name, found.steps, found.problems), ("quick_three_sphere", 12000, []))
        self.assertEqual(found.figures["relaxation time"][:5], "0.666")
        self.assertIn("50 fluid ranks share", "".join(found.warnings))
        self.assertIn("relaxation time", str(found))

    def test_bad_case_raises_all_its_errors_without_our_temporary_file(self):
        for call in (copepod.check, copepod.run):
            with self.assertRaises(copepod.CaseError) as caught:
                call({"case": "x", "run": {"stps": 3}})
            self.assertIn("key 'stps' is unknown", str(caught.exception))
            self.assertIn("fluid.solver is missing", str(caught.exception))
            self.assertNotIn("/", str(caught.exception))
            self.assertEqual(caught.exception.code, 2)

    def test_arguments_are_refused_in_the_terms_of_python(self):
        self.run_of(VACUUM, set={"run.steps": 10})
        for arguments, reason in (
            ({"ranks": -3}, "^--ranks: «-3» is not a valid rank count"),
            ({"out": self.folder / "out"}, "Continue with resume=True, or choose another out."),
            ({"set": {"run.nix": 3}}, "run.nix=3: error: key 'nix' is unknown"),
        ):
            with self.assertRaisesRegex(copepod.CaseError, reason):
                copepod.run(VACUUM, quiet=True, **arguments)


class Runs(PackageTest):
    def test_results_are_tables(self):
        seen = []
        run = self.run_of(copepod.Case.load(ROTATOR), set=SHORT, on_progress=seen.append)
        self.assertEqual((run.status, run.summary["steps"], run.case["run.steps"]), ("finished", 8000, 8000))
        self.assertEqual((seen[-1].step, seen[-1].steps, seen[-1].share), (8000, 8000, 1.0))
        self.assertEqual(list(run.trajectory.index.names), ["body", "step"])
        self.assertEqual(len(run.trajectory), 3 * 401)
        one = run.trajectory.loc["rotator.A"]
        self.assertAlmostEqual(one.loc[4000, "time_s"], 4000 * 7.5e-10)
        rows = (run.directory / "trajectory.csv").read_text().splitlines()
        self.assertEqual(one.loc[8000, "z_m"], float(rows[-3].split(",")[5]))
        self.assertEqual(list(run.cycles.index), [("rotator", 0), ("rotator", 1)])
        self.assertEqual(run.cycles["start_step"].tolist(), [0, 4000])
        kinematics = run.summary["swimmers"][0]["kinematics"]
        self.assertEqual(run.cycles.loc[("rotator", 1), "rotation_y_rad"], kinematics["rotation_rad"][1])
        self.assertIn("rotation in a cycle", str(run))
        self.assertIn("finished", repr(copepod.load(run.directory)))

    def test_flow_without_bodies_has_case_fields_and_report(self):
        run = self.run_of(ROOT / "configs/validation/taylor_green.yaml")
        self.assertEqual((run.case["fluid.collision"], len(run.trajectory)), ("trt", 0))
        self.assertEqual(run.fields["velocity_m_per_s"].shape, (3, 4, 32, 32, 3))
        self.assert_ends(self.start("report", run.directory), 0, timeout_s=60)
        self.assertTrue((run.directory / "report/taylor_green_flow.png").is_file())

    def test_follow_waits_for_a_run_that_is_about_to_start(self):
        out = self.folder / "later"
        start = threading.Timer(0.5, lambda: copepod.run(VACUUM, out, set=SHORT, quiet=True))
        self.addCleanup(start.join)
        start.start()
        self.assertEqual(next(copepod.follow(out)).step, 0)
        with self.assertRaisesRegex(copepod.Error, "is neither a run nor a campaign"):
            next(copepod.follow(self.folder / "never", wait_s=0.1))

    def test_samples_of_the_callback_and_of_follow_are_those_of_the_trajectory(self):
        own = []
        run = self.run_of(ROTATOR, set=SHORT, on_sample=lambda sample: own.append(sample))
        for samples in (own, list(copepod.follow(run))):
            self.assertEqual([sample.step for sample in samples], list(range(0, 8001, 20)))
            for sample in samples[::50]:
                frame = run.trajectory.xs(sample.step, level="step")
                self.assertTrue(frame.equals(sample.bodies))
                self.assertEqual(sample.time_s, frame["time_s"].iloc[0])

    def test_exception_in_a_callback_stops_the_run_which_resumes_to_the_same_digest(self):
        before = signal.getsignal(signal.SIGINT)

        def stop_at_half(progress):
            if progress.share > 0.2:
                raise ZeroDivisionError("mine")

        long = {"run.steps": 12000, "output.trajectory.every_steps": 1000}
        with self.assertRaisesRegex(ZeroDivisionError, "mine"):
            self.run_of(VACUUM, set=long, on_progress=stop_at_half)
        self.assert_nothing_runs()
        self.assertEqual(signal.getsignal(signal.SIGINT), before)
        half = copepod.load(self.folder / "out")
        self.assertEqual(half.status, "stopped")
        self.assertGreater(len(half.trajectory), 0)
        self.assertGreater(half.summary["steps"], 2400)
        resumed = self.run_of(VACUUM, set=long, resume=True)
        whole = self.run_of(VACUUM, "whole", set=long)
        self.assertEqual(resumed.summary["digest"], whole.summary["digest"])
        self.assertTrue(resumed.trajectory.equals(whole.trajectory))

    def test_interrupt_stops_the_run_and_says_how_to_continue(self):
        script = (
            "import copepod, signal\n"
            f"try:\n    copepod.run({str(VACUUM)!r}, 'out', set={{'run.steps': 10**7}},\n"
            "                on_progress=lambda progress: print(progress.step, flush=True))\n"
            "except KeyboardInterrupt as problem:\n"
            "    print(*problem.__notes__, copepod.load('out').status, signal.getsignal(signal.SIGINT))\n"
        )
        started = subprocess.Popen(
            [sys.executable, "-c", script], cwd=self.folder, env=environment(), stdout=subprocess.PIPE, text=True
        )
        self.addCleanup(started.stdout.close)
        self.addCleanup(started.wait)
        self.addCleanup(started.kill)
        started.stdout.readline()
        self.assertEqual(copepod.load(self.folder / "out").status, "running")
        followed = copepod.follow(self.folder / "out")
        self.assertEqual([next(followed).step for _ in range(3)], [0, 50, 100])
        started.send_signal(signal.SIGINT)
        said = started.stdout.read()
        self.assertEqual(started.wait(), 0)
        self.assertIn("resume=True", said)
        self.assertIn("stopped <built-in function default_int_handler>", said)
        self.assertTrue(list((self.folder / "out/checkpoints").glob("step_*")))
        self.assertGreater(sum(1 for _ in followed), 0)
        self.assert_nothing_runs()

    def test_run_ends_with_a_python_that_is_killed(self):
        script = f"import copepod\ncopepod.run({str(VACUUM)!r}, 'out', set={{'run.steps': 10**7}})\n"
        started = subprocess.Popen([sys.executable, "-c", script], cwd=self.folder, env=environment())
        wait_until((self.folder / "out/trajectory.csv").exists, "a trajectory")
        (run,) = Path(f"/proc/{started.pid}/task/{started.pid}/children").read_text().split()
        folders = list(Path("/tmp").glob(f"copepod-{run}-*"))
        self.assertTrue(folders)
        started.kill()
        started.wait()
        wait_until(lambda: copepod.load(self.folder / "out").status != "running", "the end of the run")
        wait_until(lambda: not any(folder.exists() for folder in folders), "clean-up")

    def test_threads_run_cases_at_the_same_time(self):
        both = threading.Barrier(2, timeout=60)
        found = {}

        def run(name, steps):
            waits = iter([both.wait])
            found[name] = self.run_of(
                VACUUM, name, set={"run.steps": steps}, on_progress=lambda _: [wait() for wait in waits]
            ).summary["steps"]

        threads = [threading.Thread(target=run, args=pair) for pair in (("a", 2000), ("b", 3000))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, {"a": 2000, "b": 3000})

    def test_sweep_gives_its_runs_and_a_table_of_its_keys(self):
        case = copepod.Case.load(VACUUM)
        case["sweep.parameters"] = {"swimmers.0.stroke.amplitude_N": [1e-5, 2e-5], "run.steps": [9000]}
        seen = []
        campaign = self.run_of(case, on_progress=seen.append)
        self.assertEqual((seen[-1].step, seen[-1].steps, seen[-1].share), (2, 2, 1.0))
        self.assertEqual(campaign.results["amplitude_N"].tolist(), [1e-5, 2e-5])
        for number, run in enumerate(campaign):
            self.assertEqual(run.case["swimmers.0.stroke.amplitude_N"], [1e-5, 2e-5][number])
            self.assertEqual(run.summary["digest"], campaign.results["digest"][number])
        self.assertEqual(len(copepod.load(campaign.directory)[:]), 2)

    def test_run_that_fails_raises_its_reason_and_where_it_is(self):
        body = self.folder / "body.sh"
        body.write_text(
            f'#!/bin/sh\ncase $1 in --capabilities|--estimate) exec {PROGRAMS}/body_service "$@";; esac\n'
            "echo 'out of luck' >&2\nexit 70\n"
        )
        body.chmod(0o755)
        with self.assertRaisesRegex(copepod.RunError, "body service .* exited with code 70.*out of luck") as caught:
            self.run_of(VACUUM, body=str(body))
        self.assertEqual((caught.exception.code, caught.exception.directory), (70, str(self.folder / "out")))
        self.assertEqual(copepod.load(caught.exception.directory).status, "failed")

    def test_warnings_of_the_case_are_warnings_of_python(self):
        with self.assertWarnsRegex(copepod.CaseWarning, "warning: ") as caught:
            copepod.run(
                QUICK, self.folder / "warned", set={**SETTINGS_THAT_WARN, "run.steps": 1}, on_progress=lambda _: None
            )
        self.assertEqual(caught.filename, __file__)


SETTINGS_THAT_WARN = {"fluid.relaxation_time": 3.0, "output.fields.mean_over_steps": [0, 0]}


class Loading(PackageTest):
    def test_fields_have_coordinates_and_units_and_are_read_when_they_are_used(self):
        import h5py

        fields = {"output.fields.every_steps": 20, "output.fields.mean_over_steps": [20, 40]}
        run = self.run_of(QUICK, set={"run.steps": 40, **fields})
        snapshots, mean = run.fields, run.mean_fields
        velocity = snapshots["velocity_m_per_s"]
        self.assertEqual(velocity.dims, ("time", "z", "y", "x", "component"))
        self.assertEqual(velocity.attrs["units"], "m/s")
        self.assertEqual(snapshots["x"].attrs["units"], "m")
        self.assertAlmostEqual(float(snapshots["z"][0]), 0.5e-6)
        self.assertEqual(int(snapshots["step"][-1]), 40)
        self.assertAlmostEqual(float(snapshots["time"][-1]), 40 * run.summary["step_s"])
        self.assertEqual(mean["density_kg_per_m3"].dims, ("z", "y", "x"))
        with h5py.File(run.directory / "fields.h5") as file:
            stored = file["step_000000040/velocity_m_per_s"]
            self.assertEqual(float(velocity.isel(time=-1, z=3, y=4, x=5, component=2)), stored[3, 4, 5, 2])
            self.assertTrue((velocity.isel(time=slice(-1, None), z=7).values[0] == stored[7]).all())
            last = velocity.isel(time=[-1], y=[4, 2], x=-1).values
            self.assertTrue((last[0] == stored[:, :, -1][:, [4, 2]]).all())
            self.assertTrue((mean["velocity_m_per_s"][3].values == file["mean/velocity_m_per_s"][3]).all())
        (run.directory / "fields.h5").unlink()
        with self.assertRaisesRegex(copepod.Error, "does not exist"):
            velocity.isel(x=0).values

    def test_what_is_not_there_is_refused_with_what_to_do(self):
        with self.assertRaisesRegex(copepod.Error, "neither a run nor a campaign"):
            copepod.load(self.folder)
        run = self.run_of(VACUUM, set={"run.steps": 10})
        for read in (lambda: run.fields, lambda: run.mean_fields):
            with self.assertRaisesRegex(copepod.Error, "Set output.fields"):
                read()
        (run.directory / "summary.json").write_text("{")
        with self.assertRaisesRegex(copepod.Error, "summary.json cannot be read"):
            copepod.load(run.directory).summary

    def test_missing_package_is_named_with_the_command_that_installs_it(self):
        run = self.run_of(VACUUM, set={"run.steps": 10})
        for module, use in (("pandas", lambda: run.trajectory), ("yaml", lambda: copepod.Case.load(VACUUM))):
            here = sys.modules.pop(module, None)
            sys.modules[module] = None
            try:
                with self.assertRaisesRegex(ImportError, f"apt-get install -y python3-{module}"):
                    use()
            finally:
                sys.modules[module] = here


class Installation(PackageTest):
    SCRIPT = (
        "import copepod, copepod.v1.handshake_pb2 as generated; print(copepod.__file__, generated.__file__);"
        f"run = copepod.run({str(VACUUM)!r}, 'out', set={{'run.steps': 10}}, quiet=True); print(run.summary['steps'])"
    )

    def output_of(self, environment):
        done = subprocess.run(
            [sys.executable, "-P", "-c", self.SCRIPT], cwd=self.folder, env=environment, capture_output=True, text=True
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        shutil.rmtree(self.folder / "out")
        return done.stdout

    def test_generated_messages_are_found_beside_the_package_in_any_order(self):
        generated = PROGRAMS.parent / "python"
        for folders in ((generated,), (ROOT / "python", generated)):
            self.assertIn(
                f"{ROOT}/python/copepod/__init__.py {generated}/copepod/v1/", self.output_of(environment(*folders))
            )

    def test_pip_installs_it_without_a_network_and_it_uses_the_checkout_it_came_from(self):
        checkout = self.folder / "checkout"  # pip leaves its files there
        for name in ("deploy", "python"):
            shutil.copytree(ROOT / name, checkout / name)
        for name in ("pyproject.toml", "CMakeLists.txt", "CMakePresets.json"):
            shutil.copy(ROOT / name, checkout / name)
        site = self.folder / "site"
        command = [
            sys.executable,
            "-m",
            "pip",
            "install",
            "-q",
            "--root-user-action=ignore",
            "--no-deps",
            "--no-build-isolation",
            "--no-index",
        ]
        subprocess.run([*command, "--target", site, checkout], check=True, stdout=subprocess.DEVNULL)
        shutil.copytree(PROGRAMS.parent / "python/copepod/v1", site / "copepod/v1")  # as pip does with the kit
        said = self.output_of({**os.environ, "PYTHONPATH": str(site)})
        self.assertIn(f"{site}/copepod/__init__.py {site}/copepod/v1/", said)

    def test_the_command_starts_python_with_the_package(self):
        session = self.start("python", "-c", "import copepod; print(copepod.run.__module__)")
        self.assert_ends(session, 0)
        self.assertEqual("".join(session.stdout), "copepod.running\n")


if __name__ == "__main__":
    unittest.main()
