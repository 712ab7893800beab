"""Not broken: it has no checkpoints, and does not announce any."""

import dataclasses
import sys

from foundation import BODY, Masses
from copepod_component import run_body_component


class MassesWithoutMemory(Masses):
    save = restore = None


FEATURES = [feature for feature in BODY.features if feature != "checkpoint"]
sys.exit(run_body_component(MassesWithoutMemory, dataclasses.replace(BODY, features=FEATURES)))
