#!/usr/bin/env python3
"""A controller: steers the triangle of configs/examples/steered_triangle.yaml to a target, and holds it there.

It plays each of six strokes once and measures how far the triangle swims by it, in the frame of the triangle. Then it
plays, cycle by cycle, the stroke that leads nearest to the target, as large as the way that is left: the way of a
stroke grows with about the third power of its size.
"""

import itertools
import json
import sys

import numpy as np
from copepod_component import Capabilities, run_controller_component

STROKES = list(itertools.permutations(range(3), 2))  # which arm shortens first, and which then
SHORT = [(1, 0), (1, 1), (0, 1), (0, 0), (0, 0), (0, 0)]  # both arms, action by action; at the end the springs rest


class Pilot:
    def __init__(self, setup, context):
        self.parameters = json.loads(setup.parameters)
        self.state = {"actions": 0, "ways": [], "stroke": 0, "size": 0.0, "start": None, "frame": None, "origin": None}

    def act(self, observation):
        state, places = self.state, observation.position_m[:, [0, 2]]
        cycle, phase = divmod(state["actions"], len(SHORT))
        if phase == 0:
            middle = places.mean(axis=0)
            along = (places[0] - middle) / np.linalg.norm(places[0] - middle)
            frame = np.array([along, [-along[1], along[0]]])
            if 0 < cycle <= len(STROKES):
                state["ways"].append((np.array(state["frame"]) @ (middle - state["start"])).tolist())
            state.update(start=middle.tolist(), frame=frame.tolist(), origin=state["origin"] or middle.tolist())
            if cycle < len(STROKES):
                state.update(stroke=cycle, size=1.0)
            else:
                left = frame @ (np.array(state["origin"]) + self.parameters["target_m"] - middle)
                shares = np.array([way @ left / (way @ way) for way in np.array(state["ways"])]).clip(0.0, 1.0)
                errors = np.linalg.norm(left - shares[:, None] * state["ways"], axis=1)
                state.update(stroke=int(errors.argmin()), size=float(np.cbrt(shares[errors.argmin()])))
        state["actions"] += 1
        lengths = np.zeros(3)
        lengths[list(STROKES[state["stroke"]])] = SHORT[phase]
        return lengths * state["size"] * self.parameters["stroke_m"]


if __name__ == "__main__":
    sys.exit(run_controller_component(Pilot, Capabilities("Triangle pilot", "1.0", ["checkpoint", "snapshots"])))
