"""Broken: looks for the next message again and again instead of sleeping until it comes."""

import sys

import zmq

from foundation import FLUID, Drag
from copepod_component import run_fluid_component
from copepod_component.server import Server


def spin(server, seconds):
    while not server._context.stop_code:
        try:
            return server._socket.recv(zmq.DONTWAIT)
        except zmq.Again:
            pass
    server._session.on_event("coupler lost")
    return None


Server._receive = spin
sys.exit(run_fluid_component(Drag, FLUID))
