#!/usr/bin/python3
"""`copepod conformance` receives what a component sent before it ended, however late it arrives.

    late_messages_test.py BUILD      folder of a build that is complete
"""

import os
import sys
import tempfile
import time
import unittest
from pathlib import Path

import zmq

from copepod_component.messages import Envelope, handshake, to_frame
from copepod_conformance.component_process import Component
from copepod_conformance.conversation import Conversation
from copepod_conformance.verdicts import Violation

PATIENCE_S = 20.0
LATE_S = 1.0

# The first process ends while the second one, as slow as a busy machine, still has messages to deliver.
COMPONENT = """
import os, subprocess, sys, time, zmq

late_s, hello, reply = sys.argv[1:4]
endpoint = sys.argv[sys.argv.index("--endpoint") + 1]
if "--second" not in sys.argv:
    subprocess.Popen([sys.executable, *sys.argv, "--second"])
    time.sleep(0.5)
    os._exit(65)
with zmq.Context() as context, context.socket(zmq.DEALER) as lane:
    lane.connect(endpoint)
    lane.send(bytes.fromhex(hello))
    time.sleep(0.5 + float(late_s))
    if reply != "none":
        lane.send(bytes.fromhex(reply))
"""


def hello():
    message = Envelope(step=-1)
    message.hello.lane = handshake.LANE_DATA
    return to_frame(message).hex()


def saved():
    message = Envelope(step=7)
    message.saved.SetInParent()
    return to_frame(message).hex()


class LateMessages(unittest.TestCase):
    def conversation(self, reply):
        """With a component that ends with code 65 a second before `reply` arrives."""
        folder = self.enterContext(tempfile.TemporaryDirectory())
        script = Path(folder, "component.py")
        script.write_text(COMPONENT)
        command = ["/usr/bin/python3", str(script), str(LATE_S), hello(), reply]
        context = self.enterContext(zmq.Context())
        subject = Component(command, dict(os.environ), folder, context, PATIENCE_S)
        return self.enterContext(Conversation(subject))

    def test_a_reply_is_received_after_the_end_of_the_process(self):
        conversation = self.conversation(saved())
        self.assertEqual(conversation.receive("Saved").name, "Saved")
        self.assertEqual(conversation.await_end(), 65)

    def test_the_end_of_a_process_includes_its_last_message(self):
        conversation = self.conversation(saved())
        self.assertEqual(conversation.await_end(), 65)
        self.assertTrue(conversation.has_mail())

    def test_a_reply_that_was_never_sent_is_not_waited_for(self):
        conversation = self.conversation("none")
        start = time.monotonic()
        with self.assertRaisesRegex(Violation, "the end of the process with exit code 65 instead of Saved"):
            conversation.receive("Saved")
        self.assertLess(time.monotonic() - start, PATIENCE_S / 2)


if __name__ == "__main__":
    sys.argv.pop()
    unittest.main()
