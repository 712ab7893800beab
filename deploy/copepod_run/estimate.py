"""Remembers how fast this machine ran, for the time estimates of `copepod check`."""

import json
from collections.abc import Mapping
from typing import Any

from copepod_run.checkout import BUILD

_FILE = BUILD / "measured_speed.json"


def remember(summary: Mapping[str, Any]) -> None:
    """Keeps MLUPS by precision and ranks of a finished run."""
    mlups = summary.get("mlups")
    if not mlups:
        return
    speeds = _read()
    speeds.setdefault(summary.get("precision", ""), {})[str(summary.get("ranks", 1))] = mlups
    try:
        _FILE.write_text(json.dumps(speeds, indent=2) + "\n")
    except OSError:  # a read-only checkout; only an estimate is lost
        pass


def remembered(precision: str, ranks: int) -> float | None:
    """MLUPS of the last run with this precision and number of ranks, or None."""
    return _read().get(precision, {}).get(str(ranks))


def _read() -> dict[str, dict[str, float]]:
    try:
        return json.loads(_FILE.read_text())
    except (OSError, ValueError):
        return {}
