"""The result table at the end of a run."""

import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import copepod_session  # noqa: F401  (makes the command's modules importable)
from copepod_bench import bench
from copepod_run.errors import BY_SIGNAL, ExitCode, Stop
from copepod_run import estimate
from copepod_run.figures import MOST_TABLES, compared, number_text, result_table

SWIMMER = {
    "name": "swimmer",
    "u_swim_lattice": 9.1234e-6,
    "u_swim_m_per_s": 1.2087e-2,
    "d1_cells": 2.5312,
    "d2_cells": 3.8,
    "sin_dphi": 0.94,
    "mean_arm_cells": [16.1, 15.9],
    "K": 0.0045,
    "u_GA_lattice": 8.9e-6,
    "error_percent": 1.0,
    "efficiency": 5.2e-4,
    "Re_swim": 6.5e-3,
    "Re_bodies": {"B2": 0.066, "B1": 0.06, "B3": 0.07},
}
KINEMATICS = {
    "cycle": 4,
    "u_along_um_per_s": -6364.2,
    "u_along_cells_per_step": None,
    "u_along_lengths_per_cycle": -4.8e-4,
    "u_across_um_per_s": 2702.1,
    "rotation_rad": [3e-8, -0.3, 0.4],
    "tilt_rad": 0.95528,
    "arms": [{"mean_m": 1.6e-5, "amplitude_m": 4e-7}, {"mean_m": 1.7e-5, "amplitude_m": 7e-7}],
    "power_W": 6.3e-5,
    "efficiency": None,
    "Re": 0.0042,
    "change_from_last_cycle": {"velocity": 0.007, "rotation": None},
}
SUMMARY = {
    "case": "design_a",
    "status": "finished",
    "steps": 196812,
    "step_s": 7.548e-10,
    "wall_s": 1234.5,
    "mlups": 45.67,
    "ranks": 2,
    "precision": "single",
    "digest": "00ff",
    "swimmers": [SWIMMER],
    "timing": {"fluid_s": 1200.0, "body_s": 1.0, "coupler_s": 2.0, "exchange_wait_s": 3.0, "coupling_overhead": 0.0123},
}


class ResultTable(unittest.TestCase):
    def row(self, text, summary=SUMMARY):
        """The one line of the table that holds `text`."""
        lines = [line for line in result_table(summary, "runs/a").splitlines() if text in line]
        self.assertEqual(len(lines), 1, lines)
        return lines[0].split()

    def test_speed_names_precision_and_ranks(self):
        self.assertEqual(self.row("MLUPS"), "speed 45.7 MLUPS, single precision, 2 ranks".split())

    def test_overhead_is_in_percent(self):
        self.assertEqual(self.row("coupling overhead"), "coupling overhead 1.23 %".split())

    def test_vacuum_has_no_coupling_overhead(self):
        self.assertNotIn("overhead", result_table({**SUMMARY, "mlups": 0.0}, "runs/a"))

    def test_wall_time_is_for_people(self):
        self.assertIn("20 min 35 s", " ".join(self.row("wall time")))

    def test_swimmers_have_four_digits_and_units(self):
        self.assertEqual(self.row("u_swim"), "swimming speed u_swim 9.123e-06 cells/step".split())
        self.assertEqual(self.row("mean arms"), "mean arms 16.1 15.9 cells".split())
        self.assertEqual(self.row("Re of B2")[-1], "0.066")

    def test_published_values_stand_beside_ours(self):
        published = {"u_swim_lattice": 9.05e-6, "d1_cells": 2.53, "Re_bodies": {"B2": 0.059}}
        summary = {**SUMMARY, "swimmers": [{**SWIMMER, "published": published}]}
        self.assertEqual(self.row("u_swim", summary)[-3:], ["9.123e-06", "9.05e-06", "cells/step"])
        self.assertEqual(self.row("Re of B2", summary)[-2:], ["0.066", "0.059"])
        self.assertEqual(self.row("d2", summary)[-2:], ["3.8", "cells"])

    def test_values_computed_the_papers_way_stand_between(self):
        summary = {
            **SUMMARY,
            "swimmers": [{**SWIMMER, "as_in_paper": {"efficiency": 1.1e-3}, "published": {"efficiency": 10.44e-4}}],
        }
        self.assertEqual(self.row("efficiency", summary), ["efficiency", "0.00052", "0.0011", "0.001044"])
        self.assertEqual(self.row("this run", summary)[1:], ["this", "run", "paper's", "way", "published"])

    def test_a_note_stands_below_the_name(self):
        noted = {**SWIMMER, "kinematics": {"note": "too few samples"}}
        lines = result_table({**SUMMARY, "swimmers": [noted]}, "runs/a").splitlines()
        name = next(number for number, line in enumerate(lines) if "this run" in line)
        self.assertEqual(lines[name + 1], "    (too few samples)")

    def test_swimmer_that_was_not_analysed_says_so(self):
        swimmer = {**{key: None for key in SWIMMER}, "name": "short", "analysed": False}
        self.assertIn("short: not analysed", result_table({**SUMMARY, "swimmers": [swimmer]}, "runs/a"))

    def test_swimmer_of_any_shape_has_the_kinematics_of_its_last_cycle(self):
        summary = {**SUMMARY, "swimmers": [{"name": "triangle", "kinematics": KINEMATICS}]}
        self.assertEqual(self.row("along its own axis", summary)[-2:], ["-6364", "µm/s"])
        self.assertEqual(self.row("rotation in", summary)[-4:], ["0", "-17.19", "22.92", "degrees"])
        self.assertEqual(self.row("tilt", summary)[-2:], ["54.73", "degrees"])
        self.assertEqual(self.row("amplitudes", summary)[-3:], ["0.4", "0.7", "µm"])
        self.assertEqual(self.row("Re of the swimmer", summary)[-1], "0.0042")
        table = result_table(summary, "runs/a")
        self.assertNotIn("efficiency", table)
        self.assertNotIn("cells/step", table)

    def test_named_groups_follow_the_swimmers(self):
        summary = {**SUMMARY, "swimmers": [], "groups": [{"name": "pair", "kinematics": KINEMATICS}]}
        self.assertEqual(self.row("this run", summary)[0], "pair")
        self.assertEqual(self.row("across", summary)[-2:], ["2702", "µm/s"])

    def test_coefficients_follow_them_with_a_row_for_each_figure(self):
        force = {"mean": 3.2584, "rms": 0.0434, "half_span": 0.0615}
        shedding = {"name": "cylinder", "drag": force, "lift": {**force, "mean": -0.0182}}
        shedding["strouhal"] = {"mean": 0.29846, "half_span": 0.0008, "periods": 10}
        summary = {**SUMMARY, "coefficients": [shedding, {"name": "rock", "note": "the run ended before step 70"}]}
        self.assertEqual(self.row("drag coefficient", summary)[-1], "3.258")
        self.assertEqual(self.row("lift coefficient", summary)[-1], "-0.0182")
        self.assertEqual(self.row("Strouhal number", summary)[-1], "0.2985")
        self.assertEqual(self.row("periods", summary)[-1], "10")
        self.assertEqual(result_table(summary, "runs/a").count("half of its span"), 3)
        self.assertIn("rock: not analysed, the run ended before step 70", result_table(summary, "runs/a"))
        figures = {key: figure.ours for key, figure in compared(shedding).items()}
        columns = {"drag.mean": 3.2584, "drag.rms": 0.0434, "lift.mean": -0.0182, "lift.rms": 0.0434}
        self.assertEqual(figures, {**columns, "strouhal.mean": 0.29846})
        steady = {**summary, "coefficients": [{**shedding, "strouhal": None}]}
        self.assertNotIn("Strouhal", result_table(steady, "runs/a"))

    def test_columns_of_the_flow_have_a_row_each_if_they_are_few(self):
        column = {"name": "x_low.fx_N", "mean": 1.25, "rms": 0.5, "min": -1.0, "max": 12345.6}
        summary = {**SUMMARY, "flow": [column, {"name": "x_low.fy_N", "note": "the run ended before step 70"}]}
        self.assertEqual(self.row("flow", summary), ["flow", "mean", "rms", "least", "most"])
        self.assertEqual(self.row("x_low.fx_N", summary), ["x_low.fx_N", "1.25", "0.5", "-1", "12346"])
        self.assertNotIn("x_low.fy_N", result_table(summary, "runs/a"))
        many = [{**column, "name": f"probe{number}"} for number in range(17)]
        self.assertIn("probe15", result_table({**SUMMARY, "flow": many[:16]}, "runs/a"))
        self.assertNotIn("probe15", result_table({**SUMMARY, "flow": many}, "runs/a"))

    def test_three_beads_in_a_row_have_the_figures_of_the_paper_and_no_second_efficiency(self):
        summary = {**SUMMARY, "swimmers": [{**SWIMMER, "kinematics": {**KINEMATICS, "efficiency": 0.1}}]}
        self.assertEqual(self.row("efficiency", summary)[-1], "0.00052")
        self.assertEqual(self.row("across", summary)[-2:], ["2702", "µm/s"])

    def test_swimmer_at_rest_has_no_changes(self):
        change = {"velocity": None, "rotation": None}
        resting = {**KINEMATICS, "at_rest": True, "change_from_last_cycle": change, "rotation_rad": [1e-16, 0, 2e-16]}
        summary = {**SUMMARY, "swimmers": [{"name": "triangle", "kinematics": resting}]}
        self.assertIn("at rest (below 1e-9 lengths and 1e-9 rad)", " ".join(self.row("motion in a cycle", summary)))
        self.assertEqual(self.row("rotation in", summary)[-4:], ["0", "0", "0", "degrees"])
        self.assertNotIn("change in last cycle", result_table(summary, "runs/a"))

    def test_comparisons_have_the_rotation_with_its_sense(self):
        turning = compared({"kinematics": KINEMATICS})
        self.assertEqual(
            [key for key in turning if key.startswith("rotation")], [f"rotation_degrees.{x}" for x in "yz"]
        )
        self.assertAlmostEqual(turning["rotation_degrees.y"].ours, -17.188734, places=5)

    def test_comparisons_tell_what_still_changes(self):
        for swimmer in ({"kinematics": KINEMATICS}, {**SWIMMER, "kinematics": KINEMATICS}):
            self.assertAlmostEqual(compared(swimmer)["change_percent"].ours, 0.7)
        self.assertNotIn("change_percent", compared({"kinematics": {**KINEMATICS, "change_from_last_cycle": None}}))

    def test_mean_and_spread_over_the_last_cycles_are_in_table_and_comparison(self):
        steady = {"u_along_mean_um_per_s": -6321.04, "u_along_spread_um_per_s": 12.345}
        for swimmer in ({"name": "triangle"}, SWIMMER):
            entry = {**swimmer, "kinematics": {**KINEMATICS, **steady}}
            line = self.row("mean of the last cycles", {**SUMMARY, "swimmers": [entry]})
            self.assertEqual(line[-4:], ["-6321", "±", "12", "µm/s"])
            self.assertEqual({key: compared(entry)[key].ours for key in steady}, steady)
        self.assertFalse(steady.keys() & compared({"kinematics": KINEMATICS}).keys())
        young = {**SUMMARY, "swimmers": [{"name": "triangle", "kinematics": KINEMATICS}]}
        self.assertNotIn("last cycles", result_table(young, "runs/a"))

    def test_swimmer_without_cycles_says_why(self):
        swimmer = {"name": "idle", "kinematics": {"cycle": None, "note": "nothing drives it periodically"}}
        table = result_table({**SUMMARY, "swimmers": [swimmer]}, "runs/a")
        self.assertIn("idle: not analysed, nothing drives it periodically", table)

    def test_many_swimmers_are_described_together(self):
        swarm = {"u_along_mean_m_per_s": 0.012345, "polar_order": 0.5, "nearest_distance_least_m": 1e-4}
        swimmers = [{"name": f"s{number}", "kinematics": KINEMATICS} for number in range(13)]
        summary = {**SUMMARY, "swimmers": swimmers, "swarm": swarm}
        self.assertEqual(self.row("mean velocity", summary)[-2:], ["0.01235", "m/s"])
        self.assertEqual(self.row("polar order", summary)[-1], "0.5")
        self.assertNotIn("tilt", result_table(summary, "runs/a"))
        few = {**summary, "swimmers": swimmers[:MOST_TABLES]}
        self.assertEqual(result_table(few, "runs/a").count("tilt"), MOST_TABLES)

    def test_run_without_swimmers_or_timing_has_a_table_too(self):
        table = result_table({"case": "box", "status": "finished", "steps": 3, "wall_s": 0.5}, "runs/box")
        self.assertIn("0.50 s", table)
        self.assertNotIn("None", table)

    def test_lines_fit_on_a_page(self):
        self.assertLess(max(map(len, result_table(SUMMARY, "runs/a").splitlines())), 100)

    def test_numbers(self):
        self.assertEqual(
            [number_text(value) for value in (0.000123456, 12, None, [1.0, 2.5])], ["0.0001235", "12", "-", "1 2.5"]
        )


class Estimates(unittest.TestCase):
    def test_sizes_have_the_largest_unit_of_which_there_is_one(self):
        for size, text in ((0, "0 kB"), (1, "0.001 kB"), (999_499, "999 kB"), (999_500, "1 MB"), (4.6e11, "460 GB")):
            self.assertEqual(estimate.size_text(size), text)

    def test_come_from_runs_that_lasted(self):
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(estimate, "_SPEEDS", Path(folder) / "speeds"):
            for steps, wall_s, shown in ((2, 5.0, None), (1000, 0.1, None), (1000, 10.0, 1.0), (2, 5.0, 1.0)):
                plan = SimpleNamespace(steps=steps, case={"fluid": {"solver": "stokes"}}, estimate={"bodies": 3})
                estimate.remember(plan, {"wall_s": wall_s})
                hundred = SimpleNamespace(**{**vars(plan), "steps": 100})
                self.assertEqual(estimate.time_of(hundred)[0], shown, (steps, wall_s))

    def test_grow_with_the_bodies_beside_the_cost_of_an_exchange(self):
        # Measured with services: 161 µs a step with 1 body, 164 with 10, 739 with 30, 21264 with 120.
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(estimate, "_SPEEDS", Path(folder) / "speeds"):
            plans = {
                n: SimpleNamespace(steps=10000, case={"fluid": {"solver": "stokes"}}, estimate={"bodies": n})
                for n in (1, 10, 30, 120)
            }
            estimate.remember(plans[1], {"wall_s": 1.6})
            for bodies, measured_s in ((10, 1.64), (30, 7.39), (120, 212.64)):
                shown = estimate.time_of(plans[bodies])[0]
                self.assertLess(max(shown / measured_s, measured_s / shown), 1.5, (bodies, shown))


class Benchmark(unittest.TestCase):
    """The tables of `copepod bench`."""

    def test_has_a_row_for_every_measurement_and_warns_of_a_busy_machine(self):
        alone = {"domain_cells": (48, 48, 48), "precision": "double", "collision": "bgk", "ranks": 2}
        alone |= {"median_copy_gb_per_s": 9.87, "median_streams_mcells_per_s": 40.04, "median_fluid_mlups": 35.55}
        samples = [
            {"ratio": ratio, "phases_s": {"fluid": {"map": 1.0, "bulk": 3.0}}} for ratio in (0.904, 0.876, 0.956)
        ]
        coupled = {
            **alone,
            "beads": 3,
            "shape": "sphere",
            "transport": "ipc",
            "symmetry_planes": ("x", "y"),
            "keys": {},
        }
        coupled |= {"median_coupled_mlups": 32.14, "median_ratio": 0.904, "median_coupling_overhead": 0.0123}
        coupled |= {"samples": samples, "others": 0.01}
        published = {**coupled, "keys": bench.PUBLISHED, "symmetry_planes": (), "others": 0.254}
        pure = [{**alone, "median_share_of_limit": 0.888}]
        table = bench._table({"pure": pure, "coupled": [coupled, published]})
        row = "| 48×48×48 | {} | 3 | sphere | 2 | ipc | 32.1 | 35.5 | 0.90 (0.88–0.96) | 0.012 |"
        defaults, as_published = table.partition("bgk, bounce_back, equilibrium, no lubrication")[::2]
        self.assertIn("\n| 48×48×48 | double | bgk | 2 | 9.9 | 40.0 | 35.5 | 0.89 |\n\n", defaults)
        self.assertIn(f"|---|\n{row.format('x, y')}\n\n", defaults)
        self.assertIn(f"|---|\n{row.format('none')}\n\n", as_published)
        self.assertIn("\n\nThe machine was busy: other work had up to 25 % of it.", table)
        self.assertIn("\n| domain | beads | boundary | transport | map | bulk |\n|---|---|---|---|---|---|\n", table)
        last = ["| 48×48×48 | 3 × sphere | default | ipc | 25.0 | 75.0 |"]
        last += ["| 48×48×48 | 3 × sphere | bounce_back | ipc | 25.0 | 75.0 |"]
        self.assertEqual(table.splitlines()[-2:], last)
        self.assertNotIn("busy", bench._table({"pure": pure, "coupled": [coupled]}))


class Refusals(unittest.TestCase):
    def test_a_signal_is_no_refusal(self):
        self.assertEqual(Stop(ExitCode.BAD_CASE, "no.", "why\n").refused(), "why\nno.")
        for code in BY_SIGNAL:
            with self.assertRaises(Stop):
                Stop(code, "stopped").refused()


if __name__ == "__main__":
    unittest.main()
