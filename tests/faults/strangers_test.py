"""Other programs that connect to a run and have no key, or no token: the run continues, with the same bits."""

import itertools
import os
import resource
import shlex
import socket
import subprocess
import tempfile
import threading
import unittest
from contextlib import suppress
from pathlib import Path

import zmq

from hurt_run import CASE, LONGEST_S, PROGRAMS, HurtRun, digest, undisturbed_digest, wait_for
from copepod_component.messages import Envelope, handshake, to_frame

FILES = 1024  # that each process of the run may have open
IDLE, SLOW = 1000, 100  # connections


class Strangers(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="copepod_faults_")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name).resolve()

    def start_halted(self, *arguments):
        """A run whose fluid stands still in a step until the file `halted` is removed."""
        self.halted = self.folder / "halted"
        words = [PROGRAMS / "halting_fluid", "--halt-in", "exchange", "--halt-at-step", "20"]
        command = shlex.join(map(str, [*words, "--halt-file", self.halted]))
        run = HurtRun(self.folder, "--out", "out", "--fluid", command, *arguments)
        self.addCleanup(lambda: run.process.poll() is None and (run.process.terminate(), run.end()))
        resource.prlimit(run.process.pid, resource.RLIMIT_NOFILE, (FILES, FILES))
        self.assertTrue(wait_for(self.halted.exists, LONGEST_S), "".join(run.stderr))
        return run

    def assert_finishes(self, run):
        self.halted.unlink()
        self.assertEqual(run.end(LONGEST_S), 0, "".join(run.stderr))
        self.assertEqual(digest(self.folder), undisturbed_digest())
        self.assertEqual(run.final_leftovers(), [])

    def connect(self):
        stranger = socket.create_connection(self.address)
        self.addCleanup(stranger.close)
        return stranger

    def test_a_thousand_idle_and_a_hundred_slow_connections(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.address = probe.getsockname()
        run = self.start_halted("--set", f"services.transport=tcp://127.0.0.1:{self.address[1]}")
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        crowd = [self.connect() for _ in range(IDLE)]
        is_over = threading.Event()
        slow = threading.Thread(target=self.trickle, args=([self.connect() for _ in range(SLOW)], is_over))
        slow.start()
        self.addCleanup(lambda: (is_over.set(), slow.join()))
        coupler = Path(f"/proc/{run.pid('coupler')}/fd")
        self.assertTrue(wait_for(lambda: len(os.listdir(coupler)) < FILES // 2, 10), "the coupler keeps them all")
        self.assert_finishes(run)
        self.assertEqual(len(crowd), IDLE)

    def test_a_peer_with_no_token_that_asks_and_never_reads(self):
        """It sends 5000 Hellos to the socket of a run of the same user."""
        run = self.start_halted()
        with zmq.Context() as context, context.socket(zmq.DEALER) as peer:
            peer.linger = 0
            (path,) = Path("/tmp").glob(f"copepod-{run.process.pid}-*/coupler.ipc")
            peer.connect(f"ipc://{path}")
            message = Envelope(protocol_major=2, step=-1)
            message.hello.role, message.hello.lane, message.hello.instance = handshake.ROLE_BODY, 1, 1
            message.hello.session_token = "guessed"
            for _ in range(5000):
                peer.send(to_frame(message))
            self.assert_finishes(run)

    def test_control_characters_of_a_case_do_not_reach_the_terminal(self):
        case = self.folder / "case.yaml"
        hosts = r'services: {hosts: ["a\x1b[31m\nfaked line\x07"]}'
        case.write_text(CASE.read_text().replace("services: {fluid: {ranks: 2}}", hosts))
        ended = subprocess.run([PROGRAMS / "coupler", "--plan", case], capture_output=True, text=True)
        self.assertEqual(ended.returncode, 2, ended.stderr)
        self.assertNotRegex(ended.stderr, "[\x00-\x09\x0b-\x1f]")
        self.assertIn("has 'a?[31m?faked line?' (not a host)", ended.stderr)

    def trickle(self, strangers, is_over):
        """Each begins ZeroMQ's handshake, byte by byte, and connects again when it is cut off."""
        first_bytes = itertools.cycle(b"\xff" + bytes(8) + b"\x7f\x03")
        while not is_over.wait(0.05):
            byte = bytes([next(first_bytes)])
            for number, stranger in enumerate(strangers):
                try:
                    stranger.send(byte)
                except OSError:
                    stranger.close()
                    with suppress(OSError):  # the run is over
                        strangers[number] = socket.create_connection(self.address)
        for stranger in strangers:
            stranger.close()


if __name__ == "__main__":
    unittest.main()
