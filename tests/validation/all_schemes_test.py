"""`copepod validate --all`: its fast subset, and how it judges."""

import json
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from copepod_session import WholeRunTest  # noqa: E402
from copepod_validation import all_schemes  # noqa: E402
from copepod_validation.all_schemes import Combination  # noqa: E402


class Verdicts(unittest.TestCase):
    """With runs that are made up."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="copepod_test_")
        self.addCleanup(folder.cleanup)
        self.kept = Path(folder.name) / "kept/rows.jsonl"

    def verdicts(self, *ways, build=""):
        """`ways`: what each run gives, (verdict, motion); the first is that of the reference."""
        one = Combination(collision="bgk")
        found = dict(zip((one.reference, one), ((*way, "") for way in ways)))
        build = build or str(ways)
        with mock.patch.object(all_schemes, "run", side_effect=found.get) as run:
            verdicts = [row["verdict"] for row in all_schemes.judged(list(found), 1, build, self.kept)]
        self.runs = run.call_count
        return verdicts

    def test_what_deviates_by_more_than_the_limit_is_wrong_if_nothing_warned_of_it(self):
        motion = np.outer(1 + 0.001 * np.arange(200), np.ones(6))
        self.assertEqual(self.verdicts(("", motion), ("", 1.04 * motion)), ["right", "right"])
        self.assertEqual(self.verdicts(("", motion), ("", 1.06 * motion)), ["right", "wrong"])
        self.assertEqual(self.verdicts(("", motion), ("warned", 1.06 * motion)), ["right", "warned"])
        self.assertEqual(self.verdicts(("", motion), ("", np.nan * motion)), ["right", "wrong"])

    def test_a_run_that_failed_is_wrong_unless_it_was_refused(self):
        motion = np.ones((200, 6))
        self.assertEqual(self.verdicts(("", motion), ("", None)), ["right", "wrong"])
        self.assertEqual(self.verdicts(("", motion), ("refused", None)), ["right", "refused"])
        self.assertEqual(self.verdicts(("", None), ("", motion)), ["wrong", "wrong"])

    def test_what_this_build_has_found_is_not_run_again(self):
        motion = np.outer(1 + 0.001 * np.arange(200), np.ones(6))
        first = self.verdicts(("", motion), ("", 1.06 * motion), build="a")
        self.assertEqual(self.verdicts(("", motion), ("", motion), build="a"), first)
        self.assertEqual(self.runs, 0)
        self.kept.write_text(self.kept.read_text()[:-9])  # the second line, cut off
        self.assertEqual(self.verdicts(("", motion), ("", motion), build="a"), ["right", "right"])
        self.assertEqual(self.runs, 2)
        self.assertEqual(self.verdicts(("", motion), ("", 1.06 * motion), build="b"), first)
        self.assertEqual(len(self.kept.read_text().splitlines()), 2)

    def test_a_reference_that_oscillates_is_wrong(self):
        motion = np.ones((200, 6)) + 0.1 * np.sin(np.arange(200))[:, None]
        self.assertEqual(self.verdicts(("", motion), ("", motion)), ["wrong", "wrong"])


class FastSubset(WholeRunTest):
    def test_nothing_that_check_admits_is_wrong(self):
        self.finish("validate", "--all", "--fast", "--out", "out")
        page = (self.folder / "out/all_schemes.md").read_text()
        self.assertIn("## Wrong\n\nNone.", page)
        rows = (self.folder / "runs/validation/all_schemes.jsonl").read_text().splitlines()
        verdicts = [json.loads(row)["verdict"] for row in rows]
        self.assertEqual(len(verdicts), len(list(all_schemes.combinations(fast=True))))
        self.assertGreater(verdicts.count("right"), len(verdicts) // 3)  # most with bgk are warned of

    def test_refuses_what_chooses_from_the_matrix_of_cases(self):
        session = self.finish("validate", "--all", "--schemes", "parabolic", "--out", "out", code=2)
        self.assertIn("--all has no --schemes", session.last_line)


if __name__ == "__main__":
    unittest.main()
