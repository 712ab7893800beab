#!/usr/bin/python3
"""`.ci/release` on a copy of this tree: it sets one version everywhere, refuses what is not ready, and archives."""

import importlib.machinery
import importlib.util
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
IDENTITY = {"user.name": "A", "user.email": "a@localhost", "commit.gpgsign": "false"}


def git(folder, *words):
    settings = [word for item in IDENTITY.items() for word in ("-c", "=".join(item))]
    subprocess.run(["git", *settings, *words], cwd=folder, check=True, capture_output=True)


class Release(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tree, self.out = Path(folder.name, "tree"), Path(folder.name, "out")
        self.tree.mkdir()
        listed = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
        for name in listed.splitlines():
            target = self.tree / name
            target.parent.mkdir(parents=True, exist_ok=True)
            if (ROOT / name).is_file():
                target.write_bytes((ROOT / name).read_bytes())
                target.chmod((ROOT / name).stat().st_mode)
        git(self.tree, "init", "--quiet")
        changelog = self.tree / "CHANGELOG.md"
        section = re.compile(r"## \[Unreleased\].*?(?=\n## \[)", re.DOTALL)
        changelog.write_text(section.sub("## [Unreleased]\n\n* A change.\n", changelog.read_text(), count=1))
        self.commit()

    def commit(self):
        git(self.tree, "add", "--all")
        git(self.tree, "commit", "--quiet", "--message", "all")

    def release(self, *words):
        """(exit code, output)"""
        done = subprocess.run([self.tree / ".ci/release", *words], capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    def script(self):
        loader = importlib.machinery.SourceFileLoader("release", str(self.tree / ".ci/release"))
        module = importlib.util.module_from_spec(importlib.util.spec_from_loader("release", loader))
        loader.exec_module(module)
        return module

    def test_version_is_set_everywhere(self):
        self.assertEqual(self.release("--set", "77.8.9")[0], 0)
        self.commit()
        script = self.script()
        self.assertEqual(script.problems("77.8.9", self.out), [])
        self.assertEqual(script.notes("77.8.9"), "# Copepod 77.8.9\n\n* A change.\n")
        self.assertEqual(script.archive("77.8.9"), script.archive("77.8.9"))
        self.assertIn("77.8.9 already", self.release("--set", "77.8.9")[1])

    def test_what_is_not_ready_is_refused(self):
        for version in ("2.0", "v2.0.0"):
            self.assertEqual(self.release("--set", version)[0], 2)
        self.assertEqual(self.release("--set", "77.8.9")[0], 0)
        self.assertIn("the tree has changes", self.release("77.8.9", self.out)[1])
        self.commit()
        for name, old, new, message in (
            ("CMakeLists.txt", "VERSION 77.8.9", "VERSION 77.9.0", "CMakeLists.txt states version 77.9.0"),
            ("CITATION.cff", "\nversion: 77.8.9", "\nversion: 1.2.3", "CITATION.cff states version 1.2.3"),
            ("codemeta.json", '"datePublished": "2', '"datePublished": "3', "the dates differ"),
            (
                "CHANGELOG.md",
                "## [Unreleased]\n",
                "## [Unreleased]\n\n* One more.\n",
                "something unreleased: «* One more.»",
            ),
        ):
            with self.subTest(name):
                path = self.tree / name
                text = path.read_text()
                self.assertEqual(text.count(old), 1)
                path.write_text(text.replace(old, new))
                self.commit()
                code, said = self.release("77.8.9", self.out)
                self.assertEqual(code, 1)
                self.assertIn(message, said)
                self.assertFalse(self.out.exists())
                path.write_text(text)
        git(self.tree, "tag", "v77.8.9")
        self.commit()
        self.assertIn("the tag v77.8.9 is at another commit", self.release("77.8.9", self.out)[1])


if __name__ == "__main__":
    unittest.main()
