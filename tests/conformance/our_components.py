#!/usr/bin/python3
"""Conformance of the components that come with Copepod.

    our_components.py --names             the components, one name per line
    our_components.py BUILD NAME          checks one of them, as the test suite does
    our_components.py BUILD --page        checks all of them in full, writes docs/results/conformance.md
"""

import dataclasses
import os
import shutil
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "results" / "conformance.md"
EXAMPLES = ROOT / "examples" / "python"
JAVASCRIPT = ROOT / "examples" / "javascript_fluid"
SKIPPED = 77  # exit code that ctest counts as skipped
STRICT = ("-Wall", "-Wextra", "-Werror", "-fsanitize=address")
JOBS = 8  # most of the time a component waits, or is waited for
# In the test suite, of components whose kit, or program, another one of them tests in all groups.
PARTLY = ("handshake", "exactly once", "checkpoints", "control lane", "ends", "processes", "physics")


@dataclasses.dataclass(frozen=True)
class Component:
    name: str
    role: str
    command: tuple
    solver: str = ""
    quick: bool = True  # in the test suite
    groups: tuple = ()  # there; none: all
    compiler: tuple = ()  # of the first word, a source among the examples

    def compiled(self, build, folder):
        """The component with its program, which uses libcopepod, made in a folder."""
        if not self.compiler:
            return self
        program = f"{folder}/{self.name}"
        source = ROOT / "examples" / self.command[0]
        library = [f"-I{ROOT}/in_process", f"-L{build}/bin", f"-Wl,-rpath,{build}/bin", "-lcopepod"]
        subprocess.run([*self.compiler, *STRICT, source, *library, "-o", program], cwd=folder, check=True)
        return dataclasses.replace(self, command=(program,))

    def conformance(self, build, *options):
        """The command that checks it."""
        solver = ["--solver", self.solver] if self.solver else []
        words = [word.format(bin=build / "bin", examples=EXAMPLES) for word in self.command]
        return [
            str(ROOT / "deploy" / "copepod"),
            "conformance",
            "--role",
            self.role,
            "--jobs",
            str(JOBS),
            *solver,
            *options,
            "--",
            *words,
        ]


COMPONENTS = (
    Component("lattice_boltzmann", "fluid", ("{bin}/fluid_service",), "lattice_boltzmann"),
    Component(
        "lattice_boltzmann_on_2_ranks",
        "fluid",
        ("mpirun", "-n", "2", "--oversubscribe", "{bin}/fluid_service"),
        "lattice_boltzmann",
        groups=PARTLY,
    ),
    Component("stokes", "fluid", ("{bin}/fluid_service",), "stokes"),
    Component("vacuum", "fluid", ("{bin}/fluid_service",), "vacuum"),
    Component("python_fluid", "fluid", ("/usr/bin/python3", "{examples}/stokes_drag_fluid.py")),
    Component("javascript_fluid", "fluid", ("node", f"{JAVASCRIPT}/javascript_fluid.js")),
    Component("fortran_fluid", "fluid", ("fortran/stokes_drag.f90",), compiler=("gfortran", "-std=f2018")),
    Component("body_service", "body", ("{bin}/body_service",), quick=False),
    Component("bullet_bodies", "body", ("{bin}/bullet_body_service",)),
    Component("mujoco_bodies", "body", ("{bin}/mujoco_body_service",)),
    Component("python_body", "body", ("/usr/bin/python3", "{examples}/point_masses.py"), groups=PARTLY),
    Component("c_body", "body", ("c/point_masses.c",), compiler=("cc", "-std=c99", "-Wpedantic")),
    Component("python_controller", "controller", ("/usr/bin/python3", "{examples}/triangle_pilot.py"), groups=PARTLY),
    Component("controller", "controller", ("{bin}/triangle_pilot",)),
)


def run(component, build, *options):
    """Exit code of the check; nothing of ours is built for it."""
    with tempfile.TemporaryDirectory() as folder:
        return subprocess.run(
            component.compiled(build, folder).conformance(build, *options),
            stdin=subprocess.DEVNULL,
            check=False,
            env={**os.environ, "COPEPOD_BIN_DIR": str(build / "bin")},
        ).returncode


def reason_to_skip(component):
    """Why this machine cannot run the component; empty if it can."""
    if component.command[0] != "node":
        return ""
    if shutil.which("node") is None:
        return "there is no Node.js here. Install Debian's package nodejs"
    if not (JAVASCRIPT / "node_modules").is_dir():
        return f"its npm packages are not installed. Run: npm ci --prefix {JAVASCRIPT.relative_to(ROOT)}"
    return ""


def write_page(build):
    """Exit code 0 if all components conform; the page is written in any case."""
    columns, codes = {}, []
    for component in COMPONENTS:
        with tempfile.TemporaryDirectory() as folder:
            junit = Path(folder) / "junit.xml"
            codes.append(run(component, build, "--junit", str(junit)))
            columns[component] = _outcomes(ElementTree.parse(junit).getroot())
    PAGE.write_text(_page(columns))
    return max(codes)


def _outcomes(suite):
    """{group: [passed, failed, {reason of a skip}]}"""
    groups = {}
    for case in suite:
        counts = groups.setdefault(case.get("classname").removeprefix("conformance."), [0, 0, set()])
        skip = case.find("skipped")
        if skip is not None:
            counts[2].add(skip.get("message"))
        else:
            counts[1 if case.find("failure") is not None else 0] += 1
    return groups


def _page(columns):
    groups = list(dict.fromkeys(group for column in columns.values() for group in column))
    lines = [
        "# Conformance of our components",
        "",
        "Number of checks of `copepod conformance` that each component passed (and the total, where some failed).",
        "Written by `tests/conformance/our_components.py build --page`; the test suite runs the same checks, for most",
        "components with `--quick`, for some those of some groups. Those in",
        "`tests/conformance/broken_components.py`, each with one defect, fail in the checks for that defect and in no",
        "other (`ctest -R conformance.broken_components`).",
        "",
        "| | " + " | ".join(component.name.replace("_", " ") for component in columns) + " |",
        "|---|" + "---|" * len(columns),
    ]
    for group in groups:
        lines.append(
            f"| {group} | " + " | ".join(_cell(column.get(group, [0, 0, set()])) for column in columns.values()) + " |"
        )
    lines.append(
        "| **all** | "
        + " | ".join(
            _cell([sum(counts[0] for counts in column.values()), sum(counts[1] for counts in column.values()), set()])
            for column in columns.values()
        )
        + " |"
    )
    lines += ["", "Checks that do not apply:", ""]
    for component, column in columns.items():
        reasons = sorted({reason for counts in column.values() for reason in counts[2]})
        if reasons:
            text = f"* {component.name.replace('_', ' ')}: {'; '.join(reasons)}."
            lines += textwrap.wrap(text, 120, subsequent_indent="  ", break_on_hyphens=False)
    return "\n".join(lines) + "\n"


def _cell(counts):
    passed, failed, _ = counts
    return f"{passed} of {passed + failed}" if failed else str(passed)


def main(arguments):
    if arguments == ["--names"]:
        print("\n".join(component.name for component in COMPONENTS))
        return 0
    names = [component.name for component in COMPONENTS]
    if len(arguments) != 2 or arguments[1] not in ("--page", *names):
        sys.exit(f"{__doc__}\nNAME is one of: {', '.join(names)}")
    build, what = Path(arguments[0]).resolve(), arguments[1]
    if what == "--page":
        return write_page(build)
    component = next(component for component in COMPONENTS if component.name == what)
    if reason := reason_to_skip(component):
        print(f"{component.name} is skipped: {reason}.")
        return SKIPPED
    groups = [f"--only={group}" for group in component.groups]
    return run(component, build, *groups, *(["--quick"] if component.quick else []))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
