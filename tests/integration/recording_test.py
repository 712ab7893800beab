"""What a run records can be read, replayed bit by bit, and seen in a trace."""

import json
import os
import signal
import unittest
from dataclasses import replace
from pathlib import Path

from copepod_session import ROOT, CommandTest, wait_until
from google.protobuf.descriptor_pb2 import FileDescriptorSet

from copepod.v1.envelope_pb2 import Envelope
from copepod.v1.recording_pb2 import Record
from copepod_component.messages import message_name
from copepod_recording import trace
from copepod_recording.reader import Recording, UnreadableRecording
from copepod_recording.replay import differences

PROGRAMS = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin"))
QUICK = ROOT / "configs/quick/three_sphere.yaml"
STEPS = 40
SHORT = ("--set", f"run.steps={STEPS}", "--set", "output.fields.mean_over_steps=[0, 0]")
PYTHON_BODIES = ("/usr/bin/python3", ROOT / "examples/python/point_masses.py")


class RecordedRun(CommandTest):
    programs = PROGRAMS

    def run_command(self, *arguments, code=0):
        """Output of `copepod …`, which must end with `code`."""
        session = self.start(*arguments)
        self.assertEqual(session.end(timeout_s=100), code, "".join(session.stderr))
        self.last_words = "".join(session.stderr)
        return "".join(session.stdout)

    def record(self, *arguments, out="out"):
        """Summary of a short run with everything recorded."""
        self.run_command(
            "run", QUICK, *SHORT, "--set", "output.wire=true", "--set", "output.trace=true", *arguments, "--out", out
        )
        return json.loads((self.folder / out / "summary.json").read_text())


class Wire(RecordedRun):
    def test_a_recording_changes_no_bit_and_holds_every_message(self):
        recorded = self.record()
        self.run_command("run", QUICK, *SHORT, "--out", "plain")
        plain = json.loads((self.folder / "plain/summary.json").read_text())
        self.assertEqual(recorded["digest"], plain["digest"])
        self.assertFalse((self.folder / "plain/wire").exists() or (self.folder / "plain/trace").exists())

        recording = Recording(self.folder / "out/wire/attempt_001.rec")
        counts = {}
        for message, envelope in recording.messages():
            key = (message.role, message.lane, message.direction, message_name(envelope))
            counts[key] = counts.get(key, 0) + 1
        self.assertEqual(recording.ending, "")
        self.assertEqual(counts[(1, 1, 1, "Kinematics")], STEPS)
        self.assertEqual(counts[(1, 1, 2, "Loads")], STEPS)
        self.assertEqual(counts[(2, 1, 1, "AppliedLoads")], STEPS)
        self.assertEqual(counts[(2, 1, 2, "Kinematics")], STEPS + 1)  # the first was asked for
        for role in (1, 2):
            self.assertGreaterEqual(counts[(role, 1, 2, "Hello")], 1)
            self.assertGreaterEqual(counts[(role, 2, 2, "Hello")], 1)
            self.assertEqual(counts[(role, 1, 2, "Finished")], 1)

        table = self.run_command("recording", "count", "out")
        self.assertRegex(table, rf"fluid +to +Kinematics +{STEPS} ")
        self.assertEqual(self.last_words, "")
        self.assertEqual(len(self.run_command("recording", "list", "out").splitlines()), sum(counts.values()))

    def test_our_components_give_the_recorded_replies_bit_by_bit(self):
        self.record()
        self.assertIn("replies agree bit by bit", self.run_command("replay", "out", "--fluid", "--ranks", "2"))
        self.assertIn("replies agree bit by bit", self.run_command("replay", "out", "--body"))
        self.assertFalse((self.folder / "out/trace/attempt_002").exists())

    def test_another_solver_is_told_from_ours_by_step_body_and_field(self):
        self.run_command(
            "run",
            ROOT / "configs/quick/vacuum.yaml",
            "--set",
            f"run.steps={STEPS}",
            "--set",
            "output.wire=true",
            "--set",
            "body.integrator=semi_implicit_euler",
            "--set",
            "swimmers.0.spring.damping_N_s_per_m=0",
            "--out",
            "out",
        )
        tampered = self.folder / "tampered_fluid.py"
        tampered.write_text(TAMPERED_FLUID)
        replay = ("replay", "out", "--fluid")
        output = self.run_command(*replay, "--", "/usr/bin/python3", tampered, code=70)
        self.assertIn("step 7: loads.force_N[4] (body 1, y): 1e-12 instead of 0.0", output)
        self.assertIn("1 values in", self.last_words)

    def test_a_recorded_component_stands_in_for_a_real_one(self):
        for role in ("fluid", "body"):
            recorded = self.record(out=f"out_{role}")
            self.run_command("replay", f"out_{role}", "--as", role, "--out", f"again_{role}")
            again = json.loads((self.folder / f"again_{role}/summary.json").read_text())
            self.assertEqual(again["digest"], recorded["digest"])

    def test_a_stand_in_refuses_a_question_that_was_not_recorded(self):
        self.record()
        case = self.folder / "out/case.yaml"
        as_they_are = case.read_text().replace("load_averaging: two_step", "load_averaging: none")
        case.write_text(as_they_are.replace("virtual_mass: auto", "virtual_mass: none"))
        self.run_command("replay", "out", "--as", "body", "--out", "again", code=70)
        self.assertIn("is not what was recorded (applied_loads.force_N", self.last_words)

    def test_a_run_without_a_recording_says_how_to_make_one(self):
        self.run_command("run", QUICK, *SHORT, "--out", "out")
        self.run_command("replay", "out", "--fluid", code=2)
        self.assertIn("--set output.wire=true", self.last_words)
        self.run_command("recording", "trace", "out", code=2)
        self.assertIn("--set output.trace=true", self.last_words)


class CutOff(RecordedRun):
    def test_everything_before_the_cut_or_the_damage_is_read(self):
        self.record()
        path = self.folder / "out/wire/attempt_001.rec"
        whole = path.read_bytes()
        messages = len(list(Recording(path).messages()))
        before = messages
        for size in (len(whole) - 1, len(whole) // 2, len(whole) // 3):
            path.write_bytes(whole[:size])
            recording = Recording(path)
            left = len(list(recording.messages()))
            self.assertLess(0, left)
            self.assertLess(left, before)
            self.assertIn("cut off at byte", recording.ending)
            before = left
        self.assertIn("replies agree", self.run_command("replay", "out", "--body"))
        self.assertRegex(self.last_words, "attempt_001.rec is cut off at byte [0-9]+; what comes before was used")

    def test_a_changed_byte_is_seen_wherever_it_is(self):
        """In a message by its checksum; in what surrounds it, if it cannot be read any more."""
        self.record()
        path = self.folder / "out/wire/attempt_001.rec"
        whole = path.read_bytes()
        messages = list(Recording(path).messages())
        recorded = next(
            recorded
            for recorded, envelope in messages[len(messages) // 2 :]
            if message_name(envelope) == "Kinematics" and recorded.role == 2
        )
        inside = whole.index(recorded.envelope) + len(recorded.envelope) // 2
        path.write_bytes(whole[:inside] + bytes([whole[inside] ^ 1]) + whole[inside + 1 :])
        damaged = [message for message, envelope in Recording(path).messages() if envelope is None]
        self.assertEqual([message.time_ns for message in damaged], [recorded.time_ns])
        self.assertEqual(self.run_command("recording", "list", "out").count("not an intact Envelope"), 1)
        self.assertIn("replies agree", self.run_command("replay", "out", "--body"))
        self.assertRegex(self.last_words, "attempt_001.rec is damaged after [0-9]+ exchanges; what comes before was")

        record = inside - len(recorded.envelope) // 2
        while whole[record : record + 1] != b"\x12":  # tag of Record.message
            record -= 1
        for content, ending in (
            (whole[:record] + b"\xff" + whole[record + 1 :], "damaged"),  # a tag that does not exist
            (whole[:record] + bytes(len(whole) - record), "damaged"),  # zeros, as after a loss of power
            (whole[: record - 1] + b"\xff\xff\x7f" + whole[record + 2 :], "damaged|cut off"),  # a length
        ):
            path.write_bytes(content)
            recording = Recording(path)
            left = len(list(recording.messages()))
            self.assertTrue(0 < left < len(messages))
            self.assertRegex(recording.ending, f"^({ending}) at byte [0-9]+$")

    def test_what_is_no_recording_is_refused(self):
        def delimited(message):
            return bytes([len(message)]) + message  # shorter than 128 bytes

        schema = FileDescriptorSet()
        schema.file.add(name="copepod/v1/recording.proto")
        start = delimited(schema.SerializeToString())
        phase = delimited(Record(phase={"name": "bulk"}).SerializeToString())
        for content, words in (
            (b"", "is not a recording (it does not start like one). Name a file of wire/ or trace/."),
            (b"hello", "is not a recording"),
            (b"\0" * 16, "is not a recording"),
            (b"\xff" * 16, "is not a recording"),
            (start[:-1], "is not a recording"),
            (start, "has no header (cut off, or damaged). Record again."),
            (start + phase, "has no header"),
            (start + b"\0", "has no header"),
            (b"\x89CPDREC\n" + b"\0" * 16, "cannot be read (it has the format of recordings of version 1.0)"),
        ):
            path = self.folder / "x.rec"
            path.write_bytes(content)
            with self.assertRaises(UnreadableRecording) as refused:
                Recording(path)
            self.assertIn(words, str(refused.exception))
        wire = self.folder / "earlier/wire"
        wire.mkdir(parents=True)
        path.rename(wire / "attempt_001.rec")
        for command in (("recording", "list", "earlier"), ("recording", "count", "earlier")):
            self.run_command(*command, code=73)
            self.assertRegex(
                self.last_words, "^error: .*version 1.0.* Record again, or use the tools of that version.$"
            )

    def test_a_coupler_that_is_killed_leaves_a_recording_up_to_its_last_record(self):
        session = self.start("run", QUICK, "--set", "output.wire=true", "--set", "output.trace=true", "--out", "out")
        wire = self.folder / "out/wire/attempt_001.rec"
        trace = self.folder / "out/trace/attempt_001/coupler.rank0.rec"
        for path, size in ((wire, 200_000), (trace, 20_000)):  # more than 100 records
            wait_until(lambda path=path, size=size: path.exists() and path.stat().st_size > size, f"records in {path}")
        session.kill(signal.SIGKILL, "coupler")
        session.end(timeout_s=60)
        for path in (wire, trace):
            recording = Recording(path)
            found = [envelope for _, envelope in recording.messages()] or list(recording.phases())
            self.assertGreater(len(found), 100)
            self.assertNotIn(None, found)
            self.assertRegex(recording.ending, "^(cut off at byte [0-9]+)?$")


class Trace(RecordedRun):
    def test_the_trace_nests_and_shows_the_early_reply(self):
        self.record("--ranks", "2")
        self.run_command("recording", "trace", "out", "--steps", "10:20", "--picture", "trace.png")
        self.assertGreater((self.folder / "trace.png").stat().st_size, 5000)
        events = json.loads((self.folder / "out/trace.json").read_text())["traceEvents"]
        tracks = {}
        names = {event["args"]["name"] for event in events if event["name"] == "process_name"}
        self.assertEqual(names, {"coupler", "body", "fluid rank 0", "fluid rank 1", "messages"})
        for event in events:
            if event["ph"] == "X":
                self.assertGreaterEqual(event["dur"], 0)
                self.assertGreaterEqual(event["ts"], 0)
                tracks.setdefault((event["pid"], event["tid"]), []).append(event)
            else:
                self.assertEqual(event["ph"], "M")
        threads = {(event["pid"], event["tid"]) for event in events if event["name"] == "thread_name"}
        self.assertEqual(set(tracks), threads)
        for track in tracks.values():
            self.assert_nests(track)
        phases = {event["name"] for track in tracks.values() for event in track}
        self.assertLessEqual(
            {"exchanging", "map", "bulk", "halo", "integrate", "waiting", "Kinematics → Loads"}, phases
        )

        folder = self.folder / "out/trace/attempt_001"
        timelines = trace.read([Recording(path) for path in sorted(folder.glob("*.rec"))])
        found = trace.overlap(timelines)
        self.assertEqual(found["steps"], STEPS - 1)

    def test_what_cannot_be_drawn_is_refused_by_name(self):
        self.record("--ranks", "1")
        for arguments, code, words in (
            (
                ("--steps", "10000:10002", "--picture", "p.png"),
                2,
                f"nothing to draw (the recorded steps are 0 to {STEPS})",
            ),
            (("--picture", "p.txt"), 2, "--picture: p.txt is neither PNG nor SVG"),
            (("--out", "nosuch/x"), 73, "nosuch/x cannot be used (No such file or directory)"),
        ):
            self.run_command("recording", "trace", "out", *arguments, code=code)
            self.assertIn(words, self.last_words)
            self.assertNotIn("Traceback", self.last_words)

    def assert_nests(self, events):
        """Two phases of one track are apart, or one lies in the other; times are rounded to 1 ns."""
        open_ends = []
        for event in sorted(events, key=lambda event: (event["ts"], -event["dur"])):
            while open_ends and open_ends[-1] <= event["ts"] + 2e-3:
                open_ends.pop()
            end = event["ts"] + event["dur"]
            if open_ends:
                self.assertLessEqual(end, open_ends[-1] + 2e-3, event)
            open_ends.append(end)


class Shadow(unittest.TestCase):
    """Figures of a trace made by hand, in microseconds."""

    @staticmethod
    def timelines(bulk_end, asked):
        def phase(name, step, begin, end):
            return trace.Phase(name, step, begin * 1000, end * 1000)

        wait_end = max(bulk_end, asked) + 5
        fluid = [
            phase("exchanging", 0, 0, 10),
            phase("advancing", 0, 10, bulk_end),
            phase("waiting", 0, bulk_end, wait_end),
            phase("exchanging", 0, wait_end, wait_end + 1),  # the request came again
        ]
        coupler = [
            phase("wait for fluid", 0, 0, 12),
            phase("couple", 0, 12, 20),
            phase("wait for fluid", 1, asked, wait_end),
        ]
        return [trace.Timeline("coupler", 0, coupler), trace.Timeline("fluid", 0, fluid)]

    def test_all_is_hidden_when_the_bulk_update_takes_longer(self):
        found = trace.overlap(self.timelines(bulk_end=110, asked=60))
        self.assertEqual(
            (found["hidden"], found["hidden_steps"], found["bulk_us"], found["round_trip_us"]), (1, 1, 100, 50)
        )

    def test_the_rest_is_not_hidden_when_it_is_shorter(self):
        found = trace.overlap(self.timelines(bulk_end=35, asked=60))
        self.assertEqual((found["hidden"], found["hidden_steps"], found["waited_us"]), (0.5, 0, 30))

    def test_what_happens_before_the_bulk_update_begins_is_not_hidden(self):
        coupler, fluid = self.timelines(bulk_end=110, asked=60)
        late = [replace(phase, begin_ns=60_000) if phase.name == "advancing" else phase for phase in fluid.phases]
        found = trace.overlap([coupler, trace.Timeline("fluid", 0, late)])
        self.assertEqual((found["hidden"], found["round_trip_us"]), (0, 50))


class Comparison(unittest.TestCase):
    def test_sees_single_bits_and_honours_the_tolerance(self):
        a, b = Envelope(session_id=1, sequence=5, step=3), Envelope(session_id=2, sequence=6, step=3)
        a.kinematics.position_m.extend([0.0, 1.0, 2.0])
        b.kinematics.position_m.extend([0.0, 1.0, 2.0])
        self.assertEqual(list(differences(a, b)), [])
        b.kinematics.position_m[0] = -0.0
        self.assertEqual(list(differences(a, b)), ["kinematics.position_m[0] (body 0, x): -0.0 instead of 0.0"])
        b.kinematics.position_m[0], b.kinematics.position_m[2] = 0.0, 2.0000001
        self.assertEqual(len(list(differences(a, b))), 1)
        self.assertEqual(list(differences(a, b, tolerance=1e-6)), [])
        b.kinematics.position_m.append(1.0)
        self.assertEqual(list(differences(a, b)), ["kinematics.position_m: 4 values instead of 3"])
        self.assertEqual(list(differences(b, a)), ["kinematics.position_m: 3 values instead of 4"])
        b.step = 4
        self.assertIn("step: 4 instead of 3", list(differences(a, b)))
        self.assertEqual(list(differences(a, Envelope(step=3))), ["kinematics: missing"])
        self.assertEqual(list(differences(Envelope(step=3), a)), ["kinematics: not expected"])


TAMPERED_FLUID = """
import sys
import numpy as np
from copepod_component import Capabilities, Summary, run_fluid_component

class Vacuum:
    def __init__(self, setup, context):
        self.bodies = len(setup.bodies)
    def exchange(self, kinematics):
        force = np.zeros((self.bodies, 3))
        if kinematics.step == 7:
            force[1, 1] = 1e-12
        return force, np.zeros((self.bodies, 3))
    def advance(self):
        pass
    def summarise(self):
        return Summary()

sys.exit(run_fluid_component(Vacuum, Capabilities("tampered", "1", [])))
"""


if __name__ == "__main__":
    unittest.main()
