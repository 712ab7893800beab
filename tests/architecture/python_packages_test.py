#!/usr/bin/python3
"""Python packages build on each other in one direction, and no module imports itself through others."""

import ast
import unittest
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
FOLDERS = (ROOT / "deploy", ROOT / "proto" / "python")

# package: packages of ours that it may import
MAY_IMPORT = {
    "copepod_component": set(),
    "copepod_conformance": {"copepod_component"},
    "copepod_recording": {"copepod_component", "copepod_conformance"},
    "copepod_run": set(),
    "copepod_bench": {"copepod_run"},
    "copepod_campaign": {"copepod_run"},
    "copepod_report": {"copepod_run"},
    "copepod_validation": {"copepod_campaign", "copepod_report", "copepod_run"},
    "copepod_watch": {"copepod_report", "copepod_run"},
    "copepod_command": {
        "copepod_bench",
        "copepod_campaign",
        "copepod_report",
        "copepod_run",
        "copepod_validation",
        "copepod_watch",
    },
}


def modules():
    """{dotted name: its file} of all modules of the packages."""
    files = [(folder, path) for folder in FOLDERS for path in sorted(folder.glob("copepod_*/**/*.py"))]
    return {
        ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): path for root, path in files
    }


def imports(path, known):
    """Names of `known` modules that a file imports, also inside functions."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            members = {f"{node.module}.{alias.name}" for alias in node.names} & known
            found |= members or {node.module}
    return found & known


class PythonPackages(unittest.TestCase):
    def setUp(self):
        known = modules()
        self.graph = {name: imports(path, set(known)) - {name} for name, path in known.items()}

    def test_packages_import_only_what_lies_below_them(self):
        for name, imported in self.graph.items():
            package = name.partition(".")[0]
            above = {other.partition(".")[0] for other in imported} - MAY_IMPORT[package] - {package}
            self.assertEqual(above, set(), f"{name} must not import these packages")

    def test_there_are_no_cycles_of_imports(self):
        try:
            TopologicalSorter(self.graph).prepare()
        except CycleError as cycle:
            self.fail(" imports ".join(cycle.args[1]))


if __name__ == "__main__":
    unittest.main()
