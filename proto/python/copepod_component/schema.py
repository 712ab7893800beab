"""Finds the generated message classes and the session table, which the build makes in build/python."""

import importlib
import json
import os
import pathlib
import sys


def _generated_folder():
    here = pathlib.Path(__file__).resolve().parent
    candidates = [os.environ.get("COPEPOD_BUILD_PYTHON"), here.parents[2] / "build" / "python", *sys.path]
    for folder in filter(None, candidates):
        if (pathlib.Path(folder) / "copepod" / "v1" / "envelope_pb2.py").is_file():
            return pathlib.Path(folder)
    raise ImportError(
        "The Python message classes are missing (the build makes them). "
        "Run `ninja -C build copepod_python`, or set COPEPOD_BUILD_PYTHON to the folder that has them."
    )


_folder = _generated_folder()
if str(_folder) not in sys.path:
    sys.path.insert(0, str(_folder))

Envelope = importlib.import_module("copepod.v1.envelope_pb2").Envelope
handshake = importlib.import_module("copepod.v1.handshake_pb2")
control = importlib.import_module("copepod.v1.control_pb2")

# One list of rows for components in every language; see proto/session/transition_table.hpp.
TRANSITIONS = json.loads((_folder / "copepod" / "v1" / "transitions.json").read_text())

PROTOCOL_MAJOR = 1
PROTOCOL_MINOR = 0


def message_name(envelope):
    """Name of the message in an Envelope as in the schema, "FluidSetup"; None if it is empty."""
    field = envelope.WhichOneof("body")
    return None if field is None else Envelope.DESCRIPTOR.fields_by_name[field].message_type.name
