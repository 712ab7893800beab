"""A sphere that settles in a closed box from rest: the four experiments of ten Cate et al. (2002)."""

from typing import NamedTuple

import numpy as np

from copepod_report.style import LIGHT, describe, new_figure, picture_of
from copepod_report.trajectory import Trajectory
from copepod_validation.experiment import COLOURS, CaseDict, Results, Section, by_scheme, lattice_case, sphere
from copepod_validation.experiment import table_by_point, worst

_DIAMETER_M, _DENSITY_KG_PER_M3, _GRAVITY_M_PER_S2 = 0.015, 1120.0, 9.81
_SPEED = 0.03  # of u∞, in cells per step
_CELLS = 12  # per diameter


class Oil(NamedTuple):
    """Tables I and II of the paper; `simulated`: largest velocity of its own lattice Boltzmann simulations."""

    name: str
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


OILS = (
    Oil("E1", 970, 0.373, 0.038, 0.947, 0.894, 3.28, 18),
    Oil("E2", 965, 0.212, 0.060, 0.953, 0.950, 2.06, 18),
    Oil("E3", 962, 0.113, 0.091, 0.959, 0.955, 1.42, 18),
    Oil("E4", 960, 0.058, 0.128, 0.955, 0.947, 1.07, 24),
)
E4 = OILS[-1]
# Measured velocities of E4 [s, m/s]; digitised from the paper's plot by the project GeoTaichi (SphereFallingOil).
E4_MEASURED = np.array(
    [(0.07, 0.037), (0.10, 0.050), (0.14, 0.062), (0.20, 0.079), (0.24, 0.087), (0.27, 0.094), (0.31, 0.101)]
    + [(0.47, 0.111), (0.53, 0.113), (0.61, 0.119), (0.66, 0.120), (0.81, 0.121), (0.90, 0.123), (0.99, 0.123)]
)


class Point(NamedTuple):
    oil: Oil
    diameter: int  # cells

    @property
    def step_s(self) -> float:
        return _SPEED * _DIAMETER_M / self.diameter / self.oil.u_inf_m_per_s

    @property
    def tau(self) -> float:
        return 0.5 + 3 * _SPEED * self.diameter / self.oil.reynolds


POINTS = [Point(oil, _CELLS) for oil in OILS]
LABEL = "{0.oil.name}_D{0.diameter}"
FAST = [Point(E4, 9)]
MORE = {"central_linear": [Point(oil, oil.finest) for oil in OILS]}


def case_of(point: Point) -> CaseDict:
    oil, cell_m = point.oil, _DIAMETER_M / point.diameter
    width, height = (round(length_m / cell_m) for length_m in (0.1, 0.16))
    place = (0.5 * width, 0.5 * width, (0.12 + 0.5 * _DIAMETER_M) / cell_m)
    body = sphere(0.5 * point.diameter, place, "free", density=_DENSITY_KG_PER_M3 / oil.density_kg_per_m3)
    steps, cells = round(oil.end_s / point.step_s), (width, width, height)
    case = lattice_case(cells, point.tau, "no_slip", [body], steps, symmetry_planes=["x", "y"])
    return case | {"gravity_m_per_s2": [0, 0, -_GRAVITY_M_PER_S2 * point.step_s**2 / cell_m]}


class Fall(NamedTuple):
    """Time [s], velocity over u∞, gap to the floor over the diameter; shape (steps + 1,)."""

    oil: Oil
    time_s: np.ndarray
    speed: np.ndarray
    gap: np.ndarray

    @property
    def peak_error(self) -> float:
        """Of the largest velocity, relative to the measured one [%]."""
        return float(100 * (self.speed.max() / self.oil.measured - 1))

    def deviation(self, time_s: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """From other velocities over u∞, over their largest [%]."""
        return 100 * (np.interp(time_s, self.time_s, self.speed) - speed) / speed.max()

    def largest_deviation(self, other: "Fall") -> float:
        """From another curve until its gap is one diameter."""
        seen = other.gap > 1
        return float(np.abs(self.deviation(other.time_s[seen], other.speed[seen])).max())

    def deviation_from_measured_curve(self) -> float:
        """Largest, of E4, relative to the largest measured velocity [%]."""
        time_s, speed = E4_MEASURED.T
        return float(np.abs(self.deviation(time_s, speed / self.oil.u_inf_m_per_s)).max())


def evaluate(run: Trajectory, point: Point) -> Fall:
    motion = run.of("sphere")
    speed, gap = -motion["velocity_m_per_s"][:, 2] / _SPEED, motion["position_m"][:, 2] / point.diameter - 0.5
    return Fall(point.oil, run.steps * point.step_s, speed, gap)


def section(results: Results[Fall]) -> Section:
    coarse = min(point.diameter for _, point, _ in results)
    finer = {point.oil: fall for _, point, fall in results if point.diameter > coarse}
    falls = [result for result in results if result[1].diameter == coarse]

    def cell(fall: Fall | None) -> str:
        if fall is None:
            return "–"
        reference = finer.get(fall.oil, fall)
        deviation = "" if reference is fall else f" ({fall.largest_deviation(reference):.1f})"
        return f"{fall.peak_error:+.1f}{deviation}"

    def row(point: Point) -> str:
        oil = point.oil
        simulated = 100 * (oil.simulated / oil.measured - 1)
        return f"{oil.name} | {oil.reynolds:.1f} | {point.tau:.3f} | {oil.measured:.3f} | {simulated:+.1f}"

    heads = "case | Re | τ | measured u/u∞ | their simulation"
    last = [("finer run", point, finer.get(point.oil)) for _, point, _ in falls]
    measured = ", ".join(
        f"{fall.deviation_from_measured_curve():.1f} % with {scheme}" for scheme, _, fall in falls if fall.oil == E4
    )
    values = {"table": table_by_point([*falls, *last], heads, row, cell), "coarse": coarse, "measured": measured}
    overview = (
        worst(falls, "settling [%]", lambda fall: fall.largest_deviation(finer[fall.oil]), ".1f") if finer else {}
    )
    return Section(values, overview, {"accuracy_settling.png": _figure(falls, finer.get(E4))})


def _figure(falls: Results[Fall], finer: Fall | None) -> bytes:
    """Velocities with the last scheme beside measured ones; deviations of all schemes from the finer run of E4."""
    figure, panels = new_figure(3.4, ncols=2 if finer else 1, squeeze=False)
    panel = panels.flat[0]
    last, last_falls = list(by_scheme(falls).items())[-1]
    for colour, fall in zip((LIGHT.ink, *LIGHT.beads), last_falls):
        u_inf = fall.oil.u_inf_m_per_s
        panel.plot(fall.time_s, fall.speed * u_inf, linewidth=1.2, color=colour, label=fall.oil.name)
        peak_s = fall.time_s[np.argmax(fall.speed)]
        panel.plot([0.8 * peak_s, 1.2 * peak_s], 2 * [fall.oil.measured * u_inf], ":", color=colour)
    panel.plot(*E4_MEASURED.T, "o", markersize=3, color=LIGHT.ink, fillstyle="none")
    describe(panel, f"{last}; measured: ○ and dotted", ylabel="velocity [m/s]")
    if finer:
        panel, seen = panels.flat[1], finer.gap > 1
        for scheme, fall in ((scheme, fall) for scheme, _, fall in falls if fall.oil == E4):
            deviation = fall.deviation(finer.time_s[seen], finer.speed[seen])
            panel.plot(finer.time_s[seen], deviation, linewidth=1.2, color=COLOURS[scheme], label=scheme)
        describe(panel, "E4: deviation from the finer run", ylabel="[% of the largest velocity]")
    for panel in panels.flat:
        describe(panel, legend={}, xlabel="time [s]")
    return picture_of(figure)
