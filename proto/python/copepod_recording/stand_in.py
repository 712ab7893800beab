"""Plays a recorded component to a real coupler: answers every request as the recorded one did.

    stand_in.py ROLE RECORDING TOLERANCE [what every component gets: --endpoint E --session TOKEN …]

`copepod replay RUN_DIR --as ROLE` starts it. A request that differs from the recorded one ends the run, for its
answer would be one to another question.
"""

import sys
from pathlib import Path

_ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(_ROOT / "deploy"), str(_ROOT / "proto" / "python")]

from copepod_component.errors import SolverError  # noqa: E402
from copepod_component.run import Capabilities, serve_component  # noqa: E402

from copepod_recording.comparison import differences  # noqa: E402
from copepod_recording.reader import Recording, message_name  # noqa: E402
from copepod_recording.script import script_of  # noqa: E402


class StandIn:
    """What the component kit serves: `perform` fills in the recorded reply."""

    def __init__(self, role, script, tolerance):
        self.role = role
        self._tolerance = tolerance
        self._recorded = {(exchange.name, exchange.request.step): exchange for exchange in script.exchanges}

    def perform(self, request, reply):
        name = message_name(request)
        if name == "Save":
            Path(request.save.path).write_bytes(b"")
            reply.saved.SetInParent()
            return
        exchange = self._recorded.get((name, request.step))
        if exchange is None or exchange.reply is None:
            raise SolverError(
                f"{name} of step {request.step} is not in the recording (it ends before; so far all was as recorded). "
                "Run fewer steps, or replay an attempt that finished."
            )
        recorded = type(request)()
        recorded.ParseFromString(exchange.request.SerializeToString())
        recorded.sequence = request.sequence
        for text in differences(recorded, request, self._tolerance):
            raise SolverError(
                f"{name} of step {request.step} is not what was recorded ({text}). "
                "Compare coupler and case with those of the recording."
            )
        session = (reply.session_id, reply.epoch, reply.sequence)
        reply.ParseFromString(exchange.reply.SerializeToString())
        reply.session_id, reply.epoch, reply.sequence = session

    def follow_up(self, name):
        """Nothing is left to compute."""


def main():
    role, path, tolerance = sys.argv[1:4]
    del sys.argv[1:4]
    script = script_of(Recording(path), role)
    if script.hello is None:
        sys.exit(f"error: {path} has no {role} component (it never said Hello). Record again.")
    announced = script.hello.capabilities
    capabilities = Capabilities(f"Recorded {announced.name}", announced.version, list(announced.features))
    return serve_component(StandIn(role, script, float(tolerance)), capabilities)


if __name__ == "__main__":
    sys.exit(main())
