"""CURVE keys of a component: proto/transport/lanes.hpp in Python."""

import ipaddress
import os

import zmq

from .errors import CaseError


def read_keys(path):
    """(public, secret, the coupler's public key) from a file of lines "secret KEY", "coupler PUBLIC_KEY"."""
    try:
        if os.stat(path).st_mode & 0o077:
            raise CaseError(
                f"The key file {path} is not usable (other users can read it). Make it private: chmod 600 {path}."
            )
        with open(path, encoding="ascii") as file:
            lines = dict(line.split() for line in file)
        secret, coupler = lines["secret"].encode(), lines["coupler"].encode()
        return zmq.curve_public(secret), secret, coupler
    except (OSError, ValueError, KeyError, zmq.ZMQError) as problem:
        raise CaseError(
            f"The key file {path} is not usable ({problem!r}). Use the file that the deploy command made for this role."
        ) from problem


def require_keys_off_this_machine(endpoint, keys):
    """Raises CaseError if other machines could listen and take part."""
    host = endpoint.removeprefix("tcp://").rpartition(":")[0].strip("[]")
    if keys is None and endpoint.startswith("tcp://") and not _is_loopback(host):
        raise CaseError(
            f"The endpoint {endpoint} requires keys (other machines could listen and take part). Give --keys, "
            "or start the run with deploy/copepod, which makes them."
        )


def next_event(monitor):
    """Kind of the next event of a monitored socket (zmq.utils.monitor has this, too, but takes 40 ms to import)."""
    return int.from_bytes(monitor.recv_multipart()[0][:2], "little")


class HandshakeMonitor:
    """Observes ZeroMQ's handshakes with the coupler. Create it before the socket connects."""

    _MOST_BROKEN_HANDSHAKES = 3  # in a row, before the first that succeeds

    def __init__(self, socket):
        self._broken_handshakes = 0
        self._is_rejected = False
        self._monitor = socket.get_monitor_socket(
            zmq.EVENT_HANDSHAKE_FAILED_AUTH | zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
        )

    def is_rejected(self):
        """Whether a key is wrong or missing, here or at the coupler."""
        while self._monitor.poll(0):
            event = next_event(self._monitor)
            self._is_rejected |= event in (zmq.EVENT_HANDSHAKE_FAILED_AUTH, zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL)
            self._broken_handshakes += 1
        return self._is_rejected or self._broken_handshakes >= self._MOST_BROKEN_HANDSHAKES


def _is_loopback(host):
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
