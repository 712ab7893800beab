"""`copepod report` on a run whose motion is known in closed form."""

import fcntl
import json
import os
import re
import shutil
import unittest
from types import SimpleNamespace

import numpy as np

from copepod_session import CommandTest
from synthetic_run import ARMS, CELL_M, DOMAIN, PERIOD, SPEED, write_run, write_unfinished_run
from copepod_report.cycles import by_cycle, centroids_m, paths, read_cycles
from copepod_report.report import page_of
from copepod_report.flow import plane_of, read_mean_flow
from copepod_report.run_record import collect, fit_arm, name_apart
from copepod_report.style import LIGHT
from copepod_report.trajectory import Trajectory
from copepod_run.errors import Stop


def read_case(path):
    """As the stand-in coupler does."""
    return json.loads(path.read_text())["case"]


PNG = b"\x89PNG\r\n\x1a\n"


class Report(CommandTest):
    def report(self, *arguments):
        session = self.start("report", *arguments)
        code = session.end(timeout_s=100)
        return code, session

    def test_page_and_plots_of_one_run(self):
        write_run(self.folder / "run")
        code, session = self.report("run")
        self.assertEqual(code, 0, "".join(session.stderr))
        self.assertEqual("".join(session.stdout), "run/report/report.html\n")
        plots = sorted(path.name for path in (self.folder / "run/report").glob("*.png"))
        self.assertEqual(
            plots,
            [
                f"design_a_{name}.png"
                for name in (
                    *("mean_flow", "paths", "swimmer_arms", "swimmer_by_cycle", "swimmer_cycle", "swimmer_forces"),
                    "swimmer_positions",
                )
            ],
        )
        for path in (self.folder / "run/report").glob("*.png"):
            self.assertTrue(path.read_bytes().startswith(PNG))

    def test_page_needs_nothing_but_itself(self):
        write_run(self.folder / "run")
        self.report("run")
        text = (self.folder / "run/report/report.html").read_text()
        sources = re.findall(r'(?:src|srcset|href)="([^"]*)"', text)
        self.assertEqual(len(sources), 14)  # seven plots, light and dark
        self.assertTrue(all(source.startswith("data:image/png;base64,") for source in sources))
        self.assertNotRegex(text, r"https?://|@import|url\(|import\(|fetch\(")
        self.assertIn("prefers-color-scheme: dark", text)

    def test_several_runs_are_compared_with_published_values(self):
        write_run(self.folder / "one", "design_a", published={"u_swim_lattice": 0.8e-3}, mean_flow=False)
        write_run(self.folder / "two", "design_b", mean_flow=False)
        code, session = self.report("one", "two", "--out", "both")
        self.assertEqual(code, 0, "".join(session.stderr))
        text = (self.folder / "both/report.html").read_text()
        self.assertIn("<small>0.0008</small><small>+25.0 %</small>", text)
        self.assertIn('href="#design_b"', text)
        self.assertTrue((self.folder / "both/speeds_by_family.png").exists())
        self.assertFalse((self.folder / "both/design_a_mean_flow.png").exists())

    def test_runs_of_one_case_have_the_names_of_their_folders(self):
        for folder in ("slow", "a/fast", "b/fast"):
            write_run(self.folder / folder, mean_flow=False)
        code, session = self.report("slow", "a/fast", "b/fast", "--out", "all")
        self.assertEqual(code, 0, "".join(session.stderr))
        text = (self.folder / "all/report.html").read_text()
        for name in ("slow", "a/fast", "b/fast"):
            self.assertIn(f"<h2>{name}</h2>", text)
            self.assertIn(f'<a href="#{name.replace("/", "_")}">{name}</a>', text)

    def test_members_of_a_sweep_have_its_values_in_their_names(self):
        write_run(self.folder / "lags/case_01", mean_flow=False)
        case = {"name": "case_01", "label": "case_01, lag_deg 30", "summary": {}}
        (self.folder / "lags/results.json").write_text(json.dumps({"cases": [case, {"name": "x", "summary": None}]}))
        found = collect(self.folder / "lags", lambda path: json.loads(path.read_text())["case"])
        name_apart([*found, *collect(self.folder / "lags/case_01", lambda path: {})])
        self.assertEqual([run.name for run in found], ["case_01, lag_deg 30"])

    def test_transient_first_cycle_does_not_set_the_scale(self):
        write_run(self.folder / "run", mean_flow=False)
        cycles = read_cycles(self.folder / "run/cycles.csv")["swimmer"]
        cycles["u_along_m_per_s"] = np.array([9.0, 1.0, 1.1, 1.2, 1.3])
        cycles["rotation_y_rad"] = np.array([0.11, 0.1, 0.12, 0.1, 0.1])
        cycles["rotation_z_rad"] = np.array([0.0, 0.0, 1e-9, 0.0, 0.0])
        velocity, rotation, *arms = by_cycle(cycles, ["B2–B1", "B1–B3"], LIGHT).axes
        self.assertLess(velocity.get_ylim()[1], 2e6)
        self.assertEqual([line.get_label() for line in rotation.lines], ["about y"])
        np.testing.assert_allclose(rotation.lines[0].get_ydata(), np.degrees(cycles["rotation_y_rad"]))
        self.assertEqual([line.get_label() for line in arms[0].lines], ["B2–B1", "B1–B3"])

    def test_paths_reach_the_end_of_the_last_cycle(self):
        write_run(self.folder / "run", mean_flow=False)
        track = paths(read_cycles(self.folder / "run/cycles.csv"), LIGHT).axes[0].lines[0].get_ydata()
        np.testing.assert_allclose(track, 1e6 * SPEED * PERIOD * CELL_M * np.arange(5), atol=1e-9)

    def test_run_that_ended_before_the_last_period_has_no_fits(self):
        write_run(self.folder / "run", steps=1000, mean_flow=False)
        code, session = self.report("run")
        self.assertEqual(code, 0, "".join(session.stderr))
        self.assertFalse((self.folder / "run/report/design_a_swimmer_arms.png").exists())
        self.assertTrue((self.folder / "run/report/design_a_swimmer_positions.png").exists())

    def test_running_run_shows_how_far_it_is_and_what_there_is(self):
        write_unfinished_run(self.folder / "run", at_step=1000)
        lock = os.open(self.folder / "run", os.O_RDONLY)
        fcntl.flock(lock, fcntl.LOCK_EX)  # as the command that runs there
        try:
            code, session = self.report("run")
        finally:
            os.close(lock)
        self.assertEqual(code, 0, "".join(session.stderr))
        text = (self.folder / "run/report/report.html").read_text()
        self.assertIn("Running, at step 1000 of 2400 (41 %).", text)
        self.assertIn("<td>velocity along its own axis</td><td>1e+06</td>", text)  # of the second cycle
        plots = {path.name for path in (self.folder / "run/report").glob("*.png")}
        wanted = {f"design_a_swimmer_{name}.png" for name in ("positions", "cycle", "arms", "forces", "by_cycle")}
        self.assertEqual(plots, wanted)

    def test_page_of_an_ended_run_says_why_it_ended_and_how_to_continue(self):
        for provenance, expected in (
            ({}, "Ended at step 1000 of 2400 (41 %), or shortly after, without a record"),
            ({"status": "failed", "exit_code": 70, "exit_reason": "NaN at <1>."}, "Failed at step 1000 of 2400 (41 %)"),
            ({"status": "failed", "exit_code": 130, "exit_reason": "stopped by signal 2"}, "Stopped by a signal at"),
        ):
            shutil.rmtree(self.folder / "run", ignore_errors=True)
            write_unfinished_run(self.folder / "run", **provenance)
            text = page_of(self.folder / "run", read_case)
            self.assertIn(expected, text)
            self.assertIn("There is no checkpoint.", text)
            self.assertEqual("NaN at &lt;1&gt;." in text, "NaN" in provenance.get("exit_reason", ""))
        (self.folder / "run/checkpoints/step_1200").mkdir(parents=True)
        (self.folder / "run/checkpoints/step_1200/manifest.json").write_text("{}")
        text = page_of(self.folder / "run", read_case)
        self.assertIn("Stopped by a signal at step 1200", text)
        self.assertIn("The last checkpoint is of step 1200", text)
        self.assertFalse((self.folder / "run/report").exists())

    def test_half_written_files_of_a_running_run_are_read_as_far_as_they_go(self):
        write_unfinished_run(self.folder / "run", at_step=2 * PERIOD)
        trajectory, cycles = self.folder / "run/trajectory.csv", self.folder / "run/cycles.csv"
        rows, whole = trajectory.read_text(), cycles.read_text()
        for size in (0, 30, rows.index("\n") + 1, 700, len(rows) - 2):  # the last number is cut, and still a number
            trajectory.write_text(rows[:size])
            cycles.write_text(whole[:size])
            (self.folder / "run/fields.h5").write_bytes(b"\x89HDF")
            self.assertIn("<h2>design_a</h2>", page_of(self.folder / "run", read_case))
        self.assertEqual(len(Trajectory(trajectory)), 2 * PERIOD // 20)
        for name in ("trajectory.csv", "cycles.csv", "fields.h5", "provenance.json"):
            (self.folder / "run" / name).unlink()
        self.assertIn("Ended at step 0 of 2400", page_of(self.folder / "run", read_case))

    def test_damage_of_an_unfinished_run_is_named(self):
        write_unfinished_run(self.folder / "run")
        path = self.folder / "run/trajectory.csv"
        path.write_text(path.read_text().replace("e-06", "e-x6"))
        with self.assertRaises(Stop) as caught:
            page_of(self.folder / "run", read_case)
        self.assertEqual(caught.exception.code, 73)

    def test_resumed_run_does_not_show_the_summary_of_the_run_before(self):
        write_run(self.folder / "run", mean_flow=False)
        (self.folder / "run/provenance.json").write_text('{"status": "running"}')
        self.assertNotIn("00ff00ff00ff00ff", page_of(self.folder / "run", read_case))

    def test_folder_without_a_run_is_an_error(self):
        code, session = self.report(".")
        self.assertEqual(code, 2)
        self.assertIn(". has no case.yaml (it is not a run)", session.last_line)

    def test_damaged_files_are_named(self):
        write_run(self.folder / "run", mean_flow=False)
        for name, content in (("trajectory.csv", ""), ("summary.json", '{"case": "desi')):
            (self.folder / "run" / name).write_text(content)
            code, session = self.report("run")
            self.assertEqual(code, 73, "".join(session.stderr))
            self.assertIn(f"run/{name} cannot be read (cut off or damaged: ", session.last_line)

    def test_names_and_links_from_elsewhere_lead_nowhere(self):
        write_run(self.folder / "run")
        for name in ("case.yaml", "summary.json", "trajectory.csv", "cycles.csv"):
            path = self.folder / "run" / name
            path.write_text(re.sub(r"\bswimmer\b(?!s)", "/../../../escaped $x", path.read_text()))
        target = self.folder / "target"
        target.write_text("precious")
        (self.folder / "run/report").mkdir()
        for name in ("report.html", "design_a_mean_flow.png"):
            (self.folder / "run/report" / name).symlink_to(target)
        code, session = self.report("run")
        self.assertEqual(code, 0, "".join(session.stderr))
        self.assertEqual(target.read_text(), "precious")
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["run", "target"])
        self.assertTrue((self.folder / "run/report/design_a__.._.._.._escaped_x_positions.png").is_file())

    def test_folder_of_the_report_is_no_link_unless_the_user_names_it(self):
        write_run(self.folder / "run", mean_flow=False)
        (self.folder / "elsewhere").mkdir()
        (self.folder / "run/report").symlink_to(self.folder / "elsewhere")
        code, session = self.report("run")
        self.assertEqual(code, 73, "".join(session.stderr))
        self.assertIn("run/report leads elsewhere (it is a symbolic link).", session.last_line)
        self.assertEqual(self.report("run", "--out", "run/report")[0], 0)

    def test_damaged_contents_are_named(self):
        damages = {
            "fields.h5": lambda path: os.truncate(path, 3000),
            "summary.json": lambda path: path.write_text('["design_a"]'),
            "cycles.csv": lambda path: path.write_text(path.read_text().replace(".", "x")),
            "trajectory.csv": lambda path: path.write_text("step,body\n1,a\n"),
            "results.json": os.mkfifo,
        }
        for name, damage in damages.items():
            shutil.rmtree(self.folder / "run", ignore_errors=True)
            write_run(self.folder / "run")
            damage(self.folder / "run" / name)
            code, session = self.report("run")
            self.assertEqual(code, 73, name + "".join(session.stderr))
            self.assertIn(f"run/{name} cannot be read", session.last_line)

    def test_summary_of_other_content_is_no_traceback(self):
        write_run(self.folder / "run", mean_flow=False)
        path = self.folder / "run/summary.json"
        summary = json.loads(path.read_text())
        for key, value in (
            ("mlups", "fast"),
            ("timing", [1]),
            ("wall_s", "long"),
            ("swimmers", [{"name": "swimmer", "kinematics": {"cycle": 1}}]),
        ):
            path.write_text(json.dumps({**summary, key: value}))
            code, session = self.report("run")
            self.assertEqual((code, len(session.stderr)), (73, 1), "".join(session.stderr))
            self.assertIn("run cannot be evaluated (a file is damaged: ", session.last_line)

    def test_arm_fit_finds_mean_amplitude_and_phase(self):
        phase = np.linspace(0, 2 * np.pi, 101)
        for mean, amplitude, shift in ARMS:
            found = fit_arm(phase, mean + amplitude * np.cos(phase + shift))
            np.testing.assert_allclose(found, (mean, amplitude, shift), rtol=1e-12)

    def test_trajectory_of_a_killed_run_is_read_up_to_the_last_whole_sample(self):
        write_run(self.folder / "run", steps=2 * PERIOD, mean_flow=False)
        path = self.folder / "run/trajectory.csv"
        path.write_text(path.read_text()[:-40])
        trajectory = Trajectory(path)
        self.assertEqual(trajectory.bodies, ["swimmer.B2", "swimmer.B1", "swimmer.B3"])
        self.assertEqual(len(trajectory), 2 * PERIOD // 20)
        self.assertEqual(trajectory.of("swimmer.B1")["position_m"].shape, (2 * PERIOD // 20, 3))

    def test_cycles_are_read_by_swimmer_up_to_the_last_whole_row(self):
        write_run(self.folder / "run", mean_flow=False)
        path = self.folder / "run/cycles.csv"
        path.write_text(
            path.read_text() + "other,0," + path.read_text().splitlines()[-1].split(",", 2)[2] + "\nother,1,4"
        )
        found = read_cycles(path)
        self.assertEqual(list(found), ["swimmer", "other"])
        np.testing.assert_array_equal(found["swimmer"]["cycle"], range(5))
        self.assertEqual(len(found["other"]["cycle"]), 1)
        self.assertTrue(np.isnan(found["swimmer"]["efficiency"]).all())
        np.testing.assert_allclose(centroids_m(found["swimmer"])[3], [10e-6, 12e-6, 31.2e-6])
        self.assertEqual(read_cycles(self.folder / "nothing.csv"), {})

    def test_plane_of_the_mean_flow_has_the_axis_horizontally(self):
        write_run(self.folder / "run", steps=20)
        middle = [cells / 2 for cells in DOMAIN]
        for along, across, shape in ((2, 1, (24, 60)), (1, 2, (60, 24)), (0, 2, (60, 20)), (2, 0, (20, 60))):
            plane = read_mean_flow(self.folder / "run/fields.h5", middle, along, across)
            self.assertEqual(plane.velocity_along_m_per_s.shape, shape)
        plane = read_mean_flow(self.folder / "run/fields.h5", middle, 2, 1)
        np.testing.assert_allclose(plane.velocity_along_m_per_s[6, :], 2e-3)
        np.testing.assert_allclose(plane.velocity_across_m_per_s[:, 15], 1e-3)

    def test_plane_of_the_mean_flow_holds_swimmers_that_stand_in_a_row(self):
        for centers, expected in (
            ([[10, 12, 30]], (2, 1)),
            ([[5, 12, 30], [10, 12, 30]], (2, 0)),
            ([[10, 6, 30], [10, 12, 30]], (2, 1)),
        ):
            swimmers = [SimpleNamespace(center_m=1e-6 * np.array(c, float), axis=np.array([0, 0, 1])) for c in centers]
            point, *axes = plane_of(SimpleNamespace(swimmers=lambda: swimmers, cell_size_m=1e-6))
            self.assertEqual(tuple(axes), expected)
            np.testing.assert_allclose(point, centers[0])


if __name__ == "__main__":
    unittest.main()
