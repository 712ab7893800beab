#!/usr/bin/python3
"""A controller for cases drawn at random: what it sets depends on all that it observes and has counted."""

import json
import math
import sys

from copepod_component import Capabilities, run_controller_component


class Controller:
    def __init__(self, setup, context):
        self.amplitudes = json.loads(setup.parameters)["amplitudes"]
        self.speed_m_per_s = 1e-3 * 1e-6 / setup.step_s
        self.state = {"actions": 0, "turned": 0.0}

    def act(self, observation):
        state = self.state
        state["actions"] += 1
        state["turned"] += float(observation.velocity_m_per_s.sum()) / self.speed_m_per_s
        pushed = float(observation.force_N.sum()) / (abs(observation.force_N).sum() or 1.0)
        return [0.5 * a * math.sin(state["actions"] + state["turned"] + pushed) for a in self.amplitudes]


if __name__ == "__main__":
    sys.exit(run_controller_component(Controller, Capabilities("Drawn controller", "1.0", ["checkpoint", "snapshots"])))
