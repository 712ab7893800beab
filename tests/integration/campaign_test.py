"""Campaigns: killed and started again, of changed cases and builds, with cases that fail."""

import contextlib
import csv
import io
import itertools
import json
import os
import shutil
import signal
import unittest
from pathlib import Path
from unittest import mock

from copepod_session import FAKES, ROOT, CommandTest

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
QUICK = ROOT / "configs/quick"

CAMPAIGN = f"""
campaign: small
jobs: 2
cases:
  - {{case: {QUICK}/vacuum.yaml}}
  - {{case: {QUICK}/three_sphere.yaml, name: one, set: {{run.steps: 1500, output.fields.mean_over_steps: [0, 0]}}}}
  - {{case: {QUICK}/three_sphere.yaml, name: two, set: {{run.steps: 2500, output.fields.mean_over_steps: [0, 0],
     output.checkpoint.every_steps: 300, output.flow: {{every_steps: 250, totals: false, faces: true}}}}}}
"""


class RealCampaign(CommandTest):
    programs = PROGRAMS

    def setUp(self):
        super().setUp()
        (self.folder / "small.yaml").write_text(CAMPAIGN)

    def results(self, out):
        """Rows of results.csv without what depends on the machine's mood."""
        rows = csv.DictReader((self.folder / out / "results.csv").read_text().splitlines())
        return [{key: value for key, value in row.items() if key != "wall_s"} for row in rows]

    def finish(self, out):
        session = self.start("campaign", "small.yaml", "--out", out)
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        return session

    def test_ends_with_the_same_table_after_a_kill_and_after_ctrl_c(self):
        self.finish("undisturbed")
        table = (self.folder / "undisturbed/results.md").read_text()
        self.assertIn("| vacuum | done | 5.1", table)
        rows = self.results("undisturbed")
        for column in rows[0]:
            self.assertTrue(any(row[column] for row in rows), f"{column} is empty")
        self.assertEqual([row["z_high.inflow_m3_per_s.mean"] for row in rows], ["", "", "0.0"])
        self.assertGreater(float(rows[2]["z_high.fz_N.rms"]), 0)
        for number, out in ((signal.SIGKILL, "killed"), (signal.SIGINT, "stopped")):
            session = self.start("campaign", "small.yaml", "--out", out)
            session.wait_for_file(f"{out}/two/checkpoints/*/manifest.json")
            session.process.send_signal(number)
            self.assertEqual(session.end(timeout_s=60), -9 if number == signal.SIGKILL else 130)
            again = self.finish(out)
            self.assertIn("two: continues from its checkpoint", "".join(again.stderr))
            self.assert_nothing_left(again)
            self.assertEqual((self.folder / out / "results.md").read_text(), table)
            self.assertEqual(self.results(out), self.results("undisturbed"))

    def test_a_finished_campaign_runs_nothing_again(self):
        self.finish("out")
        before = (self.folder / "out/one/provenance.json").stat().st_mtime_ns
        again = self.finish("out")
        self.assertIn("3 cases, 3 done already", "".join(again.stderr))
        self.assertEqual((self.folder / "out/one/provenance.json").stat().st_mtime_ns, before)


class FakeCampaign(CommandTest):
    """With components without physics: decisions of the command."""

    def setUp(self):
        super().setUp()
        self.programs = self.folder / "bin"  # of our own, so that it can become another build
        shutil.copytree(FAKES, self.programs)
        self.write("campaign", {"name": "fakes", "jobs": 2, "cases": ["a", "b"]})
        self.write_case("a")
        self.write_case("b")

    def write(self, name, content):
        (self.folder / f"{name}.json").write_text(json.dumps(content))

    def write_case(self, name, **keys):
        self.write(name, {"name": name, "steps": 5, "step_s": 0.01, "case": {"run": {"steps": 5}}, **keys})

    def run_campaign(self, *arguments, code=0):
        session = self.start("campaign", "campaign.json", "--out", "out", *arguments)
        self.assertEqual(session.end(timeout_s=60), code, "".join(session.stderr))
        return "".join(session.stderr)

    def states(self):
        records = json.loads((self.folder / "out/results.json").read_text())["cases"]
        return {record["name"]: (record["state"], record["of_another_build"]) for record in records}

    def test_a_changed_case_runs_again_and_the_former_run_is_kept(self):
        self.run_campaign()
        self.write_case("b", case={"run": {"steps": 6}})
        said = self.run_campaign()
        self.assertIn("1 done already", said)
        self.assertIn("the former run is now b.before-1", said)
        self.assertTrue((self.folder / "out/b.before-1/summary.json").exists())

    def test_published_figures_and_checkpoints_do_not_change_a_case(self):
        swimmer = {"name": "s", "published": {"K": 1}}
        self.write_case("a", case={"swimmers": [swimmer], "output": {"checkpoint": {"every_wall_s": 1}}})
        self.run_campaign()
        self.write_case("a", case={"swimmers": [{"name": "s"}], "output": {"checkpoint": {"every_wall_s": 2}}})
        self.assertIn("2 done already", self.run_campaign())

    def test_results_of_another_build_are_kept_and_said_to_be_so(self):
        self.run_campaign()
        with open(self.programs / "body_service", "a") as program:
            program.write("# changed\n")
        said = self.run_campaign()
        self.assertIn("2 results are of another build (a, b)", said)
        self.assertEqual(self.states(), {"a": ("done", True), "b": ("done", True)})
        self.run_campaign("--rerun-other-builds")
        self.assertEqual(self.states(), {"a": ("done", False), "b": ("done", False)})

    def test_bodies_that_bullet_moves_are_part_of_its_build(self):
        shutil.copy(self.programs / "body_service", self.programs / "bullet_body_service")
        self.run_campaign()
        self.assertEqual(len(list((self.folder / "out/programs").glob("*/bullet_body_service"))), 1)

    def test_programs_that_change_in_the_middle_do_not_disturb_it(self):
        self.write("campaign", {"name": "fakes", "jobs": 1, "cases": ["a", "b"]})
        self.write_case("a", steps=50)
        session = self.start("campaign", "campaign.json", "--out", "out")
        session.wait_for("a: starts")
        (self.programs / "fluid_service").unlink()
        self.assertEqual(session.end(timeout_s=60), 0, "".join(session.stderr))

    def test_a_failure_of_one_kind_is_not_repeated_for_every_case(self):
        names = [f"c{number}" for number in range(8)]
        self.write("campaign", {"name": "fakes", "jobs": 1, "cases": names})
        for name in names:
            self.write_case(name, fail=70)
        said = self.run_campaign(code=70)
        self.assertIn("the first 3 fail alike: the others are not started", said)
        self.assertIn("3 of 8 cases failed, 5 were not started (c0, c1, c2;", said)
        self.assertIn("8 of 8 cases failed (c0, c1,", self.run_campaign("--keep-going", code=70))
        self.write_case("c0")  # one that is done shows that the programs work
        self.assertIn("7 of 8 cases failed (c1,", self.run_campaign(code=70))

    def test_a_case_that_fails_does_not_keep_the_others_from_running(self):
        self.write_case("a", errors=["no such key"])
        self.assertIn("no such key", self.run_campaign(code=2))
        self.assertFalse((self.folder / "out").exists())  # nothing starts before every case is in order
        self.write_case("a", fail=70)
        said = self.run_campaign(code=70)
        self.assertEqual(self.states(), {"a": ("failed", False), "b": ("done", False)})
        self.assertIn("1 of 2 cases failed (a;", said)

    def test_what_starts_and_ends_is_shown_and_if_it_is_quiet_only_what_fails(self):
        self.write("campaign", {"name": "fakes", "jobs": 1, "cases": ["a", "b"]})
        self.write_case("b", fail=70)
        lines = self.run_campaign(code=70).splitlines()
        for number, line in enumerate(("a: starts", "a: done", "b: starts", "b: failed. ")):
            self.assertTrue(lines[1 + number].startswith(f"copepod: {line}"), lines)
        quiet = self.run_campaign("--quiet", code=70).splitlines()
        self.assertEqual(len(quiet), 2, quiet)
        self.assertTrue(quiet[0].startswith("copepod: b: failed. "), quiet)

    def test_one_campaign_at_a_time_in_a_folder(self):
        self.write_case("a", steps=3000)
        first = self.start("campaign", "campaign.json", "--out", "out")
        first.wait_for("a: starts")
        self.assertIn("is in use", self.run_campaign(code=2))
        first.process.send_signal(signal.SIGTERM)
        self.assertEqual(first.end(timeout_s=30), 143)
        self.assertIn("copepod: a: stopped\n", first.stderr)


class HowFar(unittest.TestCase):
    """A campaign of four cases: one is done, one runs, one waits, one failed."""

    def setUp(self):
        from copepod_campaign.cases import State
        from copepod_campaign.pool import Pool
        from copepod_run import messages

        self.messages = messages
        states = (State.DONE, State.RUNNING, State.NEW, State.FAILED)
        entries = [mock.Mock(state=state, weight=10.0) for state in states]
        self.pool = Pool("paper", entries, 2, mock.Mock(), None, False)
        self.pool._waiting = entries[2:3]
        entries[1].name = "design_d"
        job = mock.Mock(entry=entries[1], share=0.5, weight_per_s=0.5, remaining_s=10.0)
        self.pool.running.append(job)
        self.stream = self.enterContext(contextlib.redirect_stderr(io.StringIO()))

    def test_line_has_the_share_the_time_left_and_what_runs(self):
        self.assertEqual(self.pool.line(), "paper: 62 %, 1 of 4 done, 0:20 left; design_d 50 %")

    def test_line_comes_once_a_minute(self):
        with mock.patch("time.monotonic", side_effect=itertools.count(self.pool._next_line - 1, 1)):
            for _ in range(20):
                self.pool._show()
        self.assertEqual(self.stream.getvalue().count("copepod: paper: 62 %"), 1)

    def test_line_is_redrawn_on_a_terminal(self):
        self.stream.isatty = lambda: True
        with mock.patch.dict("os.environ", TERM="xterm"):
            self.pool._show()
        self.assertEqual(self.stream.getvalue(), f"\rcopepod: {self.pool.line()}\033[K")

    def test_programs_get_events_that_count_cases(self):
        self.addCleanup(self.messages.speak, self.messages.Voice.LINES)
        self.messages.speak(self.messages.Voice.JSON)
        self.pool._show()
        event = {"event": "progress", "step": 1, "steps": 4, "share": 0.625, "remaining_s": 20.0}
        self.assertEqual(json.loads(self.stream.getvalue()), event)


class Forecast(unittest.TestCase):
    class Running:
        def __init__(self, weight, share, weight_per_s):
            self.entry = type("Entry", (), {"weight": weight})
            self.share = share
            self.weight_per_s = weight_per_s
            self.remaining_s = weight * (1 - share) / weight_per_s if weight_per_s else None

    def test_waiting_cases_take_the_places_that_become_free_first(self):
        from copepod_campaign.pool import remaining_s

        running = [self.Running(100, 0.5, 10), self.Running(100, 0.8, 10)]
        self.assertEqual(remaining_s(running, [], 2), 5)
        self.assertAlmostEqual(remaining_s(running, [100, 10], 2), 12)

    def test_a_job_that_has_not_told_its_speed_is_as_fast_as_the_others(self):
        from copepod_campaign.pool import remaining_s

        self.assertEqual(remaining_s([self.Running(100, 0, 10), self.Running(200, 0, None)], [], 2), 20)
        self.assertIsNone(remaining_s([self.Running(100, 0, None)], [], 1))


if __name__ == "__main__":
    unittest.main()
