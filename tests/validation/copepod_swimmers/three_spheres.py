"""Three spheres in a row: alone, beside the theory of Golestanian and Ajdari; two of them side by side; and one near a
no-slip wall."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from copepod import Run
from copepod_report.style import LIGHT, describe, new_figure
from copepod_run.figures import markdown_table
from copepod_swimmers.runs import last_cycle, period_s, radii_m, turn_fraction
from copepod_swimmers.theory import Stroke, any_stroke_velocity, small_stroke_velocity, turning_at_a_wall

LABELS = ("leading order", "any stroke", "Rotne-Prager")  # of theory: small strokes and spheres, small spheres, neither
ROW = ((0, 1), (1, 2))  # its arms
PAIR = ("left", "right")


def speed_of(run: Run) -> dict[str, float]:
    """What was varied, the measured speed and arms, and by LABELS what theory makes of the arms, in cells and steps; of
    a run whose trajectory holds the last cycle in equal steps."""
    swimmer, stroke = run.summary["swimmers"][0], run.case["swimmers.0.stroke"]
    start, stop = swimmer["window_steps"]
    beads, radii = last_cycle(run, swimmer["name"]) / 1e-6, radii_m(run) / 1e-6
    arms = np.linalg.norm(np.diff(beads, axis=0), axis=2)
    moved = Stroke(beads[:, 0], radii, ROW, arms).motion()
    axis = (beads[2, 0] - beads[0, 0]) / np.linalg.norm(beads[2, 0] - beads[0, 0])
    d1, d2 = swimmer["d1_cells"], swimmer["d2_cells"]
    theory = (
        small_stroke_velocity(radii, arms, stop - start),
        any_stroke_velocity(radii, arms, stop - start),
        float((moved[1] - moved[0]).mean(axis=0) @ axis / (stop - start)),
    )
    return {
        "force": 1e6 * stroke["amplitude_N"],
        "lag": stroke["phase_lag_steps"],
        "period": stop - start,
        "measured": swimmer["u_swim_lattice"],
        "d1": d1,
        "d2": d2,
        "stroke_squared": d1 * d2 / np.prod(arms.mean(axis=1)),
        **dict(zip(LABELS, theory)),
    }


@dataclass(frozen=True)
class Alone:
    """What a swimmer without a neighbour does in a cycle."""

    measured: float  # [m]
    theory: float  # the same from its stroke by integration [m]
    dipole_N_m: float  # mean of Σ f·x along the axis, f the forces on the fluid
    period_s: float
    length_m: float  # mean distance of the outer beads
    viscosity_Pa_s: float

    @classmethod
    def of(cls, run: Run) -> "Alone":
        """Of the swimmer called swimmer of a run whose trajectory holds the last cycle."""
        last, period, fluid = run.cycles.loc["swimmer"].iloc[-1], period_s(run, "swimmer"), run.case["fluid"]
        axis = np.array(last[["axis_x", "axis_y", "axis_z"]])
        beads, forces = last_cycle(run, "swimmer"), -last_cycle(run, "swimmer", "f{}_N")
        arms = np.linalg.norm(np.diff(beads, axis=0), axis=2)
        moved = Stroke(beads[:, 0], radii_m(run), ROW, arms).motion()
        return cls(
            last["u_along_m_per_s"] * period,
            float(np.linalg.norm((moved[1] - moved[0]).mean(axis=0))),
            float(np.mean(np.sum(((beads - beads.mean(axis=0)) @ axis) * (forces @ axis), axis=0))),
            period,
            float(np.mean((beads[2] - beads[0]) @ axis)),
            fluid["density_kg_per_m3"] * fluid["kinematic_viscosity_m2_per_s"],
        )

    def __str__(self) -> str:
        relative = self.dipole_N_m * self.period_s / (self.viscosity_Pa_s * self.measured * self.length_m**2)
        return f"p/(η u L²) = {relative:.3f}, L = {1e6 * self.length_m:.1f} cells"


def over_lag(stokes: Any, lattice: Any) -> Any:
    """Speed over the lag of the leading force: dots measured, lines theory."""
    figure, panels = new_figure(3.6, ncols=2)
    for panel, speeds, title in zip(panels, (stokes, lattice), ("Stokes flow", "lattice Boltzmann")):
        lags = np.array(speeds["lag"] / speeds["period"])
        for label, style, colour in zip(LABELS, ("-", "--", ":"), LIGHT.beads):
            panel.plot(*_periodic(lags, 1e6 * speeds[label]), style, color=colour, linewidth=1.4, label=label)
        panel.plot(lags, 1e6 * speeds["measured"], "o", color=LIGHT.ink, markersize=4, label="Copepod")
        describe(panel, title, xlabel="lag of the leading force φ/T")
    describe(panels[0], legend={"loc": "lower left"}, ylabel="u [10⁻⁶ cells/step]")
    return figure


def _periodic(lags: np.ndarray, values: Any) -> tuple[np.ndarray, np.ndarray]:
    """A smooth curve through points of a periodic function: its first waves, as many as the points determine."""
    orders = np.arange(1, (len(lags) - 1) // 2 + 1)[:4]

    def waves(places: np.ndarray) -> np.ndarray:
        phases = 2 * np.pi * np.outer(places, orders)
        return np.hstack([np.ones((len(places), 1)), np.cos(phases), np.sin(phases)])

    fine = np.linspace(0, 1, 200)
    return fine, waves(fine) @ np.linalg.lstsq(waves(lags), values, rcond=None)[0]


def over_amplitude(stokes: Any, lattice: Any) -> Any:
    """Measured speed over each theory's, over the square of the stroke."""
    figure, axes = new_figure(3.6)
    for speeds, marker, name in ((stokes, "o-", "Stokes"), (lattice, "s--", "lattice")):
        for label, colour in zip(LABELS, LIGHT.beads):
            look = {"color": colour, "markersize": 4, "linewidth": 1, "label": f"{name}: {label}"}
            axes.plot(speeds["stroke_squared"], speeds["measured"] / speeds[label], marker, **look)
    axes.axhline(1, color=LIGHT.ink, linewidth=0.8)
    axes.set_xlim(left=0)
    place = {"loc": "center left", "bbox_to_anchor": (1, 0.5)}
    describe(axes, legend=place, xlabel="d₁d₂/(l̄₁l̄₂)", ylabel="u / u of theory")
    return figure


def table(head: str, names: Iterable[Any], speeds: Any) -> str:
    """Markdown: a row per run, with these names."""
    per_stroke = abs(speeds[LABELS[0]] / speeds["stroke_squared"])
    ratios = 1 / speeds[list(LABELS)].where(per_stroke > 1e-2 * per_stroke.max()).div(speeds["measured"], axis=0)
    rows = [
        f"{name} | {one.d1:.3f}, {one.d2:.3f} | {one.measured:.3e} | " + " | ".join(map("{:.4f}".format, found))
        for name, one, found in zip(names, speeds.itertuples(), ratios.to_numpy())
    ]
    heads = " | ".join([head, "d₁, d₂ [cells]", "u [cells/step]", *(f"u over {label}" for label in LABELS)])
    return markdown_table(heads, rows).replace("nan", "–")


def directions(runs: dict[str, Run]) -> str:
    """Markdown: the same swimmer along several axes, in all cycles but the first; the first run is the reference."""
    rows, reference = [], None
    for name, run in runs.items():
        cycles = run.cycles.loc["swimmer"]
        scale = run.summary["step_s"] / run.summary["cell_size_m"]
        speeds = cycles["u_along_m_per_s"][1:] * scale
        reference = reference or speeds.mean()
        across = cycles["u_across_m_per_s"][1:].mean() * scale / speeds.mean()
        rows.append(
            f"[{', '.join(name)}] | {', '.join(f'{1e5 * speed:.3f}' for speed in speeds)} | {speeds.mean():.3e} | "
            f"{speeds.mean() / reference:.4f} | {across:.1e} | {cycles['tilt_rad'].iloc[-1]:.1e}"
        )
    heads = "axis | u along its axis, cycle by cycle [10⁻⁵ cells/step] | mean | over the first | across over along"
    return markdown_table(f"{heads} | tilt at the end", rows)


def pair_of(run: Run) -> dict[str, float]:
    """The last cycle of swimmers that point along z, the right one on the positive side of x: `phase` of the right
    swimmer behind the left one [degrees], `distance` [m]; per cycle [m] `left` and `right` speeds, and `parting`, the
    change of the distance less what the tilt makes of the speed. The same from the measured strokes by integration has
    names in brackets."""
    rows = [run.cycles.loc[name].iloc[-1] for name in PAIR]
    beads = np.concatenate([last_cycle(run, name) for name in PAIR])
    pairs = ((0, 1), (1, 2), (3, 4), (4, 5))
    arms = np.array([np.linalg.norm(beads[j] - beads[i], axis=1) for i, j in pairs])
    moved = Stroke(beads[:, 0], radii_m(run), pairs, arms, ((0, 1, 2), (3, 4, 5))).motion()
    ways = (moved[1] - moved[0]).reshape(2, 3, 3).mean(axis=1)
    period = period_s(run, "right")
    found = {
        "phase": np.degrees(turn_fraction(rows[0]["arm1_phase_rad"] - rows[1]["arm1_phase_rad"])),
        "distance": rows[1]["x_m"] - rows[0]["x_m"],
    }
    sideways = []
    for name, row, way in zip(PAIR, rows, ways):
        axis = np.array(row[["axis_x", "axis_y", "axis_z"]])
        measured = row[["ux_m_per_s", "u_along_m_per_s"]] * period
        found |= {name: measured[1], f"({name})": way @ axis}
        sideways.append([across - along * axis[0] for across, along in (measured, (way[0], way @ axis))])
    return found | dict(zip(("parting", "(parting)"), np.diff(sideways, axis=0)[0]))


def _changes(pairs: Any, alone: Alone) -> Any:
    """Speeds over those of a lone swimmer, less one, and partings in nm."""
    of_speeds = {name: pairs[name] / alone.measured - 1 for name in PAIR}
    of_theory = {f"({name})": pairs[f"({name})"] / alone.theory - 1 for name in PAIR}
    return pairs.assign(**of_speeds, **of_theory, **{name: 1e9 * pairs[name] for name in ("parting", "(parting)")})


def interaction(over_phase: Any, together: Any, opposed: Any, alone: Alone) -> Any:
    """Speeds relative to a lone swimmer and change of distance: dots measured, lines theory."""
    figure, (by_phase, by_distance) = new_figure(6.0, nrows=2, ncols=2)
    _draw_phases(by_phase, _changes(over_phase, alone).sort_values("phase"))
    _draw_distances(by_distance, _changes(together, alone), _changes(opposed, alone), alone)
    for panels, label in ((by_phase, "phase of the right swimmer [degrees]"), (by_distance, "distance d [cells]")):
        for panel in panels:
            describe(panel, legend={}, xlabel=label)
    return figure


def _draw_phases(panels: Any, pairs: Any) -> None:
    phases = pairs["phase"]
    for name, colour in zip(PAIR, LIGHT.beads):
        panels[0].plot(phases, 100 * pairs[f"({name})"], "-", color=colour)
        panels[0].plot(phases, 100 * pairs[name], "o", color=colour, markersize=4, label=name)
    panels[1].plot(phases, pairs["(parting)"], "-", color=LIGHT.beads[2], label="Rotne-Prager")
    panels[1].plot(phases, pairs["parting"], "o", color=LIGHT.ink, markersize=4, label="Copepod")
    panels[0].set_ylabel("change of speed [%]")
    panels[1].set_ylabel("change of distance [nm per cycle]")


def _draw_distances(panels: Any, together: Any, opposed: Any, alone: Alone) -> None:
    """Half the sum over both phases («dead», what a passive body would feel) and half the difference («live»)."""
    places = 1e6 * together["distance"]
    for panel, what in zip(panels, ("left", "parting")):
        for sign, name, colour in ((1, "dead", LIGHT.beads[0]), (-1, "live", LIGHT.beads[1])):
            part = abs(together + sign * opposed) / 2
            panel.loglog(places, part[f"({what})"], "-", color=colour)
            panel.loglog(places, part[what], "o", color=colour, markersize=4, label=name)
    # Two swimmers in the mean flow of each other's dipole p: −p/(4πηd²), from u = p (3 cos²θ − 1)/(8πηr²) at cos θ = 0.
    strength = alone.dipole_N_m * alone.period_s / (4 * np.pi * alone.viscosity_Pa_s)
    dipole = 1e9 * strength / together["distance"] ** 2
    panels[1].loglog(places, dipole, "--", color=LIGHT.ink, linewidth=1, label="mean dipole")
    panels[0].set_ylabel("|change of speed|, relative")
    panels[1].set_ylabel("|change of distance| [nm per cycle]")


def pair_table(pairs: Any, alone: Alone) -> str:
    """Markdown: a row per run."""
    rows = [
        f"{1e6 * pair['distance']:.1f} | {abs(pair['phase']):.1f} | {1 + pair['left']:.4f}, {1 + pair['right']:.4f} | "
        f"{1 + pair['(left)']:.4f}, {1 + pair['(right)']:.4f} | {pair['parting']:.4f} | {pair['(parting)']:.4f}"
        for _, pair in _changes(pairs, alone).iterrows()
    ]
    heads = "distance [cells] | phase [degrees] | speed of left, right over alone | theory"
    return markdown_table(f"{heads} | change of distance [nm per cycle] | theory", rows)


def turning_of(towards: Run, away: Run, alone: Alone) -> dict[str, float]:
    """Change of the pitch in the last cycles of two runs at the same height, of a swimmer that points towards the wall
    and away from it [rad].

    The flow of a dipole's images turns both by opposite angles: half their difference is `odd`, half their sum `even`.
    Beside them the same from the measured strokes, with Blake's images, and for `odd` the far field of the dipole.
    """
    rows = [run.cycles.loc["swimmer"].iloc[-1] for run in (towards, away)]
    height, tilts = np.mean([row["z_m"] for row in rows]), np.arcsin([row["axis_z"] for row in rows])
    measured = np.array([-row["rotation_y_rad"] for row in rows])
    integrated = np.array([_integrated(run, row) for run, row in zip((towards, away), rows)])
    turning = turning_at_a_wall(alone.dipole_N_m, height, np.diff(tilts)[0] / 2, alone.viscosity_Pa_s)
    return {
        "height": height,
        "odd": np.diff(measured)[0] / 2,
        "even": measured.mean(),
        "far field": turning * alone.period_s,
        "(odd)": np.diff(integrated)[0] / 2,
        "(even)": integrated.mean(),
    }


def _integrated(run: Run, row: Any) -> float:
    phase = 2 * np.pi * np.arange(64) / 64  # of the fits of a row of cycles.csv
    arms = [
        row[f"{arm}_mean_m"] + row[f"{arm}_amplitude_m"] * np.cos(phase + row[f"{arm}_phase_rad"])
        for arm in ("arm0", "arm1")
    ]
    along = np.concatenate([[0.0], np.cumsum([arm[0] for arm in arms])])
    axis = [row[f"axis_{letter}"] for letter in "xyz"]
    places = np.outer(along - along.mean(), axis) + [row["x_m"], row["y_m"], row["z_m"]]
    stroke = Stroke(places, radii_m(run), ROW, np.array(arms), straight=((0, 1, 2),), wall=True)
    ends = [place[2] - place[0] for place in stroke.motion(parts=48)]
    return float(np.diff([np.arctan2(end[2], end[0]) for end in ends])[0])


def approach(turnings: Any, paths: Mapping[str, Run], length_m: float) -> Any:
    """Left: turning per cycle over height, dots measured, lines theory. Right: paths, the swimmer every 300 cycles."""
    figure, (rate, path) = new_figure(3.6, ncols=2)
    heights, sizes = 1e6 * turnings["height"], abs(turnings)
    rate.loglog(heights, sizes["far field"], "--", color=LIGHT.ink, linewidth=1, label="far field of the dipole")
    for name, colour in zip(("odd", "even"), LIGHT.beads):
        rate.loglog(heights, sizes[f"({name})"], "-", color=colour)
        rate.loglog(heights, sizes[name], "o", color=colour, markersize=4, label=f"{name} in the pitch")
    for (name, run), colour in zip(paths.items(), LIGHT.beads):
        cycles = run.cycles.loc["swimmer"]
        path.plot(1e6 * cycles["x_m"], 1e6 * cycles["z_m"], color=colour, linewidth=1.2, label=name)
        for _, cycle in cycles[::300].iterrows():
            ends = 1e6 * length_m / 2 * np.array([-1, 1])
            x, z = (1e6 * cycle[f"{axis}_m"] + ends * cycle[f"axis_{axis}"] for axis in "xz")
            path.plot(x, z, "-", color=colour, linewidth=3, alpha=0.5, solid_capstyle="round")
    path.set_ylim(bottom=0)
    describe(rate, legend={}, xlabel="height h [cells]", ylabel="|turning| [rad per cycle]")
    describe(path, legend={}, xlabel="x [cells]", ylabel="height h [cells]")
    return figure


def wall_table(turnings: Any, length_m: float) -> str:
    """Markdown: a row per height."""
    rows = [
        f"{one['height'] / length_m:.2f} | {one['odd']:.3e} | {one['odd'] / one['far field']:.3f} | "
        f"{one['odd'] / one['(odd)']:.3f} | {one['even']:.3e} | {one['even'] / one['(even)']:.3f}"
        for _, one in turnings.iterrows()
    ]
    heads = "h/L | odd part [rad per cycle] | over the dipole's far field | over theory with images | even part"
    return markdown_table(f"{heads} | over theory with images", rows)
