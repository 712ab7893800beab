"""Command line and life of a component; the same options as the C++ kit."""

import argparse
import dataclasses
import json
import logging
import os
import secrets
import socket as host_names
import sys
import time

import zmq

from . import checksum
from .errors import CaseError
from .keys import Door, read_keys, require_keys_off_this_machine
from .control_lane import ControlLane
from .schema import Envelope, PROTOCOL_MAJOR, PROTOCOL_MINOR, handshake
from .server import Server
from .solvers import ServedBody, ServedFluid
from .validation import MESSAGE_BYTES
from .vitals import VITALS

LINGER_MS = 500  # for the last message of a component that ends


@dataclasses.dataclass
class Capabilities:
    name: str
    version: str
    features: list


def run_fluid_component(make_solver, capabilities):
    """Serves the solver that make_solver(FluidSetup) returns; gives the exit code of the process."""
    return serve_component(ServedFluid(make_solver), capabilities)


def run_body_component(make_solver, capabilities):
    """Serves the solver that make_solver(BodySetup) returns; gives the exit code of the process."""
    return serve_component(ServedBody(make_solver), capabilities)


def _options(capabilities):
    parser = argparse.ArgumentParser(description=f"{capabilities.name}, a component of Copepod")
    parser.add_argument("--capabilities", action="store_true", help="print what this component can do as JSON and exit")
    parser.add_argument("--endpoint", help="address of the coupler: ipc:///path or tcp://host:port")
    parser.add_argument("--session", default=os.environ.get("COPEPOD_SESSION"), help="token of the run")
    parser.add_argument("--keys", help="file with the keys of this role; a must off this machine")
    parser.add_argument("--log-file", help="where to log; standard error if not given")
    parser.add_argument("--log-level", default="info", choices=["trace", "debug", "info", "warning", "error", "off"])
    parser.add_argument(
        "--orphan-after", type=float, default=10.0, help="end after so many seconds without the coupler"
    )
    parser.add_argument("--connect-deadline", type=float, default=60.0, help="wait so many seconds for the coupler")
    options = parser.parse_args()
    if not options.capabilities and not (options.endpoint and options.session):
        parser.error("this component has no coupler to talk to (--endpoint or --session is missing). Give both")
    return options


def _hello(role, lane, token, capabilities, instance):
    message = Envelope(protocol_major=PROTOCOL_MAJOR, protocol_minor=PROTOCOL_MINOR, step=-1)
    hello = message.hello
    hello.role = handshake.ROLE_FLUID if role == "fluid" else handshake.ROLE_BODY
    hello.lane = lane
    hello.versions.major, hello.versions.minor_min, hello.versions.minor_max = PROTOCOL_MAJOR, 0, PROTOCOL_MINOR
    hello.session_token = token
    hello.capabilities.name, hello.capabilities.version = capabilities.name, capabilities.version
    hello.capabilities.features.extend(sorted(capabilities.features))
    hello.host, hello.pid, hello.ranks = host_names.gethostname(), os.getpid(), 1
    hello.instance = instance
    return checksum.to_bytes(message)


def serve_component(served, capabilities):
    """Serves an object with role, perform(request, reply) and follow_up(name), see solvers.py; gives the exit code."""
    options = _options(capabilities)
    if options.capabilities:
        print(
            json.dumps(
                {
                    "name": capabilities.name,
                    "version": capabilities.version,
                    "role": served.role,
                    "features": sorted(capabilities.features),
                }
            )
        )
        return 0
    level = {"trace": "DEBUG", "off": "CRITICAL"}.get(options.log_level, options.log_level.upper())
    logging.basicConfig(
        filename=options.log_file, level=level, format=f"%(asctime)s %(levelname)s [{served.role} rank 0] %(message)s"
    )
    log = logging.getLogger("copepod")
    try:
        keys = read_keys(options.keys) if options.keys else None
        require_keys_off_this_machine(options.endpoint, keys)
    except CaseError as error:
        print(f"error: {error}", file=sys.stderr)
        return int(error.code)
    log.info("%s connects to %s as %s.", capabilities.name, options.endpoint, served.role)
    context, instance = zmq.Context(), secrets.randbits(64)

    def make_socket(lane):
        sock = context.socket(zmq.DEALER)
        sock.linger = LINGER_MS
        sock.maxmsgsize = MESSAGE_BYTES
        if keys:
            sock.curve_publickey, sock.curve_secretkey, sock.curve_serverkey = keys
        sock.setsockopt(zmq.ROUTING_ID, f"{served.role}-{instance}-{lane}".encode())
        return sock

    def hello(lane):
        return _hello(served.role, lane, options.session, capabilities, instance)

    ControlLane(
        make_socket("control"), options.endpoint, hello(handshake.LANE_CONTROL), VITALS, options.orphan_after, log
    ).start()
    data_lane = make_socket("data")
    door = Door(data_lane)
    data_lane.connect(options.endpoint)
    server = Server(data_lane, served, hello(handshake.LANE_DATA), VITALS, door, host_names.gethostname(), log)
    code = int(server.run(options.connect_deadline))
    log.info("Ending with exit code %d.", code)
    data_lane.close()
    time.sleep(LINGER_MS / 1000)  # the last message leaves; the control lane still uses the context, which so lives on
    return code
