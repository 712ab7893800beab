"""The coupler's socket, and which lane of the component is behind which of its peers."""

import dataclasses

import zmq

from copepod_conformance import protocol
from copepod_conformance.verdicts import Violation

DATA, CONTROL = "data", "control"
_LANE_OF_NUMBER = {protocol.handshake.LANE_DATA: DATA, protocol.handshake.LANE_CONTROL: CONTROL}


@dataclasses.dataclass(frozen=True)
class Received:
    """A message of the component."""

    lane: str
    data: bytes
    envelope: protocol.Envelope

    @property
    def name(self):
        return protocol.message_name(self.envelope)

    @property
    def content(self):
        """The message without its Envelope, as bytes."""
        return protocol.content(self.envelope).SerializeToString(deterministic=True)


class Lanes:
    def __init__(self, context, endpoint):
        self._socket = context.socket(zmq.ROUTER)
        self._socket.linger = 0
        self._socket.rcvhwm = self._socket.sndhwm = 0
        self._socket.router_mandatory = 1
        self._socket.router_handover = 1
        self._socket.bind(endpoint)
        self._peers = {}

    def receive(self, seconds):
        """The next message, or None. A peer is known by the lane that its Hello names."""
        if not self._socket.poll(int(1000 * seconds)):
            return None
        peer, data = self._socket.recv_multipart()[:2]
        try:
            envelope = protocol.checksum.from_bytes(data)
        except (protocol.checksum.Damaged, protocol.Refused) as problem:
            raise Violation(f"bytes that are no message ({problem})") from problem
        if envelope.WhichOneof("body") == "hello":
            self._peers[peer] = _LANE_OF_NUMBER.get(envelope.hello.lane, DATA)
        return Received(self._peers.get(peer, DATA), data, envelope)

    def send(self, lane, content):
        """Sends bytes with their checksum; False if nobody is there, or no longer."""
        return self.send_as_it_is(lane, protocol.checksum.append_to(content))

    def send_as_it_is(self, lane, data):
        try:
            peer = next(peer for peer, its_lane in reversed(self._peers.items()) if its_lane == lane)
            self._socket.send_multipart([peer, data], copy=False)
        except (StopIteration, zmq.ZMQError):
            return False
        return True

    @property
    def closed(self):
        return self._socket.closed

    def close(self):
        self._socket.close()
