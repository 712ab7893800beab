"""Setting up a machine: packages and the build, with stand-ins for dpkg-query, apt-get, cmake and ninja."""

import fcntl
import os
import re
import shutil
import subprocess
import unittest

from copepod_session import ROOT, CommandTest

DPKG_QUERY = """#!/bin/sh
for package in "$@"; do case $package in -*) ;; *) [ -e "$STATE/$package" ] && echo "$package installed" ;; esac; done
exit 0
"""
APT_GET = """#!/bin/sh
echo "apt-get $*" >> "$STATE/calls"
[ -e "$STATE/broken" ] && exit 100
for word in "$@"; do case $word in -*|install|update|DPkg*) ;; *) : > "$STATE/$word" ;; esac; done
"""
CMAKE = """#!/bin/sh
echo "cmake $*" >> "$STATE/calls"
mkdir -p build && echo "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" > build/CMakeCache.txt && : > build/build.ninja
"""
NINJA = """#!/bin/sh
if [ "$1" = -n ]; then
    for name in coupler in_process_run; do [ -e build/bin/$name ] || exit 0; done
    [ -z "$(find coupler -newer build/bin/coupler 2>/dev/null)" ] && echo "ninja: no work to do."
    exit 0
fi
echo "ninja $*" >> "$STATE/calls"
if [ -e "$STATE/compile_error" ]; then
    echo "[0/2] compiling a.cpp"; echo "FAILED: a.o"; echo "a.cpp:1: error: this is wrong"; exit 1
fi
echo "[1/2] compiling a.cpp"
sleep 1.3
while [ -e "$STATE/slow" ]; do sleep 0.05; done
mkdir -p build/bin && cd build/bin && echo '#!/bin/sh' > coupler && echo 'exit 2' >> coupler && chmod +x coupler
touch fluid_service body_service in_process_run
echo "[2/2] linking coupler"
"""


class Preparation(CommandTest):
    """`copepod run` in a checkout that holds the command only."""

    def setUp(self):
        super().setUp()
        self.state = self.folder / "state"
        self.tools = self.folder / "tools"
        self.checkout = self.folder / "checkout"
        for folder in (self.state, self.tools, self.checkout):
            folder.mkdir()
        shutil.copytree(ROOT / "deploy", self.checkout / "deploy", ignore=shutil.ignore_patterns("__pycache__"))
        for name, text in (("dpkg-query", DPKG_QUERY), ("apt-get", APT_GET), ("cmake", CMAKE), ("ninja", NINJA)):
            (self.tools / name).write_text(text)
            (self.tools / name).chmod(0o755)

    def start_command(self, user=None):
        """`copepod run` of a case that the stand-in coupler refuses, so that only the preparation happens."""
        return subprocess.Popen(
            [self.checkout / "deploy/copepod", "run", "case.yaml"],
            cwd=self.checkout,
            env={"PATH": f"{self.tools}:/usr/bin:/bin", "STATE": str(self.state)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            user=user,
        )

    def run_command(self, user=None):
        process = self.start_command(user)
        stdout, stderr = process.communicate()
        return subprocess.CompletedProcess(process.args, process.returncode, stdout, stderr)

    def calls(self):
        path = self.state / "calls"
        return path.read_text() if path.exists() else ""

    def install_everything(self):
        from copepod_run.packages import BUILD_AND_RUN

        for package in BUILD_AND_RUN:
            (self.state / package).touch()

    @unittest.skipIf(os.geteuid() != 0, "installs as root")
    def test_root_installs_what_is_missing_and_builds(self):
        self.install_everything()
        (self.state / "libzmq3-dev").unlink()
        answer = self.run_command()
        self.assertEqual(answer.returncode, 2, answer.stderr)  # the stand-in coupler's
        self.assertRegex(self.calls(), r"install -y --no-install-recommends libzmq3-dev\n")
        self.assertIn("copepod: installing 1 Debian packages", answer.stderr)
        self.assertIn("copepod: configuring … ", answer.stderr)
        self.assertRegex(answer.stderr, r"copepod: building \(log: .*build.log\) … \d+ s")

    def test_programs_that_a_case_does_not_need_are_left_for_later(self):
        self.install_everything()
        case = self.checkout / "case.yaml"
        for text, target in (
            ("case: plain", "copepod_services"),
            ("body: {solver: bullet}", "copepod_programs"),
            ("services: {transport: in_process}", "copepod_programs"),
            ("campaign: many", "copepod_programs"),
        ):
            case.write_text(text)
            shutil.rmtree(self.checkout / "build", ignore_errors=True)
            (self.state / "calls").unlink(missing_ok=True)
            self.run_command()
            self.assertRegex(self.calls(), rf"ninja .* {target} copepod_python\n", text)

    def test_second_time_is_quiet(self):
        self.install_everything()
        self.run_command()
        answer = self.run_command()
        self.assertEqual(answer.stderr, "")

    def test_up_to_date_programs_need_no_lock(self):
        self.install_everything()
        self.run_command()
        calls = self.calls()
        lock = os.open(self.checkout / "build/builder", os.O_RDONLY)
        self.addCleanup(os.close, lock)
        fcntl.flock(lock, fcntl.LOCK_EX)
        answer = self.run_command()
        self.assertEqual((answer.returncode, answer.stderr), (2, ""))
        self.assertEqual(self.calls(), calls)

    def test_changed_sources_are_built(self):
        self.install_everything()
        self.run_command()
        (self.checkout / "coupler").mkdir()
        for change in ("new", "changed"):
            calls = self.calls().count("ninja")
            (self.checkout / "coupler/main.cpp").write_text(change)
            self.run_command()
            self.assertEqual(self.calls().count("ninja"), calls + 1, change)
        (self.checkout / "build/bin/coupler").unlink()
        self.run_command()
        self.assertTrue((self.checkout / "build/bin/coupler").exists())

    def test_the_build_that_a_command_waits_for_is_named(self):
        self.install_everything()
        (self.state / "slow").touch()
        builder = self.start_command()
        self.read_until(builder, "building")
        waiting = self.start_command()
        said = self.read_until(waiting, "build.log")
        self.assertIn(
            "waiting for the build of another command: copepod run case.yaml "
            f"(process {builder.pid}, started {re.search('started (.*) ago', said)[1]} ago)",
            said,
        )
        (self.state / "slow").unlink()
        for process in (builder, waiting):
            self.assertEqual(process.communicate()[1].count("failed"), 0)
            self.assertEqual(process.returncode, 2)
        self.assertEqual(self.calls().count("ninja"), 2)

    def read_until(self, process, text):
        """What the command writes on stderr up to `text`; the line need not be complete."""
        said = ""
        while text not in said:
            received = os.read(process.stderr.fileno(), 4096).decode()
            self.assertTrue(received, f"«{text}» never came: {said}")
            said += received
        return said

    @unittest.skipIf(os.geteuid() != 0, "changes to another user")
    def test_without_root_the_exact_command_is_printed(self):
        self.install_everything()
        (self.state / "libzmq3-dev").unlink()
        (self.state / "ninja-build").unlink()
        self.folder.chmod(0o755)
        self.checkout.chmod(0o777)
        answer = self.run_command(user="nobody")
        self.assertEqual(answer.returncode, 2)
        self.assertEqual(
            answer.stderr.splitlines()[-1],
            "copepod: 2 Debian packages are missing (only root can install "
            "them). Run: sudo apt-get install -y ninja-build libzmq3-dev",
        )
        self.assertEqual(self.calls(), "")

    @unittest.skipIf(os.geteuid() != 0, "installs as root")
    def test_failing_installation_says_where_to_look(self):
        (self.state / "broken").touch()
        answer = self.run_command()
        self.assertEqual(answer.returncode, 2)
        self.assertIn("packages.log", answer.stderr.splitlines()[-1])

    @unittest.skipIf(os.geteuid() != 0, "changes to another user")
    def test_other_users_use_the_owners_build(self):
        self.install_everything()
        self.folder.chmod(0o755)
        answer = self.run_command(user="nobody")
        self.assertEqual(answer.returncode, 2)
        self.assertIn("belongs to another user", answer.stderr)
        self.run_command()
        for name in ("fluid_service", "body_service", "in_process_run"):
            (self.checkout / "build/bin" / name).touch()
        calls = self.calls()
        answer = self.run_command(user="nobody")
        self.assertEqual((answer.returncode, answer.stderr), (2, ""))  # the stand-in coupler's
        self.assertEqual(self.calls(), calls)

    def test_failing_build_shows_the_compilers_words(self):
        self.install_everything()
        (self.state / "compile_error").touch()
        answer = self.run_command()
        self.assertEqual(answer.returncode, 1)
        self.assertIn("a.cpp:1: error: this is wrong", answer.stderr)
        self.assertIn("build.log", answer.stderr.splitlines()[-1])
        self.assertIn("a.cpp:1: error", (self.checkout / "build/build.log").read_text())

    def test_moved_checkout_is_configured_anew(self):
        self.install_everything()
        self.run_command()
        self.checkout = self.checkout.rename(self.folder / "elsewhere")
        self.run_command()
        self.assertEqual(self.calls().count("cmake --fresh --preset release"), 2)


if __name__ == "__main__":
    unittest.main()
