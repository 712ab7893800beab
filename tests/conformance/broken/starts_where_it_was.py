"""Broken: it announces snapshots, and another setup finds the bodies where they were."""

import dataclasses
import sys

from foundation import BODY, Masses
from copepod_component import run_body_component


class RootedMasses(Masses):
    known = None

    def __init__(self, setup, context):
        super().__init__(setup, context)
        self.state = RootedMasses.known or self.state
        RootedMasses.known = self.state


sys.exit(run_body_component(RootedMasses, dataclasses.replace(BODY, features=[*BODY.features, "snapshots"])))
