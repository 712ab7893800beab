#!/usr/bin/python3
"""docs/adding_a_component.md is followed word by word; docs/protocol.md agrees with the table and the checks.

    documentation_test.py BUILD      folder of a build that is complete
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import types
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import protocol_vectors
from copepod_component import validation
from copepod_component.errors import Refused
from copepod_conformance import protocol, suite
from copepod_conformance.cases import BodyCase, ControllerCase, FluidCase

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(sys.argv.pop()).resolve()


class AddingAComponent(unittest.TestCase):
    """Only the folders differ: /tmp becomes a folder of this test, build the build under test."""

    def test_who_follows_the_page_has_two_components_that_conform(self):
        page = (ROOT / "docs" / "adding_a_component.md").read_text()
        with tempfile.TemporaryDirectory() as folder:
            code = re.search(r"save it as `/tmp/(\S+)`:\n\n```python\n(.*?)```", page, re.DOTALL)
            Path(folder, code[1]).write_text(code[2])
            scripts = re.findall(r"```sh\n(.*?)```", page, re.DOTALL)
            self.assertEqual(len(scripts), 3)
            outputs = [self.follow(script, folder) for script in scripts]
            self.assertTrue(Path(folder, "run_with_my_fluid", "summary.json").exists(), outputs[0])
            for output in outputs:
                self.assertIn("\nconformant: ", output)

    def follow(self, script, folder):
        """Output of one block of commands, each of which must succeed."""
        here = (
            script.replace("/tmp/", f"{folder}/")
            .replace("$PWD/build", str(BUILD))
            .replace("--install build", f"--install {BUILD}")
            .replace("build/bin", f"{BUILD}/bin")
        )
        ended = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", here],
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            env={**os.environ, "COPEPOD_BIN_DIR": str(BUILD / "bin")},
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=200,
            check=False,
        )
        self.assertEqual(ended.returncode, 0, f"{here}\n{ended.stdout}")
        return ended.stdout


class InstalledKit(unittest.TestCase):
    """The Python kit and its tools work from an installed prefix, without a checkout."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.prefix = Path(cls.folder.name) / "kit"
        install = ["cmake", "--install", BUILD, "--component", "kit", "--prefix", cls.prefix]
        subprocess.run(install, check=True, stdout=subprocess.DEVNULL)
        cls.python = cls.prefix / "share/copepod/python"

    def run_python(self, *arguments):
        """Standard output of Python with nothing of ours on its path but the installed kit."""
        variables = {"PATH": os.environ["PATH"], "PYTHONPATH": str(self.python)}
        command = ["/usr/bin/python3", "-B", *map(str, arguments)]
        ended = subprocess.run(
            command, cwd=self.folder.name, env=variables, capture_output=True, text=True, timeout=200, check=False
        )
        self.assertEqual(ended.returncode, 0, ended.stdout + ended.stderr)
        return ended.stdout

    def test_named_headers_are_there_and_compile_by_themselves(self):
        """Named by docs/adding_a_component.md, by an example, or by another header, which only has to be there."""
        include = self.prefix / "include/copepod"
        headers = {str(path.relative_to(include)) for path in include.rglob("*.hpp")}
        self.assertGreater(len(headers), 20)
        sources = [ROOT / "docs/adding_a_component.md", ROOT / "docs/moving_to_a_newer_kit.md"]
        sources += (ROOT / "examples").rglob("*.cpp")
        of_docs, of_headers = (
            {
                name
                for path in paths
                for name in re.findall(r"\b(?:proto/|fluid_service/)?((?:[a-z_]+/)+[a-z_]+\.hpp)\b", path.read_text())
            }
            for paths in (sources, include.rglob("*.hpp"))
        )
        foreign = {"nlohmann/json.hpp"}  # an example reads its parameters with it
        self.assertEqual((of_docs | of_headers) - headers, foreign)
        uses_the_drive = "copepod::drive_loads({}, Eigen::VectorXd(), copepod::Kinematics(), loads);"
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(self.compile, sorted(of_docs - foreign)))
        self.compile("geometry/actuator_loads.hpp", f"void use(copepod::Loads& loads) {{ {uses_the_drive} }}")

    def compile(self, header, code=""):
        """Without any other header of ours before it."""
        command = [os.environ.get("CXX", "c++"), "-std=c++20", "-fsyntax-only", "-x", "c++", "-"]
        folders = [f"-I{self.prefix}/include/copepod", "-isystem/usr/include/eigen3"]
        source = f'#include "{header}"\n{code}\n'
        ended = subprocess.run([*command, *folders], input=source, capture_output=True, text=True)
        self.assertEqual(ended.returncode, 0, f"{header}: {ended.stderr}")

    def test_every_module_comes_from_the_prefix(self):
        modules = [
            ".".join(path.relative_to(self.python).with_suffix("").parts)
            for path in self.python.rglob("*.py")
            if "examples" not in path.parts and path.stem not in ("__init__", "__main__", "picture")
        ]
        self.assertGreater(len(modules), 30)
        code = (
            f"import importlib, json, sys; [importlib.import_module(name) for name in {modules}]; "
            "print(json.dumps([m.__file__ for n, m in sys.modules.items() if n.startswith('copepod') and m.__file__]))"
        )
        for path in json.loads(self.run_python("-c", code)):
            self.assertTrue(path.startswith(f"{self.python}/"), path)

    def test_the_tools_test_and_list_without_a_checkout(self):
        example = self.python / "examples/stokes_drag_fluid.py"
        tool = ("-m", "copepod_conformance", "--role", "fluid", "--only", "handshake")
        output = self.run_python(*tool, "--", "/usr/bin/python3", example)
        self.assertIn("\nconformant: ", output)
        recording = Path(self.folder.name) / "run/wire/attempt_001.rec"
        recording.parent.mkdir(parents=True)
        shutil.copy(ROOT / "tests/fuzz/corpus/read_recording.rec", recording)
        self.assertIn("Kinematics", self.run_python("-m", "copepod_recording", "count", "run"))


class ProtocolPage(unittest.TestCase):
    def setUp(self):
        self.page = (ROOT / "docs" / "protocol.md").read_text()

    def test_every_rule_of_a_check_stands_under_its_heading(self):
        headings = set(re.findall(r"^## (.*)$", self.page, re.MULTILINE))
        for role, case in (
            ("fluid", FluidCase(set())),
            ("body", BodyCase(set())),
            ("controller", ControllerCase(set())),
        ):
            subject = types.SimpleNamespace(role=role, case=case, can=lambda feature: True)
            for check in suite.all_checks(subject):
                self.assertIn(check.rule.section, headings, f"{check.group}: {check.name}")
                self.assertIn(check.group, suite.GROUPS)

    def test_the_limits_are_those_of_the_kits(self):
        header = (ROOT / "proto/conversion/limits.hpp").read_text()
        limits = re.search(r"\n## Limits\n(.*?)\n## ", self.page, re.DOTALL)[1]
        for code, text in (
            ("message_bytes = std::size_t{256} << 20", "256 MiB"),
            ("hello_bytes = std::size_t{64} << 10", "64 KiB"),
            ("list_entries = 1'000'000", "1 000 000"),
            ("cells = 1e12", "10¹²"),
            ("driving_nodes = 16", "| 16 |"),
            ("string_bytes = 4096", "4096 bytes"),
            ("features = 1024", "| 1024 |"),
        ):
            self.assertIn(code, header)
            self.assertIn(text, limits)
        kit = (validation.MESSAGE_BYTES, validation.ENTRIES, validation.CELLS, validation.STRING_BYTES)
        self.assertEqual(kit, (256 << 20, 1_000_000, 10**12, 4096))

    def test_the_python_kit_wants_all_six_faces(self):
        setup = FluidCase(set()).setup_request().fluid_setup
        validation.check_setup(setup)
        del setup.boundaries[5]
        with self.assertRaisesRegex(Refused, "boundaries has 5 entries, not 6"):
            validation.check_setup(setup)

    def test_the_message_sequence_is_the_one_of_the_table(self):
        """Each request of the coupler is followed by the reply that the table has for it; no request is missing."""
        drawing = re.search(r"```\n( component .*?)```", self.page, re.DOTALL)[1]
        requests = {}
        for line in drawing.splitlines():
            if asked := re.search(r"◄─+ ([\w |]+)(?:\(n\))? +#\w ─+ │(?: +or (\w+))?", line):
                last = " | ".join(filter(None, (asked[1].strip(), asked[2])))
            elif told := re.search(r"│ ── (\w+)(?:\(n(?:\+1)?\))? #\w ─+►", line):
                requests.update({name: told[1] for name in last.split(" | ")})
        table = {row["message"]: row["reply"] for row in protocol.TRANSITIONS if "reply" in row and "message" in row}
        self.assertEqual({name: table.get(name) for name in requests}, requests)
        self.assertEqual(set(table) - set(requests), {"KinematicsRequest"})  # before the first step of the bodies only

    def test_the_examples_are_the_bytes_that_are_sent(self):
        """Bring them up to date with tests/conformance/protocol_vectors.py --write."""
        self.assertEqual(protocol_vectors.page(self.page), self.page)
        self.assertEqual(protocol_vectors.FILE.read_text(), protocol_vectors.as_json())

    def test_the_states_are_reached_from_the_table(self):
        for role in protocol.SETUP:
            self.assertEqual(
                protocol.states_with_requests(role),
                ["connected", "greeted", "configured", "stepping", "ready", "checkpointing"],
            )
            self.assertEqual(
                protocol.paths(role)["checkpointing"], ["Welcome", protocol.SETUP[role], protocol.STEP[role], "Save"]
            )


if __name__ == "__main__":
    unittest.main()
