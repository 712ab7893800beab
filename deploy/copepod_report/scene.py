"""What the interactive view draws: shapes, arms and walls from the case, and the motion packed into few bytes."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from copepod_run.errors import BadCase
from copepod_run.figures import at, prefix_of

MOST_FRAMES = 1000
MOST_SAMPLES = 60000  # frames times bodies: 1.1 MB of text
BEADS = ("B2", "B1", "B3")  # trailing, middle, leading
_LEVELS = 65535  # of a 16-bit number


@dataclass(frozen=True, eq=False)
class Surface:
    """Of a body, closed, in the body's frame; bodies of equal shape share one.

    radius_m     of a sphere or capsule; None for other shapes
    points_m     shape (points, 3)
    triangles    shape (triangles, 3): numbers of points, counter-clockwise seen from outside
    """

    radius_m: float | None
    points_m: np.ndarray
    triangles: np.ndarray

    @property
    def reach_m(self) -> float:
        return float(np.linalg.norm(self.points_m, axis=1).max())


@dataclass(frozen=True)
class Body:
    name: str
    surface: Surface
    place: int  # in its swimmer, or among the bodies without one: decides its colour


@dataclass(frozen=True)
class Samples:
    """Motion of all bodies in the world frame.

    steps, time_s        shape (samples,)
    position_m           shape (samples, bodies, 3), like velocity_m_per_s
    orientation_wxyz     shape (samples, bodies, 4), unit quaternions
    """

    bodies: Sequence[str]
    steps: np.ndarray
    time_s: np.ndarray
    position_m: np.ndarray
    orientation_wxyz: np.ndarray
    velocity_m_per_s: np.ndarray


def most_frames(bodies: int, views: int = 1) -> int:
    """Frames that a view of so many bodies shows; a page of many views shares the size of four."""
    return max(2, min(MOST_FRAMES, 4 * MOST_SAMPLES // max(views, 4) // max(bodies, 1)))


def scene_of(name: str, case: Mapping[str, Any], cell_size_m: float | None, samples: Samples) -> dict[str, Any]:
    """Everything that the view of a run draws, as JSON; lengths in `unit`.

    `case`: as the coupler resolves it; `cell_size_m`: None where there is no lattice.
    """
    surfaces, numbers = surfaces_of(case), case["surfaces"]["bodies"]
    places = _places_of(case)
    if (unknown := next((body for body in samples.bodies if body not in numbers), None)) is not None:
        raise BadCase(f"{name} moves a body {unknown} (its case.yaml lacks it). Run the case again.")
    power, prefix = prefix_of(max((surface.reach_m for surface in surfaces), default=1e-6), -9)
    metres = 10.0**power
    number = {body: index for index, body in enumerate(samples.bodies)}
    arms = [[number[a], number[b]] for a, b in _arms(case) if a in number and b in number]
    return {
        "name": name,
        "unit": f"{prefix}m",
        "surfaces": [
            {
                "radius": (surface.radius_m or surface.reach_m) / metres,
                "points": as_text((surface.points_m / metres).astype("<f4")),
                "triangles": as_text(surface.triangles.astype("<u4")),
            }
            for surface in surfaces
        ],
        "bodies": [{"name": body, "surface": numbers[body], "colour": places[body] % 3} for body in samples.bodies],
        "obstacles": [
            {**obstacle, "position": (np.array(obstacle["position_m"]) / metres).tolist()}
            for obstacle in case["surfaces"]["obstacles"]
        ],
        "arms": arms,
        "up": [-component for component in case.get("gravity_m_per_s2") or [0, 0, 0]],
        "box": _box(case.get("fluid") or {}, cell_size_m, metres),
        "period_steps": _period(case),
        "motion": _motion(samples, metres),
    }


def bodies_of(case: Mapping[str, Any]) -> dict[str, Body]:
    """All bodies of a case by their names in its run."""
    surfaces, places = surfaces_of(case), _places_of(case)
    return {name: Body(name, surfaces[number], places[name]) for name, number in case["surfaces"]["bodies"].items()}


def surfaces_of(case: Mapping[str, Any]) -> list[Surface]:
    return [
        Surface(
            surface["radius_m"],
            surface["unit_m"] * np.array(surface["points"], float).reshape(-1, 3),
            np.array(surface["triangles"], int).reshape(-1, 3),
        )
        for surface in case["surfaces"]["surfaces"]
    ]


def _places_of(case: Mapping[str, Any]) -> dict[str, int]:
    places = {body["name"]: place for place, body in enumerate(case.get("bodies") or [])}
    for swimmer in case.get("swimmers") or []:
        places |= {f"{swimmer['name']}.{name}": place for place, name in enumerate(bead_names(swimmer))}
    return places


def bead_names(swimmer: Mapping[str, Any]) -> list[str]:
    return [bead.get("name") or BEADS[min(place, 2)] for place, bead in enumerate(swimmer["beads"])]


def _arms(case: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Names of the bodies at the ends of every arm, spring and rod."""
    arms = []
    for swimmer in case.get("swimmers") or []:
        names = bead_names(swimmer)
        pairs = [arm["beads"] for arm in swimmer.get("arms") or []] or list(zip(names, names[1:]))
        arms += [(f"{swimmer['name']}.{a}", f"{swimmer['name']}.{b}") for a, b in pairs]
    rods = [joint for joint in case.get("joints") or [] if joint["kind"] == "distance"]
    return arms + [(tie["bodies"][0], tie["bodies"][1]) for tie in [*(case.get("springs") or []), *rods]]


def _box(fluid: Mapping[str, Any], cell_size_m: float | None, metres: float) -> dict[str, Any] | None:
    """The domain; `walls` are faces such as «x_low», `symmetry` the normals of the mirror planes through its middle."""
    if fluid.get("no_slip_plane", "none") != "none":
        return {"size": None, "walls": [fluid["no_slip_plane"]], "symmetry": [], "periodic": []}
    if not cell_size_m or not all(fluid.get("domain_cells") or [0]):
        return None
    faces = {f"{axis}_{side}": fluid["boundaries"][axis][side] for axis in "xyz" for side in ("low", "high")}
    walls = [face for face, kind in faces.items() if kind == "no_slip" or "velocity_m_per_s" in kind]
    periodic = [axis for axis in "xyz" if faces[f"{axis}_low"] == "periodic"]
    size = [cells * cell_size_m / metres for cells in fluid["domain_cells"]]
    return {"size": size, "walls": walls, "symmetry": list(fluid.get("symmetry_planes") or []), "periodic": periodic}


def _period(case: Mapping[str, Any]) -> int:
    """Steps of a cycle of the first swimmer that has a stroke or a driven arm, or of a joint; 0 if there is none."""
    signals = []
    for swimmer in case.get("swimmers") or []:
        signals += [swimmer.get("stroke"), *(at(arm, "drive.signal") for arm in swimmer.get("arms") or [])]
    signals += [joint.get("signal") for joint in case.get("joints") or []]
    return next((int(signal["period_steps"]) for signal in signals if signal and signal.get("period_steps")), 0)


def _motion(samples: Samples, metres: float) -> dict[str, Any]:
    """16-bit numbers between the least and the greatest value of each body; orientations only of those that turn."""
    position = samples.position_m / metres
    low, span = position.min(axis=0), np.ptp(position, axis=0)
    speed = np.linalg.norm(samples.velocity_m_per_s, axis=-1)
    fastest = speed.max(axis=0)
    orientation = samples.orientation_wxyz * np.where(samples.orientation_wxyz[..., :1] < 0, -1.0, 1.0)
    turning = np.flatnonzero((np.abs(np.sum(orientation * orientation[:1], axis=-1)) < 1 - 1e-7).any(axis=0))
    return {
        "steps": samples.steps.tolist(),
        "time_s": [float(f"{time:.9g}") for time in samples.time_s],
        "low": _rounded(low),
        "span": _rounded(span),
        "positions": _levels_of(position - low, span),
        "fastest_m_per_s": [float(f"{most:.5g}") for most in fastest],
        "speeds": _levels_of(speed, fastest),
        "orientations": [[round(number, 6) for number in quaternion] for quaternion in orientation[0].tolist()],
        "turning": turning.tolist(),
        "rotations": as_text(np.round(32767 * orientation[:, turning, 1:]).astype("<i2")),
    }


def _rounded(vectors: np.ndarray) -> list[list[float]]:
    return [[float(f"{number:.9g}") for number in vector] for vector in vectors]


def _levels_of(values: np.ndarray, span: np.ndarray) -> str:
    """Shares of the span, from 0 to 65535."""
    shares = values / np.where(span > 0, span, 1.0)
    return as_text(np.round(_LEVELS * np.clip(shares, 0.0, 1.0)).astype("<u2"))


def as_text(numbers: np.ndarray) -> str:
    """Their bytes in base64, for the scripts."""
    return base64.b64encode(np.ascontiguousarray(numbers).tobytes()).decode()
