"""A sphere that settles in a closed box from rest: the four experiments of ten Cate et al. (2002)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from copepod_report.style import LIGHT, new_figure, png_of
from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import COLOURS, CaseDict, Experiment, Section, lattice_case, sphere, table

REFERENCE = (
    "Experiments E1 to E4 of ten Cate et al. [Phys. Fluids 14, 4012, 2002]: a sphere of 15 mm and 1120 kg/m³ falls "
    "from rest, 120 mm above the floor of a box of 100 × 100 × 160 mm full of oil. The largest velocity is compared "
    "with the measured one, beside that of the lattice Boltzmann simulations in the same paper. Measured curves are "
    "published only as plots: the whole curve, until the gap to the floor is one diameter, is therefore compared with "
    "a finer run of central_linear (18 cells per diameter, E4 24). E1 is slower than measured at every resolution, as "
    "it is in the paper's simulations. u∞ moves by 0.03 cells per step."
)
_DIAMETER_M, _DENSITY_KG_PER_M3, _GRAVITY_M_PER_S2 = 0.015, 1120.0, 9.81
_SPEED = 0.03  # of u∞, in cells per step
_CELLS = 12  # per diameter


@dataclass(frozen=True)
class Oil:
    """Tables I and II of the paper; `simulated`: largest velocity of its own lattice Boltzmann simulations."""

    density_kg_per_m3: float
    viscosity_Pa_s: float
    u_inf_m_per_s: float
    measured: float  # largest velocity, over u∞
    simulated: float
    end_s: float  # of the run: the gap is then about 0.8 diameters
    finest: int  # cells per diameter of the reference

    @property
    def reynolds(self) -> float:
        return self.density_kg_per_m3 * self.u_inf_m_per_s * _DIAMETER_M / self.viscosity_Pa_s


OILS = {
    "E1": Oil(970, 0.373, 0.038, 0.947, 0.894, 3.28, 18),
    "E2": Oil(965, 0.212, 0.060, 0.953, 0.950, 2.06, 18),
    "E3": Oil(962, 0.113, 0.091, 0.959, 0.955, 1.42, 18),
    "E4": Oil(960, 0.058, 0.128, 0.955, 0.947, 1.07, 24),
}
# Measured velocities of E4 [s, m/s]; digitised from the paper's plot by the project GeoTaichi (SphereFallingOil).
E4_MEASURED = np.array(
    [(0.07, 0.037), (0.10, 0.050), (0.14, 0.062), (0.20, 0.079), (0.24, 0.087), (0.27, 0.094), (0.31, 0.101)]
    + [(0.47, 0.111), (0.53, 0.113), (0.61, 0.119), (0.66, 0.120), (0.81, 0.121), (0.90, 0.123), (0.99, 0.123)]
)


@dataclass(frozen=True)
class Point:
    oil: str
    diameter: int  # cells

    @property
    def step_s(self) -> float:
        return _SPEED * _DIAMETER_M / self.diameter / OILS[self.oil].u_inf_m_per_s

    @property
    def tau(self) -> float:
        return 0.5 + 3 * _SPEED * self.diameter / OILS[self.oil].reynolds


def experiments(scheme: str, keys: Mapping[str, str], fast: bool) -> list[Experiment]:
    points = [Point("E4", 9)] if fast else [Point(oil, _CELLS) for oil in OILS]
    if scheme == "central_linear" and not fast:
        points += [Point(name, oil.finest) for name, oil in OILS.items()]
    return [
        Experiment(f"settling_sphere-{scheme}-{point.oil}_D{point.diameter}", scheme, point, _case(point, keys))
        for point in points
    ]


def _case(point: Point, keys: Mapping[str, str]) -> CaseDict:
    oil, cell_m = OILS[point.oil], _DIAMETER_M / point.diameter
    width, height = (round(length_m / cell_m) for length_m in (0.1, 0.16))
    place = (0.5 * width, 0.5 * width, (0.12 + 0.5 * _DIAMETER_M) / cell_m)
    body = sphere(0.5 * point.diameter, place, "free", density=_DENSITY_KG_PER_M3 / oil.density_kg_per_m3)
    steps = round(oil.end_s / point.step_s)
    cells = (width, width, height)
    case = lattice_case(cells, point.tau, "no_slip", [body], steps, symmetry_planes=["x", "y"], **keys)
    case["gravity_m_per_s2"] = [0, 0, -_GRAVITY_M_PER_S2 * point.step_s**2 / cell_m]
    case["output"] = {"trajectory": {"every_steps": 1}}
    del case["coupling"]  # as bodies move by default
    return case


@dataclass(frozen=True)
class Fall:
    """Time [s], velocity over u∞, gap to the floor over the diameter; shape (steps + 1,)."""

    time_s: np.ndarray
    speed: np.ndarray
    gap: np.ndarray

    def deviation(self, time_s: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """From other velocities over u∞, over their largest [%]."""
        return 100 * (np.interp(time_s, self.time_s, self.speed) - speed) / speed.max()

    def largest_deviation(self, other: "Fall") -> float:
        """From another curve until its gap is one diameter."""
        seen = other.gap > 1
        return float(np.abs(self.deviation(other.time_s[seen], other.speed[seen])).max())


def evaluate(folder: Path, experiment: Experiment) -> Fall:
    point, trajectory = experiment.point, Trajectory(folder / "trajectory.csv")
    motion = trajectory.of("sphere")
    return Fall(
        trajectory.steps * point.step_s,
        -motion["velocity_m_per_s"][:, 2] / _SPEED,
        motion["position_m"][:, 2] / point.diameter - 0.5,
    )


def peak_error(oil: str, fall: Fall) -> float:
    """Of the largest velocity, relative to the measured one [%]."""
    return float(100 * (fall.speed.max() / OILS[oil].measured - 1))


def deviation_from_measured_curve(fall: Fall) -> float:
    """Largest, of E4, relative to the largest measured velocity [%]."""
    time_s, speed = E4_MEASURED.T
    return float(np.abs(fall.deviation(time_s, speed / OILS["E4"].u_inf_m_per_s)).max())


def section(results: Sequence[tuple[Experiment, Fall]]) -> Section:
    falls = {(one.point.oil, one.point.diameter, one.scheme): fall for one, fall in results}
    schemes, oils = (list(dict.fromkeys(key[place] for key in falls)) for place in (2, 0))
    coarse = min(diameter for _, diameter, _ in falls)
    finer = {oil: fall for (oil, diameter, _), fall in falls.items() if diameter > coarse}
    curves: dict[str, list[float]] = {scheme: [] for scheme in schemes}
    rows = []
    for name in oils:
        oil = OILS[name]
        row = [name, f"{oil.reynolds:.1f}", f"{Point(name, coarse).tau:.3f}", f"{oil.measured:.3f}"]
        row.append(f"{100 * (oil.simulated / oil.measured - 1):+.1f}")
        for scheme in schemes:
            fall = falls[name, coarse, scheme]
            row.append(f"{peak_error(name, fall):+.1f}")
            if name in finer:
                curves[scheme].append(fall.largest_deviation(finer[name]))
                row[-1] += f" ({curves[scheme][-1]:.1f})"
        rows.append([*row, f"{peak_error(name, finer[name]):+.1f}" if name in finer else "–"])
    measured = ", ".join(
        f"{deviation_from_measured_curve(falls['E4', coarse, scheme]):.1f} % with {scheme}" for scheme in schemes
    )
    markdown = table(["case", "Re", "τ", "measured u/u∞", "their simulation", *schemes, "finer run"], rows)
    markdown += (
        f"\n\nLargest velocity at {coarse} cells per diameter relative to the measured one [%]; in brackets the "
        "largest deviation of the curve from the finer run [% of its largest velocity]. From the measured points of "
        f"E4 in the figure, digitised from the paper's plot, the curve deviates by at most {measured}.\n\n"
        "![Velocity of the settling sphere](accuracy_settling.png)"
    )
    overview = {scheme: {"settling [%]": f"{max(values):.1f}"} for scheme, values in curves.items() if values}
    return Section(markdown, {"accuracy_settling.png": _figure(falls, finer, coarse)}, overview)


def _figure(falls: Mapping[tuple[str, int, str], Fall], finer: Mapping[str, Fall], coarse: int) -> bytes:
    """Velocities with the last scheme beside measured ones; deviations of all schemes from the finer run of E4."""
    figure, panels = new_figure(LIGHT, 3.4, ncols=2 if "E4" in finer else 1, squeeze=False)
    panel = panels.flat[0]
    schemes = list(dict.fromkeys(scheme for _, _, scheme in falls))
    for colour, name in zip((LIGHT.ink, *LIGHT.beads), dict.fromkeys(oil for oil, _, _ in falls)):
        fall, u_inf = falls[name, coarse, schemes[-1]], OILS[name].u_inf_m_per_s
        panel.plot(fall.time_s, fall.speed * u_inf, linewidth=1.2, color=colour, label=name)
        peak_s = fall.time_s[np.argmax(fall.speed)]
        panel.plot([0.8 * peak_s, 1.2 * peak_s], 2 * [OILS[name].measured * u_inf], ":", color=colour)
    panel.plot(*E4_MEASURED.T, "o", markersize=3, color=LIGHT.ink, fillstyle="none")
    panel.set_title(f"{schemes[-1]}; measured: ○ and dotted", fontsize=10)
    panel.set_ylabel("velocity [m/s]")
    for scheme in schemes:
        if "E4" in finer:
            panel, reference = panels.flat[1], finer["E4"]
            seen = reference.gap > 1
            deviation = falls["E4", coarse, scheme].deviation(reference.time_s[seen], reference.speed[seen])
            panel.plot(reference.time_s[seen], deviation, linewidth=1.2, color=COLOURS[scheme], label=scheme)
            panel.set_title("E4: deviation from the finer run", fontsize=10)
            panel.set_ylabel("[% of the largest velocity]")
    for panel in panels.flat:
        panel.set_xlabel("time [s]")
        panel.legend(fontsize=8, frameon=False)
    return png_of(figure)
