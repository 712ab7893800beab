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

from .control_lane import ControlLane
from .errors import CaseError, ComponentError
from .keys import HandshakeMonitor, read_keys, require_keys_off_this_machine
from .messages import PROTOCOL_MAJOR, PROTOCOL_MINOR, envelope, handshake, setup, to_frame
from .server import Server
from .solvers import ServedBody, ServedController, ServedFluid, SolverContext
from .validation import MESSAGE_BYTES, check_setup

LINGER_MS = 500  # for the last message of a component that ends
_RECONNECT_MS = 100


@dataclasses.dataclass
class Capabilities:
    """What a component announces of itself; docs/protocol.md lists the features."""

    name: str  #: for people
    version: str  #: its own, for people
    features: list  #: "solver:external", "shape:sphere", …


def run_fluid_component(make_solver, capabilities, estimate=None, arguments=None):
    """Serves the solver that make_solver(FluidSetup, SolverContext) returns.

    `estimate(FluidSetup, ranks)` returns an Estimate or raises CaseError; with it, the feature `estimate` is announced.
    `arguments` are those of the command line that are not the component's own; default: all. Returns the exit code of
    the process.
    """
    context = SolverContext()
    return serve_component(ServedFluid(make_solver, context), capabilities, context, estimate, arguments)


def run_body_component(make_solver, capabilities, estimate=None, arguments=None):
    """Serves the solver that make_solver(BodySetup, SolverContext) returns; otherwise like run_fluid_component."""
    context = SolverContext()
    return serve_component(ServedBody(make_solver, context), capabilities, context, estimate, arguments)


def run_controller_component(make_controller, capabilities, arguments=None):
    """Serves the controller that make_controller(ControllerSetup, SolverContext) returns: an object with
    act(Observation), which returns a value for each actuator, and a `state` of JSON values if it keeps anything.
    """
    context = SolverContext()
    return serve_component(ServedController(make_controller, context), capabilities, context, None, arguments)


def serve_component(served, capabilities, context, estimate=None, arguments=None):
    """Serves an object with role, perform(request, reply) and follow_up(name) (solvers.py); returns the exit code."""
    options = _options(served.role, capabilities, estimate, arguments)
    name = options.name or served.role
    if estimate:
        features = sorted({*capabilities.features, "estimate"})
        capabilities = dataclasses.replace(capabilities, features=features)
    if options.capabilities:
        print(json.dumps({**dataclasses.asdict(capabilities), "role": served.role}))
        return 0
    try:
        if options.estimate:
            return _print_estimate(served.role, estimate, options.ranks)
        keys = read_keys(options.keys) if options.keys else None
        require_keys_off_this_machine(options.endpoint, keys)
    except ComponentError as error:
        print(f"error: {error}", file=sys.stderr)
        return int(CaseError.code)
    level = {"trace": "DEBUG", "off": "CRITICAL"}.get(options.log_level, options.log_level.upper())
    line = f"%(asctime)s %(levelname)s [{name} rank 0] %(message)s"
    logging.basicConfig(filename=options.log_file, level=level, format=line)
    log = logging.getLogger("copepod")
    log.info("%s connects to %s as %s.", capabilities.name, options.endpoint, name)
    zmq_context, instance = zmq.Context(), secrets.randbits(64)

    def make_socket(lane):
        sock = zmq_context.socket(zmq.DEALER)
        sock.linger, sock.maxmsgsize, sock.reconnect_ivl = LINGER_MS, MESSAGE_BYTES, _RECONNECT_MS
        if keys:
            sock.curve_publickey, sock.curve_secretkey, sock.curve_serverkey = keys
        sock.ipv6 = "[" in options.endpoint
        sock.setsockopt(zmq.ROUTING_ID, f"{name}-{instance}-{lane}".encode())
        return sock

    features, host = sorted(capabilities.features), host_names.gethostname()

    def hello(lane):
        hello = {
            "role": f"ROLE_{served.role.upper()}",
            "lane": lane,
            "name": options.name,
            "versions": {"major": PROTOCOL_MAJOR, "minor_min": 0, "minor_max": PROTOCOL_MINOR},
            "session_token": options.session,
            "capabilities": dataclasses.asdict(capabilities) | {"features": features},
            **{"host": host, "pid": os.getpid(), "ranks": 1, "instance": instance},
        }
        return to_frame(envelope(step=-1, hello=hello))

    control_lane, data_lane = make_socket("control"), make_socket("data")
    ControlLane(
        control_lane, options.endpoint, hello(handshake.LANE_CONTROL), context, options.orphan_after, log
    ).start()
    monitor = HandshakeMonitor(data_lane)
    data_lane.connect(options.endpoint)
    server = Server(data_lane, served, name, features, hello(handshake.LANE_DATA), context, monitor, host, log)
    code = int(server.run(options.connect_deadline))
    log.info("Ending with exit code %d.", code)
    data_lane.close()
    time.sleep(LINGER_MS / 1000)  # the last message leaves; the ZeroMQ context is not ended: the control lane uses it
    return code


def _options(role, capabilities, estimate, arguments):
    parser = argparse.ArgumentParser(description=f"{capabilities.name}, a component of Copepod")
    parser.add_argument("--capabilities", action="store_true", help="print name, role and features as JSON and exit")
    if estimate:
        parser.add_argument(
            "--estimate",
            action="store_true",
            help="read a serialised setup from standard input, print the memory per process as JSON and exit",
        )
        parser.add_argument("--ranks", type=int, default=1, help="with --estimate: number of processes (default: 1)")
    parser.add_argument("--endpoint", help="address of the coupler: ipc:///path or tcp://host:port")
    parser.add_argument("--session", default=os.environ.get("COPEPOD_SESSION"), help="token of the run")
    if role == "controller":
        parser.add_argument("--name", help="which controller of the case this is")
    parser.set_defaults(name=None, estimate=False)
    parser.add_argument("--keys", help="file with the keys of this role; required when other machines can listen")
    parser.add_argument("--log-file", help="log file (default: standard error)")
    parser.add_argument("--log-level", default="info", choices=["trace", "debug", "info", "warning", "error", "off"])
    parser.add_argument(
        "--orphan-after", type=float, default=10.0, help="seconds without a ping before the coupler is given up (10)"
    )
    parser.add_argument(
        "--connect-deadline", type=float, default=60.0, help="seconds to wait for the coupler at the start (60)"
    )
    options = parser.parse_args(arguments)
    if not (options.capabilities or options.estimate) and not (options.endpoint and options.session):
        parser.error("no coupler to connect to (--endpoint or --session is missing). Give both")
    return options


def _print_estimate(role, estimate, ranks):
    """Protocol: "Estimates". Raises ComponentError."""
    message = setup.FluidSetup() if role == "fluid" else setup.BodySetup()
    try:
        message.ParseFromString(sys.stdin.buffer.read())
    except Exception as error:  # the exception depends on the implementation of protobuf
        raise CaseError(
            f"Standard input is not a serialised setup ({error}). Give the bytes of the message."
        ) from error
    check_setup(message)
    print(json.dumps(dataclasses.asdict(estimate(message, ranks))))
    return 0
