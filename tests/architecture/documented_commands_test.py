"""Every script that a page of the documentation calls by its path is there and can be started so."""

import os
import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^```(?:sh)?\n(.*?)^```", re.DOTALL | re.MULTILINE)
CALL = re.compile(r"^(?:\$ )?((?:deploy|tests|\.ci|configs)/[\w./-]+)", re.MULTILINE)


def pages():
    return [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]


def calls(page):
    """Paths that stand first in a line of a code block."""
    return [call for block in BLOCK.findall(page.read_text(encoding="utf-8")) for call in CALL.findall(block)]


class DocumentedCommands(unittest.TestCase):
    def test_can_be_started_by_their_path(self):
        found = [(page, call) for page in pages() for call in calls(page)]
        self.assertGreater(len(found), 20)
        for page, call in found:
            with self.subTest(page=page.relative_to(ROOT).as_posix(), call=call):
                self.assertTrue(os.access(ROOT / call, os.X_OK), f"{call} cannot be started")


if __name__ == "__main__":
    unittest.main()
