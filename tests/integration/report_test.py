"""`copepod report` on a run whose motion is known in closed form."""

import contextlib
import fcntl
import json
import os
import re
import shutil
import unittest
from unittest import mock

import h5py
import numpy as np
from matplotlib.collections import LineCollection

from copepod_session import CommandTest
from surfaces import with_surfaces
from synthetic_run import ARMS, CELL_M, PERIOD, SPEED, STEP_S, write_run, write_unfinished_run
from copepod_report.cycles import by_cycle, centroids_m, kinematics_so_far, paths, read_cycles
from copepod_report.flow import View, choose, draw, strongest_plane
from copepod_report.motion_plots import flow_over_time
from copepod_report.report import film_of, page_of
from copepod_report.run_record import RunRecord, collect, fit_arm, name_apart
from copepod_report.style import LIGHT, new_figure, picture_of, svg_of
from copepod_report.trajectory import Trajectory
from copepod_run.errors import Stop


def read_case(path):
    """As the stand-in coupler does."""
    return with_surfaces(json.loads(path.read_text())["case"])


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

    def test_coefficients_are_drawn_over_time_where_they_have_settled(self):
        write_run(self.folder / "run", mean_flow=False)
        time_s = np.linspace(0, 3, 301)
        drag = np.where(time_s < 0.1, 40.0, 3.2 + 0.06 * np.sin(time_s))
        lines = [
            f"{step},{time},{of_drag},{0.9 * np.sin(time)}" for step, (time, of_drag) in enumerate(zip(time_s, drag))
        ]
        table = self.folder / "run/coefficients.csv"
        table.write_text("\n".join(["step,time_s,rock.drag,rock.lift", *lines, "301,3.0"]))
        of_drag, of_lift = flow_over_time(table).axes
        self.assertLess(of_drag.get_ylim()[1], 4)
        self.assertGreater(of_drag.get_ylim()[1], 3.26)
        self.assertEqual((of_drag.get_ylabel(), of_lift.get_ylabel()), ("drag coefficient", "lift coefficient"))
        self.assertEqual(self.report("run")[0], 0)
        self.assertTrue((self.folder / "run/report/design_a_coefficients_over_time.png").exists())

    def test_flow_through_faces_and_forces_on_them_are_drawn_and_their_figures_listed(self):
        write_run(self.folder / "run", mean_flow=False)
        table = self.folder / "run/flow.csv"
        lines = [f"{step},{step / 10},{0.1 * step},{step**2},7" for step in range(20)]
        table.write_text("\n".join(["step,time_s,x_low.inflow_m3_per_s,x_low.fx_N,x_low.fy_N", *lines, ""]))
        of_flow, of_force = flow_over_time(table).axes
        self.assertEqual((of_flow.get_ylabel(), of_force.get_ylabel()), ("flow [m³/s]", "force on faces [N]"))
        self.assertEqual(len(of_force.lines), 2)
        summary = json.loads((self.folder / "run/summary.json").read_text())
        summary["flow"] = [{"name": "x_low.fx_N", "mean": 4.0, "rms": 0.25, "min": 3.5, "max": 4.75}]
        (self.folder / "run/summary.json").write_text(json.dumps(summary))
        self.assertEqual(self.report("run")[0], 0)
        page = (self.folder / "run/report/report.html").read_text()
        self.assertRegex(page, r"x_low\.fx_N\W.*?\W4\W.*?0\.25.*?3\.5.*?4\.75")

    def test_page_needs_nothing_but_itself(self):
        write_run(self.folder / "run")
        self.report("run")
        text = (self.folder / "run/report/report.html").read_text()
        sources = re.findall(r'(?:src|srcset|href)="([^"]*)"', text)
        self.assertEqual(len(sources), 7)
        self.assertTrue(all(source.startswith("data:image/svg+xml;base64,") for source in sources))
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
        self.assertTrue((self.folder / "both/speeds.png").exists())
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
        write_run(self.folder / "lags/case_lag=30", mean_flow=False)
        write_run(self.folder / "other", mean_flow=False)
        case = {"name": "case_lag=30", "member_of": "case", "parameters": {"a.lag": 30}, "summary": {}}
        (self.folder / "lags/results.json").write_text(json.dumps({"cases": [case, {"name": "x", "summary": None}]}))
        found = collect(self.folder / "lags", read_case)
        name_apart([*found, RunRecord(self.folder / "other", lambda path: {})])
        self.assertEqual([run.name for run in found], ["case_lag=30"])
        self.assertEqual(found[0].sweep.values, {"a.lag": 30})

    def test_transient_first_cycle_does_not_set_the_scale(self):
        write_run(self.folder / "run", mean_flow=False)
        cycles = read_cycles(self.folder / "run/cycles.csv")["swimmer"]
        cycles["u_along_m_per_s"] = np.array([9.0, 1.0, 1.1, 1.2, 1.3])
        cycles["rotation_y_rad"] = np.array([0.11, 0.1, 0.12, 0.1, 0.1])
        cycles["rotation_z_rad"] = np.array([0.0, 0.0, 1e-9, 0.0, 0.0])
        cycles["arm3_mean_m"] = np.full(5, np.nan)  # another swimmer has this arm
        steady = kinematics_so_far(cycles)
        self.assertEqual(len(steady["arms"]), 2)
        self.assertAlmostEqual(steady["u_along_mean_um_per_s"], 1.15e6)
        self.assertAlmostEqual(steady["u_along_spread_um_per_s"], 1e5 * (5 / 3) ** 0.5)
        three = kinematics_so_far({column: values[:3] for column, values in cycles.items()})
        self.assertNotIn("u_along_mean_um_per_s", three)
        velocity, rotation, *arms = by_cycle(cycles, ["B2–B1", "B1–B3"]).axes
        self.assertLess(velocity.get_ylim()[1], 2e6)
        self.assertEqual([line.get_label() for line in rotation.lines], ["about y"])
        np.testing.assert_allclose(rotation.lines[0].get_ydata(), np.degrees(cycles["rotation_y_rad"]))
        self.assertEqual([line.get_label() for line in arms[0].lines], ["B2–B1", "B1–B3"])

    def test_paths_reach_the_end_of_the_last_cycle(self):
        write_run(self.folder / "run", mean_flow=False)
        track = paths(read_cycles(self.folder / "run/cycles.csv")).axes[0].lines[0].get_ydata()
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
        (self.folder / "run/logs").mkdir()
        (self.folder / "run/logs/progress.json").write_text('{"phase": "running", "step": 1300}')
        self.assertIn("Stopped by a signal at step 1300", page_of(self.folder / "run", read_case))
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
        self.assertEqual(self.report("run")[0], 0)
        link = self.folder / "run/report/design_a_mean_flow.png"
        link.unlink()
        link.symlink_to(target)
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

    def chosen(self, **view):
        return choose(RunRecord(self.folder / "run", read_case), View(**view))

    def test_picture_of_the_flow_follows_plane_position_and_time(self):
        write_run(self.folder / "run", steps=2400)
        for plane, shape in (("zy", (24, 60)), ("yz", (60, 24)), ("xz", (60, 20)), ("zx", (20, 60)), ("xy", (24, 20))):
            self.assertEqual(self.chosen(plane=plane).velocity_along_m_per_s.shape, shape)
        picture = self.chosen()
        self.assertEqual((picture.along, picture.across, picture.window), (2, 1, (0, 2000)))
        np.testing.assert_allclose(picture.velocity_along_m_per_s[6, :], 2e-3)
        np.testing.assert_allclose(picture.velocity_across_m_per_s[:, 15], 1e-3)
        self.assertAlmostEqual(self.chosen(plane="xz", at_m=6.2e-6).at_m, 6.5e-6)  # the centre of its layer of cells
        np.testing.assert_allclose(self.chosen(plane="xz", at_m=6.2e-6).velocity_across_m_per_s, 2e-3)
        self.assertAlmostEqual(self.chosen(plane="xz", at_m=6e-6).at_m * 1e6, 6.0)  # a face: the mean of two layers
        last = self.chosen(time="last")
        self.assertEqual(last.window, (800, 800))
        np.testing.assert_allclose(last.velocity_along_m_per_s[6, :], 6e-3)
        self.assertEqual(self.chosen(time="400").window, (400, 400))

    def test_frame_of_a_body_moves_with_it_and_zoom_shows_it(self):
        write_run(self.folder / "run", steps=2400)
        speed = SPEED * CELL_M / STEP_S
        resting, moving = self.chosen(), self.chosen(frame="B1")
        difference = resting.velocity_along_m_per_s - moving.velocity_along_m_per_s
        np.testing.assert_allclose(difference, speed, rtol=1e-6)
        self.assertIn("relative to the velocity of B1", moving.caption(RunRecord(self.folder / "run", read_case)))
        self.assertIsNone(resting.shown_m)
        low, high, bottom, top = self.chosen(zoom="swimmer.B1", margin_m=1e-6).shown_m
        self.assertAlmostEqual(high - low, 2 * (4 + 4 + 1) * 1e-6)  # radius, half a capsule's length, margin
        self.assertAlmostEqual(0.5 * (low + high), (30 + SPEED * 990) * CELL_M)
        self.assertAlmostEqual(0.5 * (bottom + top), 12e-6)

    def test_view_that_does_not_suit_the_run_is_an_error(self):
        write_run(self.folder / "run")
        for view, expected in (
            ({"zoom": "B7"}, "--zoom B7 does not suit design_a (it has swimmer, swimmer.B2"),
            ({"time": "401"}, "--time 401 does not suit design_a (snapshots: steps 400, 800)"),
            ({"plane": "xy", "at_m": 1.0}, "--at 1 does not suit design_a (its domain ends at z = 6e-05 m)"),
        ):
            with self.assertRaises(Stop) as caught:
                self.chosen(**view)
            self.assertEqual(caught.exception.code, 2)
            self.assertIn(expected, caught.exception.message)

    def test_default_plane_contains_the_motion(self):
        z, y, x = np.meshgrid(np.arange(12), np.arange(10), np.arange(14), indexing="ij")
        for moving, varying, expected in ((0, z, (0, 2)), (0, y, (0, 1)), (1, z, (1, 2)), (2, x, (0, 2))):
            velocity = np.zeros((12, 10, 14, 3))
            velocity[..., moving] = varying - varying.mean()
            self.assertEqual(set(strongest_plane(velocity, np.zeros(3))), set(expected))
        still = np.zeros((12, 10, 14, 3))
        self.assertEqual(strongest_plane(still, np.array([0, 0, 1.0])), (2, 1))
        self.assertEqual(strongest_plane(still, np.array([1.0, 0, 2.0])), (2, 0))
        self.assertEqual(set(strongest_plane(still[:1], np.array([0, 0, 1.0]))), {0, 1})  # a slice normal to z

    def test_axes_whose_faces_are_periodic_are(self):
        write_run(self.folder / "run")
        content = json.loads((self.folder / "run/case.yaml").read_text())
        periodic = {"low": "periodic", "high": "periodic"}
        pair = {"low": "no_slip", "high": {"velocity_m_per_s": [1, 0, 0]}}
        content["case"]["fluid"]["boundaries"] = {"x": periodic, "y": pair, "z": periodic}
        (self.folder / "run/case.yaml").write_text(json.dumps(content))
        trajectory = self.folder / "run/trajectory.csv"
        trajectory.write_text(trajectory.read_text().replace(",1e-05,1.2e-05,", ",3.1e-05,1.2e-05,"))
        self.assertEqual(RunRecord(self.folder / "run", read_case).is_periodic, [True, False, True])
        self.assertAlmostEqual(self.chosen(plane="yz").at_m, 11e-6, delta=1e-9)  # not 31 µm, beyond the domain

    def test_bodies_have_images_behind_planes_of_symmetry(self):
        write_run(self.folder / "run")
        content = json.loads((self.folder / "run/case.yaml").read_text())
        content["case"]["fluid"]["symmetry_planes"] = ["y", "z"]  # all bodies are on the first
        (self.folder / "run/case.yaml").write_text(json.dumps(content))
        run = RunRecord(self.folder / "run", read_case)
        drawn = [lines for lines in draw(run, self.chosen(plane="yz")).axes[0].collections if lines.get_zorder() == 5]
        outlines = [np.vstack(lines.get_segments()) for lines in drawn if isinstance(lines, LineCollection)]
        middles = np.array([(points.min(axis=0) + points.max(axis=0)) / 2 for points in outlines])
        self.assertEqual(middles.shape, (6, 2))
        np.testing.assert_allclose(middles[:, 0], 12)
        np.testing.assert_allclose(middles[::2, 1] + middles[1::2, 1], 60)
        self.assertGreater(np.abs(middles[::2, 1] - middles[1::2, 1]).min(), 1)

    def test_film_has_a_picture_of_each_snapshot(self):
        write_run(self.folder / "run")
        run = RunRecord(self.folder / "run", read_case)
        (self.folder / "ffmpeg").write_text("#!/bin/sh\nset -e\ncat >pictures\necho film\n")
        (self.folder / "ffmpeg").chmod(0o700)
        environment = mock.patch.dict(os.environ, {"PATH": f"{self.folder}:{os.environ['PATH']}"})
        with environment, mock.patch("copepod_run.packages.missing", return_value=[]), contextlib.chdir(self.folder):
            self.assertEqual(film_of(run, View()), b"film\n")
            self.assertEqual((self.folder / "pictures").read_bytes().count(PNG), 2)
            (self.folder / "ffmpeg").write_text("#!/bin/sh\ncat >/dev/null\necho no codec >&2\nexit 1\n")
            with self.assertRaisesRegex(Stop, r"ffmpeg made no film of design_a \(no codec\)"):
                film_of(run, View())
            with h5py.File(self.folder / "run/fields.h5", "r+") as file:
                del file["step_000000400"]
            with self.assertRaisesRegex(Stop, r"design_a cannot be filmed .* the run recorded 1\)"):
                film_of(run, View())
        with mock.patch("copepod_run.packages.missing", return_value=["ffmpeg"]):
            with self.assertRaisesRegex(Stop, "apt-get install -y ffmpeg"):
                film_of(run, View())

    def test_flow_of_a_part_of_the_domain_is_drawn_where_it_is(self):
        write_run(self.folder / "run")
        with h5py.File(self.folder / "run/fields.h5", "r+") as file:
            for axis, first in zip("xyz", (5, 6, 7)):
                file["mean"].attrs[f"first_cell_{axis}"] = first
        picture = self.chosen(plane="xz", at_m=8.5e-6)
        self.assertEqual(picture.corner_cells, (5, 7))
        np.testing.assert_allclose(picture.velocity_across_m_per_s, np.sin(2 * np.pi * 2 / 24) * 2e-3)

    def test_figures_are_the_same_bytes_each_time_and_their_text_is_text(self):
        write_run(self.folder / "run")
        run = RunRecord(self.folder / "run", read_case)
        picture = choose(run, View())
        for kind, start in (("png", PNG), ("svg", b"<?xml"), ("pdf", b"%PDF")):
            first, second = (picture_of(draw(run, picture), kind, "a caption") for _ in range(2))
            self.assertEqual(first, second)
            self.assertTrue(first.startswith(start))
            self.assertIn(b"a caption", first)
            self.assertNotRegex(first, rb"<dc:date>|/CreationDate")
            self.assertEqual(b">z [\xc2\xb5m]</text>" in first, kind == "svg")

    def test_figures_of_the_page_change_their_colours_with_it(self):
        write_run(self.folder / "run")
        run = RunRecord(self.folder / "run", read_case)
        figure = draw(run, choose(run, View()))
        figure.axes[0].set_title(LIGHT.ink)
        text = svg_of(figure)
        style, rest = text.partition("</style>")[::2]
        declared = re.findall(r"(--c\d): (#\w{6});", style.partition("@media (prefers-color-scheme: dark)")[2])
        self.assertEqual(len(dict(declared)), len(LIGHT.colours()))
        self.assertEqual(set(re.findall(r"(?:fill|stroke): (#\w+)", rest)), set())  # all of them are variables
        self.assertGreater(rest.count("var(--c1)"), 10)
        self.assertIn(f">{LIGHT.ink}</text>", rest)
        self.assertIn(f"fill: {LIGHT.ink}".encode(), picture_of(figure, "svg"))  # files are light

    def test_figure_of_very_many_lines_becomes_pixels_between_axes_that_follow_the_page(self):
        figure, axes = new_figure(3.0)
        for number in range(400):
            axes.plot(np.sin(np.arange(200) * number))
        text = svg_of(figure)
        self.assertLess(len(text), 1_500_000)
        self.assertIn("<image", text)
        self.assertGreater(text.count("var(--c1)"), 10)
        self.assertNotRegex(text.partition("</style>")[2], "(?:fill|stroke): #")  # nor has the grid colours of its own

    def test_plots_are_written_in_the_formats_that_are_asked_for(self):
        write_run(self.folder / "run")
        code, session = self.report("run", "--format", "pdf", "svg", "--plane", "xz", "--at", "6e-6", "--time", "400")
        self.assertEqual(code, 0, "".join(session.stderr))
        names = {path.name for path in (self.folder / "run/report").iterdir()}
        self.assertIn("design_a_flow.pdf", names)
        self.assertEqual({name.rpartition(".")[2] for name in names}, {"pdf", "svg", "html"})
        text = (self.folder / "run/report/report.html").read_text()
        self.assertIn("Flow in the x–z plane at y = 6 µm, step 400 (400 ns), in the laboratory frame", text)
        self.assertIn("design_a, radius 2 µm to 4 µm, cell 1 µm, step 1 ns, period 400 ns.", text)

    def test_options_of_the_flow_are_not_mixed_up(self):
        write_run(self.folder / "run")
        code, session = self.report("run", "--frame", "B1", "--zoom", "B7", "--margin", "1e-6")
        self.assertEqual(code, 2)
        self.assertIn("--zoom B7 does not suit design_a", session.stderr[-1])


if __name__ == "__main__":
    unittest.main()
