#!/usr/bin/python3
""".ci/check_prose finds every kind of phrase in every kind of file, and leaves plain English alone."""

import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

CALM = (
    """\
# A page

The coupler sends the kinematics; there is no other copy. It is no longer needed after the step.

| a table | a row may be wide |
|---|---|
"""
    + f"| {'wide ' * 30} | row |\n"
)


class PlantedProse(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)

    def findings(self, name, text):
        """Lines that the check prints for a tree of this one file."""
        file = self.root / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        ended = subprocess.run([ROOT / ".ci/check_prose", self.root], capture_output=True, text=True, check=False)
        file.unlink()
        found = [line for line in ended.stdout.splitlines() if ": error: " in line]
        self.assertEqual(ended.returncode, 1 if found else 0, ended.stdout + ended.stderr)
        return found

    def expect_one(self, name, text, place, words):
        found = self.findings(name, text)
        self.assertEqual(len(found), 1, f"{name}: {text}: {found}")
        self.assertTrue(found[0].startswith(f"{name}:{place}: error: "), found[0])
        self.assertIn(words, found[0])

    def test_plain_english_passes(self):
        self.assertEqual(self.findings("docs/page.md", CALM), [])
        self.assertEqual(self.findings("proto/a.hpp", "int seal_count_of_animals;\n".replace("seal_", "")), [])
        self.assertEqual(self.findings("proto/a.cpp", "double impulse = 1;  // not a pulsation\n"), [])

    def test_each_phrase_is_found(self):
        for phrase in (
            "'x' is no sphere",
            "ranks are no bodies",
            "nobody reads it",
            "Somebody else starts it",
            "whoever calls it",
            "the case says so",
            "the page tells why",
            "the body service knows nothing",
            "the coupler wants it",
            "the run goes on",
            "so small a domain",
            "it belongs into advance",
            "Passed over: threads",
            "closed without a word",
            "in whose shadow it works",
            "walls lose their place",
            "time must go on",
            "Mend its exchange",
            "kits do the speaking",
            "as if it had not been asked",
            "in one sitting",
        ):
            with self.subTest(phrase):
                self.expect_one("docs/page.md", f"# A page\n\nHere {phrase}.\n", 3, "not plain English")

    def test_each_metaphor_is_found_in_prose_names_and_paths(self):
        for name, text in (
            ("a.hpp", "class Doorkeeper;"),
            ("a.cpp", "auto x = seal_of(bytes);"),
            ("a.cpp", "send(kSealBytes);"),
            ("a.cpp", "PulseBoard board;"),
            ("a.cpp", "// the pulse of a rank"),
            ("a.cpp", "Audience audience;"),
            ("a.md", "The greeting comes first."),
            ("a.proto", "PHASE_GREETING = 1;"),
            ("audience.cpp", ""),
        ):
            with self.subTest(f"{name}: {text}"):
                self.expect_one(name, text + "\n", 1, "metaphor")

    def test_prose_is_found_in_every_kind_of_file(self):
        for name, text, place in (
            ("a.cpp", "int a;\n/// The number of those that nobody\n/// ever needs.\n", 2),
            ("a.cpp", 'throw Error("the shape is "\n            "no sphere");\n', 1),
            ("a.cpp", "int a;\n\nint b;  // nobody reads it\n", 3),
            ("a.cpp", "/* a\n * nobody */\n", 2),
            ("a.proto", "message A {  // somebody's\n}\n", 1),
            ("a.py", '"""A text.\n\nThat nobody reads.\n"""\n', 3),
            ("a.py", 'print(f"{shape} is no sphere")\n', 1),
            ("a.py", "x = 1  # nobody\n", 1),
            ("a.yaml", "a: 1  # nobody\n", 1),
            ("a.json", '{"description": "a shape that is no sphere"}\n', 1),
            ("CMakeLists.txt", "# nobody\nproject(a)\n", 1),
            ("command", "#!/usr/bin/python3\nprint('nobody')\n", 2),
        ):
            with self.subTest(f"{name}: {text}"):
                self.expect_one(name, text, place, "not plain English")

    def test_phrases_are_found_across_lines(self):
        self.expect_one("a.md", "The shape that was given here is\nno sphere.\n", 1, "is no")
        self.expect_one("a.py", '"""A sentence in which the run goes\non and on."""\n', 1, "goes on")

    def test_code_is_not_prose(self):
        self.assertEqual(self.findings("a.cpp", "bool nobody = says(wants);  // plain\n"), [])
        self.assertEqual(self.findings("a.py", "knows = tells(nobody)\n"), [])

    def test_long_lines_and_orphans(self):
        words = "word " * 30
        self.expect_one("a.md", f"# A page\n\n{words}\n", 3, "columns")
        self.expect_one("a.cpp", f"// {words}\n", 1, "columns")
        self.expect_one("a.py", f"x = 1\n# {words}\n", 2, "columns")
        self.expect_one(
            "a.hpp", "/// The force on a body, and the torque about its\n/// centre.\n", 2, "alone on a line"
        )
        self.expect_one("a.py", '"""The force on a body, and the torque about its\ncentre."""\n', 2, "alone on a line")
        self.assertEqual(self.findings("a.hpp", "int a;  ///< SIGINT\nint b;  ///< SIGTERM\n"), [])
        self.assertEqual(self.findings("a.hpp", "/// The force on a body:\n/// F\n"), [])


if __name__ == "__main__":
    unittest.main()
