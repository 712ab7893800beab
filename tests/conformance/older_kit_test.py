#!/usr/bin/python3
"""Components of earlier releases, with the kit that they were built with and with the one of this release.

    older_kit_test.py BUILD                    folder of a build that is complete
    older_kit_test.py --write RELEASE BUILD    keeps the Python kit of this release and its examples as tests/released/
                                               kit_RELEASE.tar.gz; RELEASE is MAJOR.MINOR
"""

import gzip
import io
import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RELEASED = ROOT / "tests/released"
MOVING = ROOT / "docs/moving_to_a_newer_kit.md"
BUILD = Path(sys.argv.pop()).resolve()
VACUUM = ROOT / "configs/quick/vacuum.yaml"
CASE = ["--set", "fluid.solver=external", "--set", "fluid.density_kg_per_m3=1360", "--set", "run.steps=200"]
CASE += ["--set", "fluid.kinematic_viscosity_m2_per_s=7.36e-5"]


def archive_of(release):
    return RELEASED / f"kit_{release}.tar.gz"


class Kits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name).resolve()

    @classmethod
    def unpack(cls, release):
        """The folder of the kit."""
        with tarfile.open(archive_of(release)) as archive:
            archive.extractall(cls.folder)
        return cls.folder / f"kit_{release}"

    def run_case(self, name, **components):
        """What `copepod run` printed, ended with, and left in summary.json; `components`: role and command."""
        command = [ROOT / "deploy/copepod", "run", VACUUM, *CASE, "--out", self.folder / name]
        for role, component in components.items():
            command += [f"--{role}", component]
        environment = {**os.environ, "COPEPOD_BIN_DIR": str(BUILD / "bin")}
        done = subprocess.run(
            list(map(str, command)), env=environment, capture_output=True, text=True, timeout=220, check=False
        )
        summary = self.folder / name / "summary.json"
        return done, json.loads(summary.read_text()) if summary.exists() else {}

    def digest(self, name, **components):
        done, summary = self.run_case(name, **components)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(summary["steps"], 200)
        return summary["digest"]


def with_kit(kit, *arguments):
    """Command of a component in Python, with this kit."""
    return " ".join(["env", f"PYTHONPATH={kit}", "/usr/bin/python3", "-B", *map(str, arguments)])


class KitsOfThisMajorVersion(Kits):
    """A component with the kit of any release since 2.0 takes part in runs of this one."""

    def test_they_take_part_unchanged(self):
        releases = [path.name.removeprefix("kit_").removesuffix(".tar.gz") for path in RELEASED.glob("kit_*")]
        releases = sorted(release for release in releases if int(release.partition(".")[0]) >= 2)
        self.assertIn("2.0", releases)
        for release in releases:
            with self.subTest(release):
                kit = self.unpack(release)
                fluid = with_kit(kit, kit / "examples/stokes_drag_fluid.py")
                body = with_kit(kit, kit / "examples/point_masses.py")
                both, again = (self.digest(f"{release}_{n}", fluid=fluid, body=body) for n in (1, 2))
                self.assertEqual(both, again)
                self.assertEqual(len(self.digest(f"{release}_fluid", fluid=fluid)), 16)

    def test_every_release_has_one(self):
        changelog = (ROOT / "CHANGELOG.md").read_text()
        for release in re.findall(r"^## \[([1-9]\d*\.\d+)\.\d+\]", changelog, re.MULTILINE):
            self.assertTrue(archive_of(release).exists(), f"Keep it with older_kit_test.py --write {release} BUILD.")


class KitOf10(Kits):
    def test_is_refused_with_the_way_to_move(self):
        kit = self.unpack("1.0")
        fluid = kit / "examples/stokes_drag_fluid.py"
        done, _ = self.run_case("asked", fluid=with_kit(kit, fluid))  # for an estimate, before it is started
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn("docs/moving_to_a_newer_kit.md", done.stderr.splitlines()[-1])
        fluid.write_text(fluid.read_text().replace(", FEATURES), estimate))", ", FEATURES)))"))
        done, _ = self.run_case("refused", fluid=with_kit(kit, fluid))
        self.assertEqual(done.returncode, 65, done.stdout + done.stderr)
        reason = (
            r"The fluid component on \S+ was refused \(it supports protocol 1\.0 to 1\.0, the coupler 2\.0 to "
            r"2\.\d+\)\. Build it with the kit of this release: docs/moving_to_a_newer_kit\.md\."
        )
        self.assertRegex(done.stderr, reason)
        self.assertRegex((self.folder / "refused/logs/fluid.log").read_text(), reason)
        self.assertTrue(MOVING.exists())


class ComponentsOf10(Kits):
    """The examples of 1.0, changed as docs/moving_to_a_newer_kit.md has it, work with the kit of this release."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.kit = cls.folder / "kit"
        run(["cmake", "--install", BUILD, "--component", "kit", "--prefix", cls.kit])
        cls.sources = (cls.unpack("1.0") / "examples").rename(cls.folder / "components")  # away from their kit
        section = MOVING.read_text().split("\n## From 1.0 ")[1].split("\n## ")[0]
        for change in re.findall(r"```diff\n(.*?)```", section, re.DOTALL):
            run(["git", "apply", "--unidiff-zero", "-"], cwd=cls.sources, input=change)

    def changed(self, name):
        return with_kit(self.kit / "share/copepod/python", self.sources / name)

    def test_components_in_python_run(self):
        components = {"fluid": self.changed("stokes_drag_fluid.py"), "body": self.changed("point_masses.py")}
        self.assertEqual(self.digest("first", **components), self.digest("second", **components))

    def test_a_component_in_cpp_is_built_and_runs(self):
        run(["cmake", "-S", self.sources, "-B", self.folder / "build", f"-DCMAKE_PREFIX_PATH={self.kit}"])
        run(["cmake", "--build", self.folder / "build"])
        fluid = self.folder / "build/external_fluid"
        self.assertEqual(len(self.digest("cpp", fluid=fluid, body=self.changed("point_masses.py"))), 16)


def run(command, **options):
    """A command that must succeed."""
    ended = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=220, **options)
    if ended.returncode != 0:
        raise AssertionError(f"{command}: {ended.stdout}{ended.stderr}")


def write(release):
    """Keeps the Python kit and the examples of this build; the same files give the same bytes."""
    target = archive_of(release)
    if target.exists():
        sys.exit(f"{target} exists (what was released stays). Remove it if this release has not been made yet.")
    packed = io.BytesIO()
    with tempfile.TemporaryDirectory() as prefix, tarfile.open(fileobj=packed, mode="w") as archive:
        run(["cmake", "--install", BUILD, "--component", "kit", "--prefix", prefix])
        python = Path(prefix, "share/copepod/python")
        files = {path.relative_to(python): path for path in python.rglob("*") if path.suffix in (".py", ".json")}
        files |= {Path("examples", path.name): path for path in (ROOT / "examples/external_fluid").glob("[Cm]*")}
        for name in sorted(files):
            if name.parts[0] in ("copepod", "copepod_component", "examples"):
                entry = tarfile.TarInfo(f"kit_{release}/{name}")
                entry.size = files[name].stat().st_size
                archive.addfile(entry, io.BytesIO(files[name].read_bytes()))
    target.write_bytes(gzip.compress(packed.getvalue(), mtime=0))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--write"]:
        write(sys.argv[2])
    else:
        unittest.main()
