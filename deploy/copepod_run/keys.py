"""Keys of one run: who does not hold one cannot listen, and who holds a component's cannot play another one.

CURVE (ZeroMQ's encryption, Curve25519) off this machine. Keys are made anew for every run, lie in files that only their
owner can read, and go with the run; no command line carries one.
"""

import os

ROLES = ("coupler", "fluid", "body")


def write_keys(folder):
    """Makes a pair per role; returns role to key file (proto/transport/keys.hpp says what is in it)."""
    import zmq  # only runs over tcp need it

    pairs = {role: [key.decode() for key in zmq.curve_keypair()] for role in ROLES}
    public = {role: pair[0] for role, pair in pairs.items()}
    return {
        role: _write(folder / f"{role}.key", {"secret": pairs[role][1], **_peers_of(role, public)}) for role in ROLES
    }


def _peers_of(role, public):
    """Whom a role must recognise, with their public keys."""
    return {other: public[other] for other in (("fluid", "body") if role == "coupler" else ("coupler",))}


def _write(path, lines):
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "w") as file:
        file.writelines(f"{name} {key}\n" for name, key in lines.items())
    return path
