#!/usr/bin/python3
"""How fast a sphere of 4 cells and twice the fluid's density settles with each scheme, relative to trt with parabolic
boundaries: what coupler/config/checks/check_fluid.cpp warns of.

    tests/validation/settling_error.py              ten minutes
    tests/validation/settling_error.py 0.6 1.6      for some relaxation times
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "deploy"))

from copepod_report.trajectory import Trajectory  # noqa: E402
from copepod_validation.experiment import lattice_case, sphere, viscosity  # noqa: E402

TIMES = (0.55, 0.6, 0.6667, 1.0, 1.3, 1.6, 2.0, 2.5, 3.0)
SCHEMES = [(collision, boundary) for collision in ("trt", "bgk")
           for boundary in ("parabolic", "central_linear", "bounce_back", "interpolated")]  # fmt: skip
RADIUS, BOX = 4, 24


def settling_speed(tau, collision, boundary):
    """Mean over the last 200 steps, which is the terminal velocity for τ ≥ 1 and shortly before it below."""
    steps, speed = (2500, 1.5e-3) if tau < 1 else (1500, 3e-3)  # unbounded
    body = sphere(RADIUS, [11.63, 11.87, 14.41], "free", 2.0)
    refill = "equilibrium" if boundary == "bounce_back" else "nonequilibrium"
    scheme = {"collision": collision, "moving_boundary": boundary, "refill": refill}
    case = {"case": "settling_error", **lattice_case([BOX] * 3, tau, "no_slip", [body], steps, steps - 200, **scheme)}
    case["gravity_m_per_s2"] = [0, 0, -4.5 * viscosity(tau) * speed / RADIUS**2]
    case["services"] = {"transport": "in_process"}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "case.yaml")
        file.write_text(json.dumps(case), encoding="utf-8")
        command = [ROOT / "deploy/copepod", "run", file, "--out", f"{folder}/run"]
        subprocess.run(command, check=True, capture_output=True)
        return Trajectory(Path(folder, "run")).of("sphere")["velocity_m_per_s"][:, 2].mean()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("times", nargs="*", type=float, default=TIMES, help="relaxation times")
    print("tau     " + "  ".join(f"{collision + ' ' + boundary:18}" for collision, boundary in SCHEMES))
    for tau in parser.parse_args().times:
        found = [settling_speed(tau, *scheme) for scheme in SCHEMES]
        print(f"{tau:6.4f}  " + "  ".join(f"{100 * (one / found[0] - 1):+18.1f}" for one in found), flush=True)


if __name__ == "__main__":
    main()
