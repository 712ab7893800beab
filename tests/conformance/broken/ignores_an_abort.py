"""Broken: keeps waiting when the coupler has ended the run."""

import sys

from foundation import BODY, Masses
from copepod_component import run_body_component
from copepod_component.control_lane import ControlLane
from copepod_component.messages import Envelope

handle = ControlLane._handle


def is_deaf_to_abort(lane, socket, message):
    if Envelope.FromString(message).WhichOneof("body") != "abort":
        handle(lane, socket, message)


ControlLane._handle = is_deaf_to_abort
sys.exit(run_body_component(Masses, BODY))
