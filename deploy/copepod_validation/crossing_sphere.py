"""Noise of the loads on a sphere that crosses the grid at a constant velocity, straight and obliquely."""

import json
from typing import Any, NamedTuple

import numpy as np

from copepod_report.style import describe, new_figure, picture_of
from copepod_report.trajectory import Trajectory
from copepod_run.figures import markdown_table
from copepod_validation.experiment import COLOURS, CaseDict, Results, Section, by_scheme, lattice_case, sphere

SPEED = 0.02
RADIUS = 4.0
_RAMP, _FROM, _STEPS, _WINDOW = 600, 1000, 2200, 50
_BANDS = 25  # of the spectra: a harmonic of the crossing of cells each
_PATHS = {
    "straight": ((0.0, 0.0, 1.0), (16.13, 16.31, 12.13), (32, 32, 64)),
    "oblique": ((1.0, 0.7, 0.45), (12.13, 12.21, 12.37), (56, 48, 40)),
}


class Point(NamedTuple):
    path: str
    tau: float


POINTS = [Point(path, tau) for path in _PATHS for tau in (0.6, 1.0)]
LABEL = "{0.path}_tau{0.tau:g}"
FAST = POINTS[:1]


def case_of(point: Point) -> CaseDict:
    direction, start, cells = _PATHS[point.path]
    velocity = SPEED * np.array(direction) / np.linalg.norm(direction)
    signal = {"kind": "constant", "ramp_steps": _RAMP}
    motion = {"prescribed": {"velocity_m_per_s": velocity.tolist(), "signal": signal}}
    return lattice_case(cells, point.tau, "no_slip", [sphere(RADIUS, start, motion)], _STEPS)


def evaluate(run: Trajectory, point: Point) -> dict[str, Any]:
    """Noise relative to the mean force [%]; `residual` of the raw force along the path, shape (steps,); `work`: time at
    the surface, relative to the update of all cells [%], NaN if the fluid does not report it."""
    force = run.of("sphere")["force_N"][run.steps > _FROM]
    way = np.array(_PATHS[point.path][0])
    along, across = (axis / np.linalg.norm(axis) for axis in (way, np.cross(way, (0.0, 1.0, 0.3))))
    raw = _residual(force @ along)
    percent = 100 / abs(float(np.mean(force @ along)))
    averaged = _residual(0.5 * (force[1:] + force[:-1]) @ along)
    seconds = json.loads((run.directory / "summary.json").read_text())["phases_s"].get("fluid", {})
    at_surface = sum(seconds.get(phase, np.nan) for phase in ("map", "refill", "momentum"))
    return {
        "raw": percent * _rms(raw),
        "peak": percent * float(np.abs(raw).max()),
        "averaged": percent * _rms(averaged),
        "lateral": percent * _rms(_residual(force @ across)),
        "residual": percent * raw,
        "work": 100 * at_surface / seconds.get("bulk", np.nan),
    }


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _residual(values: np.ndarray) -> np.ndarray:
    """What a cubic leaves of each window."""
    windows = values[: len(values) // _WINDOW * _WINDOW].reshape(-1, _WINDOW).T
    powers = np.vander(np.linspace(-1, 1, _WINDOW), 4)
    return (windows - powers @ np.linalg.lstsq(powers, windows, rcond=None)[0]).T.ravel()


def section(results: Results[dict[str, Any]]) -> Section:
    heads = "path | τ | scheme | raw [% rms] | raw, peak [%] | averaged [% rms] | lateral [% rms]"
    form = "{0.path} | {0.tau:g} | {1} | {raw:.2f} | {peak:.2f} | {averaged:.2f} | {lateral:.2f}"
    ordered = sorted(results, key=lambda result: result[1])
    rows = [form.format(point, scheme, **noise) for scheme, point, noise in ordered]
    overview = {}
    for scheme, found in by_scheme(results).items():
        overview[scheme, "noise, raw [% rms]"] = f"{max(noise['raw'] for noise in found):.2f}"
        overview[scheme, "averaged [% rms]"] = f"{max(noise['averaged'] for noise in found):.2f}"
        overview[scheme, "work at the surface [%]"] = f"{np.median([noise['work'] for noise in found]):.1f}"
    return Section({"table": markdown_table(heads, rows)}, overview, {"accuracy_noise.png": _figure(results)})


def _figure(results: Results[dict[str, Any]]) -> bytes:
    """Amplitude spectra of the raw force at τ = 0.6, smoothed in bands."""
    paths = list(dict.fromkeys(point.path for _, point, _ in results))
    figure, panels = new_figure(3.2, ncols=len(paths), sharey=True, squeeze=False)
    for panel, path in zip(panels.flat, paths):
        for scheme, _, noise in (result for result in results if result[1] == Point(path, 0.6)):
            residual = noise["residual"]
            power = np.abs(np.fft.rfft(residual * np.hanning(residual.size)))[1:] ** 2
            waves = np.arange(1, power.size + 1) / residual.size
            bands = zip(np.array_split(waves, _BANDS), np.array_split(power, _BANDS))
            means = np.array([(wave.mean(), np.sqrt(2 * band.mean()) / residual.size) for wave, band in bands])
            panel.semilogy(*means.T, linewidth=1.2, color=COLOURS[scheme], label=scheme)
        describe(panel, f"{path}, τ = 0.6", xlabel="frequency [1/step]")
    panels.flat[0].set_ylim(top=3)
    describe(panels.flat[0], legend={"ncols": 2}, ylabel="amplitude [% of the force]")
    return picture_of(figure)
