"""Debian packages and the image made of them, in a root where neither the checkout nor a compiler is."""

import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import container_image

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("COPEPOD_BUILT_PROGRAMS", ROOT / "build/bin")).parent
NAMES = ("copepod", "libcopepod-dev", "python3-copepod")
CONFIGS = "/usr/share/copepod/configs"
QUICK = f"{CONFIGS}/quick/three_sphere.yaml"
SHOWN = re.search(r"^  digest +(\w+)$", (ROOT / "README.md").read_text(), re.MULTILINE)[1]  # of that case
STEPPED = f"""
import copepod
with copepod.Simulation({QUICK!r}, ranks=2) as simulation:
    simulation.step(10)
    assert simulation.bodies.position_m.shape == (3, 3)
run = copepod.run("{CONFIGS}/quick/vacuum.yaml", out="vacuum", set={{"run.steps": 800}}, quiet=True)
assert len(run.trajectory), run.status
"""
REFUSED = {"test": "test needs the source", "setup": "setup needs", "validate": "validate without --out needs"}


def can_make_roots():
    """Whether this process may mount and there is a mirror's tool; a container of CI may lack the right."""
    mounts = subprocess.run(["unshare", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True)
    return os.geteuid() == 0 and bool(shutil.which("mmdebstrap")) and mounts.returncode == 0


def package(name):
    (file,) = (BUILD / "packages").glob(f"{name}_*.deb")
    return file


def setUpModule():
    shutil.rmtree(BUILD / "packages", ignore_errors=True)
    subprocess.run(["cmake", "--build", BUILD, "--target", "packages"], check=True, stdout=subprocess.DEVNULL)


class Packages(unittest.TestCase):
    def setUp(self):
        self.files = [package(name) for name in NAMES]

    def test_lintian_finds_no_error(self):
        done = subprocess.run(["lintian", "--fail-on", "error", *self.files], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_checkout_beside_them_is_no_package(self):
        with tempfile.TemporaryDirectory() as usr:
            modules = Path(usr, "src/copepod/deploy")
            (modules / "copepod_run").mkdir(parents=True)
            Path(usr, "libexec/copepod").mkdir(parents=True)
            (modules / "copepod").touch()
            shutil.copy(ROOT / "deploy/copepod_run/checkout.py", modules / "copepod_run")
            asked = "from copepod_run.checkout import PREFIX, COMMAND; print(PREFIX, COMMAND)"
            done = subprocess.run(
                ["/usr/bin/python3", "-c", asked], env={"PYTHONPATH": str(modules)}, capture_output=True, text=True
            )
            self.assertEqual(done.stdout, f"None {modules}/copepod\n", done.stderr)

    def test_nothing_names_the_checkout(self):
        for file in self.files:
            with tempfile.TemporaryDirectory() as folder:
                subprocess.run(["dpkg-deb", "-x", file, folder], check=True)
                done = subprocess.run(["grep", "-rlF", f"{ROOT}", folder], capture_output=True, text=True)
                self.assertEqual(done.stdout, "")


@unittest.skipUnless(can_make_roots(), "needs root, mmdebstrap and the right to mount")
class InstalledInACleanRoot(unittest.TestCase):
    """Steps of one story, since a root takes a minute to make; the user is the image's, /dev/shm has 64 MB."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="copepod-image-")
        cls.addClassCleanup(folder.cleanup)
        file = ROOT / "deploy/container/Containerfile"
        try:
            cls.image = container_image.build(file, ROOT, Path(folder.name), built=BUILD)
        except container_image.NoDebian as reason:
            raise unittest.SkipTest(f"no Debian can be fetched: {reason}") from None

    def ends(self, *command, code=0, start=None, **options):
        """The output of a command of the image, or of `start` in its root."""
        start = start or self.image
        done = start(*command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
        self.assertEqual(done.returncode, code, done.stdout)
        return done.stdout

    def test_1_a_user_without_rights_runs_the_case_of_the_readme(self):
        self.assertIn(SHOWN, self.ends("run", QUICK, "--out", "ipc"))
        settings = ("services.transport=in_process", "run.steps=100", "output.fields=null")
        self.ends("run", QUICK, "--out", "in_process", *(word for setting in settings for word in ("--set", setting)))
        self.assertIn(
            "MLUPS of the last", self.ends("check", QUICK)
        )  # what a run has shown is kept in the user's cache
        self.ends("report", "ipc")
        self.assertIn("finished", (self.image.root / "work/ipc/report/report.html").read_text())

    def test_2_python_finds_the_package(self):
        self.ends("/usr/bin/python3", "-c", STEPPED, start=self.image.run)

    def test_3_components_are_checked(self):
        component = "/usr/share/copepod/examples/python/point_masses.py"
        self.ends(
            "conformance", "--role", "body", "--only", "handshake", "--quick", "--", "/usr/bin/python3", component
        )

    def test_4_manual_and_completion(self):
        pages = {page.name for page in (self.image.root / "usr/share/man/man1").glob("copepod*")}
        self.assertLessEqual({"copepod.1.gz", "copepod-run.1.gz", "copepod-campaign.1.gz"}, pages)
        shown = subprocess.run(
            ["man", "-l", self.image.root / "usr/share/man/man1/copepod.1.gz"],
            capture_output=True,
            text=True,
            check=True,
        )
        self.assertIn("couples fluids and rigid bodies", shown.stdout)
        script = 'source /usr/share/bash-completion/completions/copepod && COMP_WORDS=(copepod rep) COMP_CWORD=1 \
COMP_LINE="copepod rep" COMP_POINT=11 && _python_argcomplete copepod && echo "${COMPREPLY[@]}"'
        self.assertIn("report", self.ends("/bin/bash", "-c", script, start=self.image.run).split())

    def test_5_what_belongs_to_a_checkout_is_refused_by_name(self):
        for command, reason in REFUSED.items():
            self.assertIn(reason, self.ends(command, code=2))

    def test_6_no_compiler_is_there(self):
        self.ends("/bin/sh", "-c", "! ls /usr/bin | grep -E '^(cc|gcc|c[+][+]|g[+][+]|clang)'", start=self.image.run)

    def test_7_a_component_and_a_program_are_built_from_the_development_package(self):
        """The last of the story: it brings a compiler."""
        place = self.image.root / "home/copepod"
        shutil.copy(package("libcopepod-dev"), place / "kit.deb")
        for example in ("external_fluid", "c"):
            shutil.copytree(ROOT / "examples" / example, place / example)
        wanted = "g++ cmake make pkg-config /home/copepod/kit.deb"
        script = (
            f"apt-get update && apt-get install -y --no-install-recommends {wanted} && chown -R copepod /home/copepod"
        )
        self.ends("/bin/sh", "-c", script, start=self.image.run, user="root")
        script = "cd && cmake -S external_fluid -B built && cmake --build built && built/external_fluid --capabilities"
        self.assertIn('"role":"fluid"', self.ends("/bin/sh", "-c", script, start=self.image.run))
        script = "cd && cc c/steer.c -o steer $(pkg-config --cflags --libs copepod) && ./steer"
        script += f" {CONFIGS}/examples/prescribed_stroke.yaml"
        self.ends("/bin/sh", "-c", script, start=self.image.run)


if __name__ == "__main__":
    unittest.main()
