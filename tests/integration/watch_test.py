"""`copepod watch`: the live page of a run that a test writes row by row."""

import contextlib
import fcntl
import http.client
import io
import json
import os
import re
import signal
import socket
import unittest
from unittest import mock
from urllib.parse import urlsplit

from browser import CHROMIUM, Browser
from copepod_session import CommandTest, wait_until
from synthetic_run import CELL_M, PERIOD, SPEED, STEP_S, write_run
from copepod_run.errors import Stop
from copepod_run.progress import Progress
from copepod_watch.follower import CampaignFollower, RunFollower, TrajectoryFollower
from copepod_watch.server import WatchServer

LAG = "swimmers.0.stroke.phase_lag_steps"


class GrowingRun:
    """A run directory whose tables grow; it is held as a running command holds it."""

    def __init__(self, folder, steps=2000):
        self.folder = folder
        self.steps = steps
        self.has_ended = False
        write_run(folder, steps=steps, mean_flow=False)
        self.ending = {name: (folder / name).read_text() for name in ("summary.json", "cycles.csv", "trajectory.csv")}
        (folder / "summary.json").unlink()
        (folder / "logs").mkdir()
        self._lock = os.open(folder, os.O_RDONLY)
        fcntl.flock(self._lock, fcntl.LOCK_EX)
        self.write_until(0)

    def write_until(self, step, half_a_row=False):
        for name, column in (("trajectory.csv", 0), ("cycles.csv", 2)):
            lines = self.ending[name].splitlines()
            rows = [row for row in lines[1:] if int(row.split(",")[column]) + (PERIOD if column else 0) <= step]
            rest = lines[len(rows) + 1][:30] if half_a_row and len(rows) + 1 < len(lines) else ""
            self._extend(name, "\n".join([lines[0], *rows]) + "\n" + rest)
        event = {"phase": "running", "step": step, "steps": self.steps, "steps_per_s": 50.0, "remaining_s": 7.0}
        self._replace("logs/progress.json", json.dumps(event))

    def _extend(self, name, content):
        """As the coupler does: what is there already stays readable."""
        with open(self.folder / name, "r+") as file:
            file.write(content)
            file.truncate()

    def _replace(self, name, content):
        """At once, as the command does: no reader sees half of it."""
        whole = self.folder / "whole"
        whole.write_text(content)
        whole.replace(self.folder / name)

    def finish(self):
        """The summary comes last, as in a run: a reader that sees it finds the tables complete."""
        for name in ("trajectory.csv", "cycles.csv"):
            self._extend(name, self.ending[name])
        self._replace("summary.json", self.ending["summary.json"])
        self.release()

    def release(self):
        self.has_ended = True
        os.close(self._lock)


class WatchTest(CommandTest):
    def watch(self, directory="run"):
        """The session of the command and the address that it prints."""
        session = self.start("watch", directory)
        wait_until(lambda: session.stdout or session.process.poll() is not None, "an address")
        self.assertTrue(session.stdout, "".join(session.stderr))
        return session, session.stdout[0].strip()

    def get(self, address, path="/", host=None, is_whole=False):
        """(status, headers, text) of a page; `path`: below the address, unless it is the whole one."""
        place = urlsplit(address)
        connection = http.client.HTTPConnection(place.hostname, place.port, timeout=60)
        self.addCleanup(connection.close)
        path = path if is_whole else place.path + path.removeprefix("/")
        connection.request("GET", path, headers={"Host": host} if host else {})
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read().decode()

    def state(self, address, path="/state"):
        status, _, text = self.get(address, path)
        self.assertEqual(status, 200, text)
        return json.loads(text)

    def cells(self, table):
        """The texts of the cells of every row below the head, without their elements."""
        rows = re.findall("<tr>(.*?)</tr>", table, re.DOTALL)[1:]
        return [[re.sub("<[^>]*>", "", cell) for cell in re.findall("<td>(.*?)</td>", row, re.DOTALL)] for row in rows]


class Server(WatchTest):
    def test_progress_motion_and_speeds_appear_while_the_run_writes(self):
        run = GrowingRun(self.folder / "run")
        run.write_until(20)
        session, address = self.watch()
        first = self.state(address)
        self.assertEqual((first["state"], first["step"], first["steps"]), ("running", 20, 2000))
        self.assertEqual(first["figures"][0], "0:07 left")
        self.assertEqual(first["scene"]["motion"]["steps"], [0, 20])
        self.assertEqual(first["speeds"], "")

        run.write_until(900, half_a_row=True)
        second = self.state(address, f"/state?have={first['version']}")
        self.assertEqual(second["scene"]["motion"]["steps"][-1], 900)
        self.assertEqual(self.cells(second["speeds"])[0][1], "2")
        self.assertIsNone(self.state(address, f"/state?have={second['version']}")["scene"])

        run.finish()
        last = self.state(address, f"/state?have={second['version']}")
        self.assertEqual((last["state"], last["sentence"]), ("finished", "Finished after 2000 steps."))
        self.assertEqual(last["scene"]["motion"]["steps"][-1], 2000)
        session.wait_for("finished; the page stays until Ctrl-C.")
        session.process.send_signal(signal.SIGINT)
        self.assertEqual(session.end(), 130)

    def test_the_end_of_a_run_is_announced_to_those_who_have_not_opened_the_page(self):
        run = GrowingRun(self.folder / "run")
        run.write_until(20)
        session, _ = self.watch()
        run.finish()
        session.wait_for("finished; the page stays until Ctrl-C.")

    def test_only_this_machine_and_its_own_names_are_served(self):
        GrowingRun(self.folder / "run").release()
        session, address = self.watch()
        port = urlsplit(address).port
        for host in ("evil.example", f"evil.example:{port}", "127.0.0.1.evil.example", ""):
            self.assertEqual(self.get(address, host=host or " ")[0], 403, host)
        for host in (f"127.0.0.1:{port}", f"localhost:{port}", "LOCALHOST"):
            self.assertEqual(self.get(address, host=host)[0], 200, host)
        with open(f"/proc/{session.process.pid}/net/tcp") as file:
            listening = [line.split()[1] for line in file if line.split()[3] == "0A"]
        self.assertIn(f"0100007F:{port:04X}", listening)
        self.assertNotIn(f"00000000:{port:04X}", listening)

    def test_who_does_not_know_the_whole_address_reads_nothing(self):
        GrowingRun(self.folder / "run").release()
        _, address = self.watch()
        token = urlsplit(address).path.strip("/")
        self.assertGreater(len(token), 20)
        for path in ("/", "/state", "/report", f"/{token}", f"/{token[:-1]}/", f"/{token[:-1]}_/state", "//state"):
            self.assertEqual(self.get(address, path, is_whole=True)[0], 404, path)
        self.assertEqual(self.get(address, f"/{token}/state", is_whole=True)[0], 200)

    def test_nothing_but_the_page_is_served(self):
        GrowingRun(self.folder / "run").release()
        _, address = self.watch()
        for path in ("/case.yaml", "/logs/progress.json", "/../run/case.yaml", "/%2e%2e/run/state", "/state/"):
            self.assertEqual(self.get(address, path)[0], 404, path)
        status, headers, text = self.get(address)
        self.assertEqual(status, 200)
        self.assertIn("default-src 'none'", headers["Content-Security-Policy"])
        self.assertNotRegex(text, r"https?://")

    def test_many_swimmers_share_the_mean_of_the_cycles_that_all_have(self):
        for shift, last, line in ((0, "4 m/s", "3.0,8.5 157.0,3.0 "), (-5, "-1 m/s", "3.0,25.0 157.0,14.0 ")):
            of = [(swimmer, cycle) for swimmer in range(7) for cycle in range(2 + swimmer % 2)]
            rows = [f"s{swimmer},{cycle},{swimmer + cycle + shift},1" for swimmer, cycle in of]
            table = "\n".join(["swimmer,cycle,u_along_m_per_s,u_across_m_per_s", *rows]) + "\n"
            (self.folder / "cycles.csv").write_text(table)
            speeds = RunFollower(self.folder, {}, 0).content()["speeds"]
            self.assertEqual(self.cells(speeds), [["mean of 7", "2", last, "1 m/s", ""]])
            self.assertIn(f'points="{line}"', speeds)  # of 3 and 4 above zero, or −2 and −1 below it

    def test_a_run_that_was_killed_is_not_called_running(self):
        run = GrowingRun(self.folder / "run")
        run.write_until(900)
        _, address = self.watch()
        self.assertEqual(self.state(address)["state"], "running")
        run.release()
        content = self.state(address)
        self.assertEqual((content["state"], content["figures"]), ("interrupted", []))

    def test_a_campaign_lists_its_runs(self):
        for name in ("case_1", "case_2"):
            GrowingRun(self.folder / "all" / name).release()
        _, address = self.watch("all")
        self.assertIn('<a href="case_2/">case_2</a>', self.get(address)[2])
        self.assertEqual(self.state(address, "/case_2/state")["steps"], 2000)

    def test_runs_are_listed_by_the_numbers_in_their_names(self):
        names = ["x=8e-06", "x=2.4e-05", "x=0.000128"]
        for name in names:
            GrowingRun(self.folder / "all" / name).release()
        _, address = self.watch("all")
        self.assertEqual(re.findall(r'<a href="[^"]*">([^<]*)</a>', self.get(address)[2]), names)

    def test_a_signal_while_a_connection_is_accepted_ends_the_server(self):
        GrowingRun(self.folder / "run").release()
        with WatchServer(self.folder / "run", 0) as server:
            server.process_request = mock.Mock(side_effect=Stop(143, "stopped by SIGTERM."))
            with socket.create_connection(server.server_address), self.assertRaises(Stop):
                server.serve_forever(poll_interval=0.05)

    def test_without_a_run_there_is_an_error(self):
        (self.folder / "empty").mkdir()
        for name, reason in (("nothing", "no run has been started there"), ("empty", "no case.yaml")):
            session = self.start("watch", name)
            self.assertEqual(session.end(), 2)
            self.assertIn(reason, session.last_line)

    def test_a_port_in_use_is_an_error(self):
        GrowingRun(self.folder / "run").release()
        _, address = self.watch()
        session = self.start("watch", "run", "--port", str(urlsplit(address).port))
        self.assertEqual(session.end(), 2)
        self.assertRegex(session.last_line, r"port \d+ cannot be used \(Address already in use\)")

    @unittest.skipUnless(CHROMIUM, "chromium is not installed (deploy/copepod setup --ci installs it)")
    def test_the_page_follows_the_run_to_its_end_without_reloading(self):
        run = GrowingRun(self.folder / "run")
        run.write_until(20)
        _, address = self.watch()
        with Browser() as browser:
            browser.open(address)
            browser.wait_for("document.querySelector('.stage').dataset.drawn > 0")
            self.assertIn("0:07 left", browser.value("document.querySelector('.pace').textContent"))
            browser.value("window.isTheSamePage = true")
            run.write_until(900)
            browser.wait_for("document.querySelector('.clock').textContent.endsWith('step 900')")
            browser.wait_for("document.querySelector('.speeds table') !== null")
            run.finish()
            browser.wait_for("document.querySelector('.status').textContent === 'Finished after 2000 steps.'")
            browser.wait_for("document.querySelectorAll('.report figure img').length > 3")
            self.assertTrue(browser.value("window.isTheSamePage"))
            self.assertEqual(browser.problems, [])


class Sweep(WatchTest):
    """Of five runs in an order that is not that of their names: two have finished, two are running, one is to do."""

    NAMES = ("lag=8", "lag=16", "lag=32", "lag=64", "lag=128")

    def setUp(self):
        super().setUp()
        self.sweep = self.folder / "sweep"
        self.runs = [GrowingRun(self.sweep / name) for name in self.NAMES[:4]]
        for run, name in zip(self.runs, self.NAMES):
            summary = json.loads(run.ending["summary.json"])
            summary["swimmers"][0]["u_swim_lattice"] = 1e-6 * float(name.partition("=")[2])
            run.ending["summary.json"] = json.dumps(summary)
        cases = [
            {"name": name, "member_of": "s", "parameters": {LAG: int(name.partition("=")[2])}, "summary": None}
            for name in self.NAMES
        ]
        content = {"parameters": [{"key": LAG, "scale": "linear"}], "cases": cases}
        (self.sweep / "results.json").write_text(json.dumps(content))
        for run in self.runs[:2]:
            run.finish()
        self.runs[2].write_until(900)
        self.addCleanup(lambda: [run.release() for run in self.runs if not run.has_ended])

    def test_every_run_has_state_progress_and_speed_in_the_order_of_the_sweep(self):
        _, address = self.watch("sweep")
        content = self.state(address)
        self.assertEqual(content["sentence"], "2 of 5 finished, 2 running, 1 to do.")
        self.assertAlmostEqual(content["share"], (2 + 900 / 2000) / 5)
        speed = f"{1e6 * SPEED * CELL_M / STEP_S:.4g}"
        self.assertEqual(
            self.cells(content["table"]),
            [
                ["lag=8", "finished", " 100 %", speed, "8"],
                ["lag=16", "finished", " 100 %", speed, "16"],
                ["lag=32", "running", " 45 %0:07 left", speed, "32"],
                ["lag=64", "running", " 0 %0:07 left", "", "64"],
                ["lag=128", "to do", " 0 %", "", "128"],
            ],
        )
        self.assertEqual(self.get(address, "/lag%3D128/state")[0], 404)

    def test_the_figure_is_that_of_the_report_and_is_sent_once(self):
        _, address = self.watch("sweep")
        first = self.state(address)
        session = self.start("report", "sweep", "--out", "report")
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        picture = r"<picture>.*?</picture>"
        report = (self.folder / "report/report.html").read_text()
        self.assertEqual(re.search(picture, first["figures"])[0], re.search(picture, report)[0])
        self.assertIsNone(self.state(address, f"/state?have={first['version']}")["figures"])

    def test_figures_are_drawn_for_new_results_only(self):
        drawn = []
        follower = CampaignFollower(self.sweep, lambda runs: drawn.append(len(runs)) or [])
        for finishes in (False, False, True, False):
            if finishes:
                self.runs[2].finish()
            follower.content()
        self.assertEqual(drawn, [2, 3])

    def test_a_run_that_ended_before_it_wrote_its_case_has_failed(self):
        content = json.loads((self.sweep / "results.json").read_text())
        content["cases"][4]["state"] = "failed"
        (self.sweep / "results.json").write_text(json.dumps(content))
        follower = CampaignFollower(self.sweep, lambda runs: [])
        self.assertEqual(follower.content()["sentence"], "2 of 5 finished, 2 running, 1 failed.")

    @unittest.skipUnless(CHROMIUM, "chromium is not installed (deploy/copepod setup --ci installs it)")
    def test_the_page_grows_with_the_runs_without_reloading(self):
        _, address = self.watch("sweep")
        with Browser(width=390) as browser:
            browser.open(address)
            browser.wait_for("document.querySelector('.answer img')?.naturalWidth > 0")
            self.assertEqual(browser.value("document.title"), "49 %: sweep")
            self.assertLessEqual(browser.value("document.documentElement.scrollWidth"), 390)
            before = browser.value("document.querySelector('.answer img').src")
            browser.value("window.isTheSamePage = document.querySelector('td a')")
            self.runs[2].finish()
            browser.wait_for("document.querySelector('.status').textContent.startsWith('3 of 5 finished')")
            browser.wait_for(f"document.querySelector('.answer img').src !== '{before}'")
            self.assertTrue(browser.value("window.isTheSamePage === document.querySelector('td a')"))
            self.assertEqual(
                {url.partition("?")[0] for url in browser.requests if not url.startswith("data:")},
                {address, f"{address}state"},
            )
            self.assertEqual(browser.problems, [])


class Following(WatchTest):
    def test_a_file_that_a_resumed_run_cuts_is_read_anew(self):
        run = GrowingRun(self.folder / "run")
        follower = TrajectoryFollower(self.folder / "run")
        run.write_until(1000)
        follower.update()
        run.ending["trajectory.csv"] = re.sub(r"^(\d+),", r"\g<1>,", run.ending["trajectory.csv"])
        run.write_until(200)
        follower.update()
        self.assertEqual(follower.samples().steps[-1], 200)
        run.release()

    def test_long_trajectories_are_thinned_evenly_and_keep_the_newest_sample(self):
        run = GrowingRun(self.folder / "run", steps=60020)
        follower = TrajectoryFollower(self.folder / "run")
        for step in (19990, 60020):
            run.write_until(step)
            follower.update()
        steps = follower.samples().steps
        self.assertLess(len(steps), 2002)
        self.assertEqual((steps[0], steps[-1]), (0, 60020))
        self.assertEqual(len(set(steps[1:-1] - steps[:-2])), 1)
        run.release()

    def test_a_run_records_its_progress_and_survives_a_lost_folder(self):
        path = self.folder / "logs/progress.json"
        progress = Progress(0, path, clock=lambda: 1.0)
        shown = self.enterContext(contextlib.redirect_stderr(io.StringIO()))
        progress.phase("running")  # its folder does not exist
        path.parent.mkdir()
        for step in (0, 1, 2, 3):
            progress.step({"event": "progress", "step": step, "steps": 3, "steps_per_s": 0.0})
        lines = ["running", "step 0 of 3 (0 %)", "step 3 of 3 (100 %)"]
        self.assertEqual(shown.getvalue().splitlines(), [f"copepod: {line}" for line in lines])
        self.assertEqual(json.loads(path.read_text())["phase"], "running")
        self.assertEqual(json.loads(path.read_text())["step"], 3)


if __name__ == "__main__":
    unittest.main()
