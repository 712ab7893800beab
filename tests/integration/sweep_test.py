"""Sweeps: their names, tables, checks and figures, and the one in docs/your_first_own_swimmer.md as its page shows."""

import base64
import csv
import json
import math
import re
import shlex
import unittest
from itertools import zip_longest

import numpy as np
from matplotlib import image

from browser import CHROMIUM, Browser
from copepod_session import ROOT, CommandTest, WholeRunTest
from synthetic_run import write_run
from copepod_campaign import cases
from copepod_report import sweeps
from copepod_report.run_record import collect, name_apart
from copepod_report.style import LIGHT
from copepod_run.names import distinct_folders, distinct_words, quantity_of, short_keys

PNG = b"\x89PNG\r\n\x1a\n"
DISTANCES = ("swimmers.0.center_m.0", "swimmers.0.phase")
PRINTED = {17.8: "u_swim_lattice.pdf", 8.6: "u_swim_lattice_column.pdf"}  # by width in centimetres
BOX = "document.querySelector('.scroll')"
LAG, AMPLITUDE = "swimmers.0.stroke.phase_lag_steps", "swimmers.0.stroke.amplitude_N"


class Names(unittest.TestCase):
    def test_keys_are_as_short_as_they_stay_apart(self):
        self.assertEqual(short_keys([LAG, AMPLITUDE]), {LAG: "phase_lag_steps", AMPLITUDE: "amplitude_N"})
        arms = [f"swimmers.0.arms.{arm}.drive.signal.lag_deg" for arm in (0, 1)]
        self.assertEqual(list(short_keys(arms).values()), [arm.removeprefix("swimmers.0.") for arm in arms])
        self.assertEqual(short_keys(["swimmers.1.center_m.0"]), {"swimmers.1.center_m.0": "center_m.0"})
        self.assertEqual(list(short_keys(["run.steps", "steps"]).values()), ["run.steps", "steps"])

    def test_folders_differ_even_where_case_does_not_count_and_in_any_order(self):
        names = ["s_solver=Own", "s_solver=own", "s_v=1/2", "s_v=1 2", "s_lag=0.1", "plain"]
        first = distinct_folders(names, names, ["PLAIN"])
        self.assertEqual(first[4], "s_lag=0.1")
        self.assertEqual(len({name.casefold() for name in [*first, "PLAIN"]}), 7)
        self.assertTrue(all(re.fullmatch(r"[\w.+=-]+", name) for name in first), first)
        self.assertEqual(distinct_folders(names[::-1], names[::-1], ["PLAIN"]), first[::-1])

    def test_members_get_such_folders_and_single_cases_keep_their_names(self):
        named = (("s_v=1/2", {"v": "1/2"}), ("plain", {}), ("s_v=0", {"v": 0}))
        members = [cases.Member(name, "s", "s.yaml", (), parameters, {}, None) for name, parameters in named]
        self.assertEqual([member.name for member in cases._named(members)], ["s_v=1_2", "plain", "s_v=0"])

    def test_long_names_are_cut_and_stay_apart(self):
        folders = distinct_folders(["é" * 200 + "1", "é" * 200 + "2"], ["1", "2"])
        self.assertEqual(len(set(folders)), 2)
        self.assertLessEqual(max(len(folder.encode()) for folder in folders), 120)

    def test_words_of_links_differ_whatever_the_names_are(self):
        names = ["x_3", "x!", "x?", "X", "α", "β", "v=1.5", "v=1+5"]
        words = distinct_words(names)
        self.assertEqual(len({word.casefold() for word in words}), len(names), words)
        self.assertTrue(all(words), words)
        self.assertEqual(distinct_words(["x", "X", "x"]), ["x", "X_2", "x_3"])

    def test_units_are_in_the_names_of_keys(self):
        for key, expected in {
            "phase_lag_rad": ("phase lag", "rad"),
            "velocity_m_per_s": ("velocity", "m/s"),
            "kinematic_viscosity_m2_per_s": ("kinematic viscosity", "m²/s"),
            "damping_N_s_per_m": ("damping", "N s/m"),
            "stiffness_N_m_per_rad": ("stiffness", "N m/rad"),
            "center_m.0": ("x of the center", "m"),
            "axis.2": ("z of the axis", ""),
            "domain_cells.1": ("y of the domain", "cells"),
            "rest_gap_m.1": ("rest gap 1", "m"),
            "lag_deg": ("lag", "°"),
            "solver": ("solver", ""),
            "m": ("m", ""),
        }.items():
            self.assertEqual(quantity_of(key), expected)


class FakeSweep(CommandTest):
    """With components without physics: what the command makes of the members."""

    def write_case(self, name, sweep=None, **keys):
        content = {"name": name, "steps": 2, "step_s": 0.001, "case": {"run": {"steps": 2}}, **keys}
        if sweep:
            content["sweep"] = sweep
        (self.folder / f"{name}.json").write_text(json.dumps(content))

    @staticmethod
    def sweep(key, *values, scale="linear"):
        ending = key.rpartition(".")[2]
        members = [{"values": [v], "set": [f"{ending}={json.dumps(v)}", "sweep=null"]} for v in values]
        return {"combine": "grid", "parameters": [{"key": key, "scale": scale}], "members": members}

    def finish(self, *arguments, code=0):
        session = self.start(*arguments)
        self.assertEqual(session.end(timeout_s=60), code, "".join(session.stderr))
        return "".join(session.stderr), "".join(session.stdout)

    def test_swept_keys_are_columns_and_empty_columns_are_left_out(self):
        kinematics = {"cycle": 1, "arms": [], "tilt_rad": 0.0, "u_along_um_per_s": 7.5}
        self.write_case(
            "lags", self.sweep("run.steps", 2, 3), summary={"swimmers": [{"name": "s", "kinematics": kinematics}]}
        )
        self.finish("run", "lags.json", "--out", "out")
        rows = list(csv.DictReader((self.folder / "out/results.csv").read_text().splitlines()))
        self.assertEqual([(row["case"], row["steps"]) for row in rows], [("lags_steps=2", "2"), ("lags_steps=3", "3")])
        self.assertTrue(all(row[column] for row in rows for column in rows[0]), rows)
        self.assertNotIn("swimmer", rows[0])
        self.assertIn(
            "| case | steps | state | u along [µm/s] | tilt [rad] |\n", (self.folder / "out/results.md").read_text()
        )
        content = json.loads((self.folder / "out/results.json").read_text())
        self.assertEqual(content["parameters"], [{"key": "run.steps", "name": "steps", "scale": "linear"}])
        case = content["cases"][1]
        self.assertEqual(
            (case["name"], case["member_of"], case["parameters"]), ("lags_steps=3", "lags", {"run.steps": 3})
        )
        self.assertTrue((self.folder / "out/lags_steps=3/summary.json").exists())

    def test_a_longer_sweep_keeps_the_runs_that_are_there(self):
        self.write_case("lags", self.sweep("run.steps", 2, 4))
        self.finish("run", "lags.json", "--out", "out")
        self.write_case("lags", self.sweep("run.steps", 2, 3, 4))
        self.assertIn("3 cases, 2 done already", self.finish("run", "lags.json", "--out", "out")[0])

    def test_sweeps_of_one_campaign_with_keys_of_one_name_have_columns_of_their_own(self):
        self.write_case("a", self.sweep("one.steps", 2, 3))
        self.write_case("b", self.sweep("two.steps", 2, 3))
        (self.folder / "both.json").write_text(json.dumps({"name": "both", "cases": ["a", "b"]}))
        self.finish("campaign", "both.json", "--out", "out")
        rows = list(csv.DictReader((self.folder / "out/results.csv").read_text().splitlines()))
        self.assertEqual([row["case"] for row in rows], ["a_steps=2", "a_steps=3", "b_steps=2", "b_steps=3"])
        self.assertEqual([row["two.steps"] for row in rows], ["", "", "2", "3"])

    def test_a_refused_campaign_leaves_no_folder_and_names_every_bad_case_once(self):
        self.write_case("a")
        self.write_case("b", errors=["no such key", "no unit"])
        self.write_case("c", errors=["no such key"], fluid="/bin/true")
        (self.folder / "all.json").write_text(json.dumps({"name": "all", "cases": ["a", "b", "c"]}))
        for command in (("campaign", "all.json", "--out", "out"), ("campaign", "all.json"), ("check", "all.json")):
            said, _ = self.finish(*command, code=2)
            self.assertIn("b: b.json:1: error: no such key\n", said)
            self.assertIn("c: c.json:1: error: no such key\n", said)
            self.assertIn("2 of 3 cases cannot run.", said)
        self.assertEqual(
            sorted(path.name for path in self.folder.iterdir()), ["a.json", "all.json", "b.json", "c.json"]
        )

    def test_members_that_cannot_run_are_counted_with_the_others(self):
        self.write_case("a", self.sweep("errors", [], ["no such key"], ""))
        said, _ = self.finish("run", "a.json", code=2)
        self.assertIn("1 of 3 cases cannot run.", said)

    def test_a_campaign_whose_component_is_not_one_leaves_no_folder(self):
        self.write_case("a")
        self.write_case("b", fluid="/bin/true")
        (self.folder / "all.json").write_text(json.dumps({"name": "all", "cases": ["a", "b"]}))
        self.assertIn("b: /bin/true cannot be used as fluid", self.finish("campaign", "all.json", code=2)[0])
        self.assertFalse((self.folder / "runs").exists())

    def test_settings_of_the_command_line_reach_every_case_of_a_campaign(self):
        self.write_case("a")
        self.write_case("b", self.sweep("run.number", 1, 2))
        (self.folder / "both.json").write_text(json.dumps({"name": "both", "cases": ["a", "b"]}))
        self.finish("campaign", "both.json", "--out", "out", "--set", "steps=7")
        for name in ("a", "b_number=1", "b_number=2"):
            self.assertEqual(json.loads((self.folder / f"out/{name}/summary.json").read_text())["steps"], 7)

    def test_check_of_a_campaign_looks_at_every_member_and_estimates_the_whole(self):
        self.write_case("a", steps=10)
        self.write_case("b", self.sweep("run.steps", 20, 30), warnings=["warning: short"])
        (self.folder / "both.json").write_text(json.dumps({"name": "both", "cases": ["a", "b"]}))
        printed = self.finish("check", "both.json")[1]
        self.assertIn("both.json: both, 3 runs, 60 steps\n", printed)
        self.assertRegex(
            printed, r"  time +(unknown: nothing like them has finished on this machine yet|about \d+ s, 2 at once)\n"
        )
        self.assertRegex(printed, r"  b +2 runs: steps 20 to 30 \(2 values\)\n")
        self.assertRegex(printed, r"  cases without a sweep +1\n")
        self.assertRegex(printed, r"  cell updates +60000\n")
        self.assertIn("b_steps=20 and 1 other: warning: short\n", printed)
        self.assertTrue(printed.endswith("ok\n"))
        self.assertFalse((self.folder / "runs").exists())

    def test_a_case_is_not_run_as_a_campaign_nor_a_campaign_as_a_case(self):
        self.write_case("a")
        (self.folder / "all.json").write_text(json.dumps({"name": "all", "cases": ["a"]}))
        self.assertIn("a.json is a case (it lists no cases).", self.finish("campaign", "a.json", code=2)[0])
        self.assertIn("all.json is a campaign (a list of cases).", self.finish("run", "all.json", code=2)[0])


class ReportOfASweep(CommandTest):
    """Of synthetic runs, whose speed is known."""

    def write_sweep(self, values, names, scales=("linear", "linear"), keys=(LAG, AMPLITUDE), changes=()):
        """`values`: of lag and amplitude, or other keys; the speed is their product, `changes` what it changed by."""
        cases = []
        for (lag, amplitude), name, change in zip_longest(values, names, changes):
            write_run(self.folder / "sweep" / name, steps=200, mean_flow=False)
            path = self.folder / "sweep" / name / "summary.json"
            summary = json.loads(path.read_text())
            summary["swimmers"][0]["u_swim_lattice"] = lag * amplitude
            summary["swimmers"][0]["d1_cells"] = 2.5 + lag if changes else 2.5
            last = {"change_from_last_cycle": {"velocity": change}, "u_along_mean_um_per_s": lag * amplitude}
            summary["swimmers"][0]["kinematics"] = last
            path.write_text(json.dumps(summary))
            parameters = dict(zip(keys, (lag, amplitude)))
            cases.append({"name": name, "member_of": "s", "parameters": parameters, "summary": {}})
        heads = [{"key": key, "scale": scale} for key, scale in zip(keys, scales)]
        (self.folder / "sweep/results.json").write_text(json.dumps({"parameters": heads, "cases": cases}))

    def report(self, *options):
        session = self.start("report", "sweep", "--out", "report", *options)
        self.assertEqual(session.end(timeout_s=100), 0, "".join(session.stderr))
        return (self.folder / "report/report.html").read_text()

    def read(self, **choice):
        runs = collect(self.folder / "sweep", lambda path: json.loads(path.read_text())["case"])
        name_apart(runs)
        (sweep,) = sweeps.sweeps_of(runs, **choice)
        return sweep

    def write_distances(self, count=3):
        """From a wall, with another distance for each factor; the second run of each three still changes."""
        distances = [8e-6 * 2**number for number in range(count)]
        values = [(distance, factor) for distance in distances for factor in (1, 3)]
        names = [f"wall_{number}" for number in range(len(values))]
        self.write_sweep(values, names, keys=DISTANCES, changes=[2e-4, 2e-3, None] * (len(values) // 3))

    def test_links_of_the_table_lead_to_the_run_of_their_row(self):
        names = ["x_3", "x!", "x?", "X", "α", "β", "v=1.5", "v=1+5", *"abcde"]  # too many for figures of their own
        self.write_sweep([(lag, 1e-5) for lag in range(len(names))], names)
        text = self.report()
        links = re.findall(r'<a href="#([^"]*)">([^<]*)</a>', text)
        self.assertEqual([name for _, name in links], names)
        for anchor, name in links:
            self.assertEqual(len(re.findall(f'id="{re.escape(anchor)}"', text)), 1, anchor)
            section = next(part for part in text.split("<section") if f'id="{anchor}"' in part)
            self.assertIn(f"<h2>{name}</h2>", section)
            self.assertIn(f"report {shlex.quote(f'sweep/{name}')}</p>".replace("'", "&#39;"), section)

    def test_every_result_is_drawn_over_the_swept_keys(self):
        values = [(lag, amplitude) for lag in (0, 1, 2) for amplitude in (1e-6, 1e-5)]
        self.write_sweep(values, [f"s_{number}" for number in range(6)])
        for path in (self.folder / "sweep").glob("*/summary.json"):
            flow = [{"name": "fx_N", "mean": float(path.parent.name[-1]), "rms": 0.5, "min": 0.0, "max": 1.0}]
            flow.append({"name": "fy_N", "note": "the run ended before step 70"})
            path.write_text(json.dumps(json.loads(path.read_text()) | {"flow": flow}))
        text = self.report()
        self.assertIn("<th>phase lag [steps]</th><th>amplitude [µN]</th>", text)
        for name in ("s_u_swim_lattice", "s_u_swim_lattice_map", "s_flow_fx_N"):
            self.assertTrue((self.folder / f"report/{name}.png").read_bytes().startswith(PNG))
        self.assertFalse((self.folder / "report/s_d1_cells.png").exists())  # does not vary

    def test_curves_and_map_hold_the_values_on_the_scale_of_the_range(self):
        values = [(lag, amplitude) for lag in (0, 1, 2) for amplitude in (1e-6, 1e-5)][::-1]
        self.write_sweep(values, [f"s_{number}" for number in range(6)], ("linear", "logarithmic"))
        runs = collect(self.folder / "sweep", lambda path: json.loads(path.read_text())["case"])
        (sweep,) = sweeps.sweeps_of(runs)
        (result,) = sweep.results
        axes = sweeps.curves(sweep, result).axes[0]
        self.assertEqual(axes.get_xlabel(), "phase lag [steps]")
        self.assertEqual([line.get_label() for line in axes.lines], ["amplitude 1 µN", "amplitude 10 µN"])
        self.assertEqual([tuple(line.get_ydata()) for line in axes.lines], [(0, 1e-6, 2e-6), (0, 1e-5, 2e-5)])
        drawn = sweeps.colour_map(sweep, result).axes[0]
        self.assertEqual((drawn.get_xscale(), drawn.get_yscale()), ("linear", "log"))
        self.assertEqual(drawn.get_ylabel(), "amplitude [µN]")
        self.assertEqual(drawn.collections[0].get_array().tolist(), [0, 1e-6, 2e-6, 0, 1e-5, 2e-5])

    def test_page_begins_with_one_figure_then_table_then_the_others_with_what_can_be_saved(self):
        self.write_distances()
        text = self.report()
        self.assertEqual(
            re.findall(r'<(source|table|figure class="wide"|figure|h2)[ >]', text)[:6],
            ['figure class="wide"', "source", "h2", "table", "figure", "figure"],
        )
        self.assertIn("<th>x of the center [µm]</th><th>phase</th>", text)
        self.assertIn("</td><td>8</td><td>1</td><td>8e-06</td>", text)
        self.assertIn("<dt>x of the center</dt><dd>32 µm</dd>", text)
        table = (
            "run,x of the center [µm],phase,u_swim [cells/step],change in last cycle [%]\n"
            "wall_0,8.0,1.0,8e-06,0.02\n"
            "wall_1,8.0,3.0,2.4e-05,0.2\n"
            "wall_2,16.0,1.0,1.6e-05,\n"
        )
        saved = dict(re.findall(r'download="([^"]*)" href="data:([^"]*)"', text))
        self.assertEqual(
            list(saved), [f"s_{name}" for name in ("u_swim_lattice.csv", *PRINTED.values(), "d1_cells.csv")]
        )
        for name, address in saved.items():
            content = (self.folder / "report" / name).read_bytes()
            kind, _, packed = address.partition(";base64,")
            self.assertEqual(
                (kind, base64.b64decode(packed)), (f"{'application/pdf' if '.pdf' in name else 'text/csv'}", content)
            )
        self.assertTrue((self.folder / "report/s_u_swim_lattice.csv").read_text().startswith(table))
        for width_cm, name in PRINTED.items():
            content = (self.folder / f"report/s_{name}").read_bytes()
            width = float(re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ", content)[1])
            self.assertAlmostEqual(width / 72 * 2.54, width_cm, places=3)
            self.assertIn(b"/FontFile2", content)

    def test_options_choose_the_first_figure(self):
        self.write_distances()
        for options, first in {
            (): "s: u_swim [cells/step] over x of the center, a curve for each value of phase.",
            ("--y", "d1"): "s: d1 [cells] over x of the center, a curve for each value of phase.",
            ("--x", "phase", "--y", "d1_cells"): "s: d1 [cells] over phase, a curve for each value of x of the center.",
        }.items():
            sweep = self.read(**{key[2:]: value for key, value in zip(options[::2], options[1::2])})
            self.assertTrue(sweeps.caption(sweep, sweep.results[0], is_map=False).startswith(first[:-1]), first)
        self.assertIn(
            "<figcaption>s: d1 [cells] over phase, ", self.report("--x", "phase", "--y", "d1").partition("<h2>")[0]
        )
        for folder, option, names in (
            ("sweep", "--x", f"{', '.join(DISTANCES)}."),
            ("sweep", "--y", "u_swim_lattice, d1_cells."),
            ("sweep/wall_0", "--y", "nothing."),
        ):
            session = self.start("report", folder, "--out", "other", option, "swim")
            self.assertEqual(session.end(timeout_s=100), 2)
            self.assertIn(f"{option} swim does not vary in these runs. What does: {names}", "".join(session.stderr))

    def test_values_that_still_change_have_hollow_markers_and_a_line_below(self):
        self.write_distances()
        sweep = self.read()
        result = sweep.results[0]
        lines = sweeps.curves(sweep, result).axes[0].lines
        hollow = [line for line in lines if line.get_markerfacecolor() == LIGHT.paper]
        self.assertEqual([list(zip(*line.get_data())) for line in hollow], [[(32.0, 3.2e-5)], [(8.0, 2.4e-5)]])
        self.assertIn(
            "Hollow markers: not periodic yet; the velocity changed by more than 0.1 % in the last cycle of 2 of 6 "
            "runs, at most by 0.2 %.",
            sweeps.caption(sweep, result, is_map=False),
        )
        self.assertEqual(len(sweeps.colour_map(sweep, result).axes[0].lines[0].get_xdata()), 2)

    def test_curves_that_coincide_are_seen(self):
        self.write_sweep([(lag, amplitude) for lag in (1, 2, 3) for amplitude in (1e-6, 1e-5, 2e-5)], list("abcdefghi"))
        sweep = self.read()
        lines = sweeps.curves(sweep, sweep.results[0]).axes[0].lines
        self.assertEqual(len({line.get_marker() for line in lines}), 3)
        sizes = [line.get_markersize() for line in lines]
        self.assertEqual(sizes, sorted(set(sizes), reverse=True))

    def test_axes_are_logarithmic_where_values_are_geometric_with_ticks_at_the_values(self):
        for values, ticks in {
            (8e-6, 16e-6, 32e-6, 64e-6, 128e-6): ["8", "16", "32", "64", "128"],
            (1.33333333e-6, 2e-5, 3e-4): ["1.333", "20", "300"],
            (1e-6, 2e-6, 5e-6, 10e-6): ["1", "2", "5", "10"],
            (1e-6, 2e-6, 3e-6, 4e-6): None,
            (3e-5, 4.5e-5, 9e-5, 12e-5): None,
            (0.0, 1e-6, 10e-6): None,
            (1e-6, 2e-6): None,
        }.items():
            axis = sweeps.Axis("a", "a", False, 1e6 * np.array(values), [], "a", "µm")
            self.assertEqual(axis.is_logarithmic, ticks is not None, values)
            if ticks:
                record = sweeps.SweepRecord("s", values, [axis], [])
                axes = sweeps.curves(record, sweeps.Result("u", "u", 1e-5 * axis.places, 0 * axis.places)).axes[0]
                self.assertEqual([tick.get_text() for tick in axes.get_xticklabels()], ticks)
                self.assertEqual(list(axes.get_xticks(minor=True)), [])
                axes.figure.draw_without_rendering()
                self.assertEqual(axes.yaxis.get_offset_text().get_text(), "")

    def test_ticks_of_an_axis_are_written_alike(self):
        for places, texts in {
            (5e-5, 1e-4, 1.5e-4): ["5e−05", "1e−04", "1.5e−04"],
            (-2e-7, 1e-22, 2e-7): ["−2e−07", "0", "2e−07"],
            (-0.5, 5.5e-17, 0.5): ["−0.5", "0", "0.5"],
            (19880, 19882.5, 19885): ["19880", "19882.5", "19885"],
        }.items():
            axis = sweeps.Axis("a", "a", False, np.arange(3.0), [], "a", "")
            result = sweeps.Result("u", "u", np.array(places), np.zeros(3))
            axes = sweeps.curves(sweeps.SweepRecord("s", "abc", [axis], [result]), result).axes[0]
            self.assertEqual(axes.yaxis.get_major_formatter().format_ticks(places), texts)

    def test_places_of_steps_have_all_their_digits(self):
        axis = sweeps.Axis("run.steps", "steps", False, np.array([1234567.0, 0.25, math.nan]), [], "steps", "")
        self.assertEqual([axis.number(place) for place in axis.places], ["1234567", "0.25", ""])

    @unittest.skipUnless(CHROMIUM, "there is no chromium")
    def test_page_does_not_scroll_sideways_and_its_table_shows_where_it_goes_on(self):
        names = [f"{'x' * 90}_{number}" for number in range(24)]
        self.write_sweep([(lag, 1e-5) for lag in range(24)], names, changes=[1.0] * 24)
        self.report()
        for width, dark in ((390, False), (390, True), (800, False), (800, True)):
            with self.subTest(width=width, dark=dark), Browser(width=width, height=2000, dark=dark) as browser:
                browser.open(f"file://{self.folder / 'report/report.html'}")
                self.assertLessEqual(browser.value("document.documentElement.scrollWidth"), width)
                self.assertTrue(browser.value(f"{BOX}.scrollWidth > {BOX}.clientWidth"))
                box = browser.value(f"{BOX}.getBoundingClientRect().toJSON()")
                self.assertLess(box["height"], 600)
                right, bottom = int(box["right"]), int(box["bottom"])
                edges = {
                    "scrollLeft": np.s_[bottom - 300 : bottom - 20, right - 2],
                    "scrollTop": np.s_[bottom - 2, 250 : right - 20],
                }
                for direction, edge in edges.items():
                    colours = []
                    for _ in range(2):
                        browser.screenshot(self.folder / "page.png")
                        picture = image.imread(self.folder / "page.png")[..., :3]
                        colours.append(np.median(picture[edge], axis=0) - picture[2, 2])
                        browser.value(f"{BOX}.{direction} = 1e6")
                    self.assertGreater(np.abs(colours[0]).max(), 0.1, direction)
                    self.assertLess(np.abs(colours[1]).max(), 0.1 * np.abs(colours[0]).max() + 0.005, direction)
                head = browser.value(f"{BOX}.querySelector('th').getBoundingClientRect().toJSON()")
                self.assertEqual((round(head["left"]), round(head["top"])), (round(box["left"]), round(box["top"])))

    def test_a_member_that_has_not_finished_is_on_the_page_but_in_no_curve(self):
        self.write_sweep([(1, 1e-5), (2, 1e-5), (3, 1e-5)], ["a", "b", "c"])
        (self.folder / "sweep/b/summary.json").unlink()
        ending = {"status": "failed", "exit_code": 70, "exit_reason": "it diverged", "end": "2026-01-01"}
        (self.folder / "sweep/b/provenance.json").write_text(json.dumps(ending))
        path = self.folder / "sweep/results.json"
        content = json.loads(path.read_text())
        content["cases"][1]["summary"] = None
        path.write_text(json.dumps(content))
        self.assertIn("it diverged", self.report())
        runs = collect(self.folder / "sweep", lambda path: json.loads(path.read_text())["case"])
        self.assertEqual([run.name for run in runs], ["design_a"] * 3)
        (sweep,) = sweeps.sweeps_of(runs)
        self.assertEqual(sweep.results[0].values.tolist(), [1e-5, 3 * 1e-5])

    def test_pairs_of_values_are_one_curve_and_words_have_ticks(self):
        self.write_sweep([(2, 1e-5), (1, 2e-5), (3, 4e-5)], ["a", "b", "c"])
        runs = collect(self.folder / "sweep", lambda path: json.loads(path.read_text())["case"])
        (sweep,) = sweeps.sweeps_of(runs)
        self.assertFalse(sweeps.has_map(sweep))
        (line,) = sweeps.curves(sweep, sweep.results[0]).axes[0].lines
        self.assertEqual(list(line.get_xdata()), [1, 2, 3])
        for run, solver in zip(runs, ("stokes", "vacuum", "stokes")):
            run.sweep.values[LAG] = solver
            del run.sweep.values[AMPLITUDE]
        (sweep,) = sweeps.sweeps_of(runs)
        axes = sweeps.curves(sweep, sweep.results[0]).axes[0]
        self.assertEqual([tick.get_text() for tick in axes.get_xticklabels()], ["stokes", "vacuum"])


class ManyCurves(unittest.TestCase):
    def test_the_first_and_the_last_are_named_beside_the_colours(self):
        places = np.array([(x, y) for y in range(12) for x in range(3)], float)
        axes = [sweeps.Axis(key, key, False, places[:, n], [], key, "") for n, key in enumerate("xy")]
        result = sweeps.Result("u", "u [m/s]", places.sum(axis=1), np.full(36, np.nan))
        figure = sweeps.curves(sweeps.SweepRecord("sweep", [""] * 36, axes, [result]), result)
        self.assertEqual([label.get_text() for label in figure.axes[1].get_yticklabels()], ["y 0", "y 11"])


class SweepOfThePage(WholeRunTest):
    """docs/your_first_own_swimmer.md: from one file to a figure with two commands."""

    def setUp(self):
        super().setUp()
        page = (ROOT / "docs/your_first_own_swimmer.md").read_text()
        section = page.partition("## 5. A sweep")[2].partition("\n## ")[0]
        self.case = re.search(r"^```yaml\n(.*?)^```", section, re.DOTALL | re.MULTILINE)[1]
        self.commands = re.findall(r"^deploy/copepod (.*)$", section, re.MULTILINE)
        (self.folder / "lags.yaml").write_text(self.case)

    def test_two_commands_lead_from_one_file_to_the_figure(self):
        self.assertEqual([command.split()[0] for command in self.commands], ["run", "report"])
        for command in self.commands:
            self.finish(*shlex.split(command))
        rows = list(csv.DictReader((self.folder / "runs/lags/results.csv").read_text().splitlines()))
        self.assertEqual(len(rows), 25)
        speeds = {(row["lag_deg"], row["amplitude_m"]): float(row["kinematics.u_along_um_per_s"]) for row in rows}
        at_right_angle = [speeds["90", f"{amplitude}e-06"] for amplitude in (1, 1.5, 2, 2.5, 3)]
        self.assertEqual(at_right_angle, sorted(at_right_angle))
        for name in ("lags_u_along_um_per_s", "lags_u_along_um_per_s_map"):
            self.assertTrue((self.folder / f"runs/lags/report/{name}.png").read_bytes().startswith(PNG), name)
        self.assertTrue((self.folder / "runs/lags/lags_lag_deg=30_amplitude_m=1e-06/summary.json").exists())

    def test_a_typo_in_a_swept_key_is_found_by_check_with_the_right_key(self):
        (self.folder / "lags.yaml").write_text(self.case.replace("signal.lag_deg: {", "signal.lag_dge: {"))
        session = self.finish("check", "lags.yaml", code=2)
        line = 1 + self.case[: self.case.index("signal.lag_deg: {")].count("\n")
        self.assertIn(f"lags.yaml:{line}: error: key 'lag_dge' is unknown", session.stderr[0])
        self.assertIn("Did you mean lag_deg?", session.stderr[0])
        self.assertEqual(len(session.stderr), 1, "".join(session.stderr))

    def test_unknown_key_of_a_campaign_is_named_once(self):
        (self.folder / "both.yaml").write_text(
            "campaign: both\ncases: [{case: lags.yaml}, {case: lags.yaml, name: b}]\n"
        )
        session = self.finish("campaign", "both.yaml", "--set", "run.stepz=5", code=2)
        self.assertIn("lags and 1 other: --set run.stepz=5: error: key 'stepz' is unknown", session.stderr[0])
        self.assertFalse((self.folder / "runs").exists())


if __name__ == "__main__":
    unittest.main()
