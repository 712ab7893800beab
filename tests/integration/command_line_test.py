"""What people expect of a command: its version, quiet, JSON, completion, manual pages, estimates."""

import contextlib
import importlib
import io
import json
import os
import subprocess
import tomllib
import unittest

from copepod_session import COMMAND, ROOT, TinyRunTest  # sets the path of our modules

from copepod_command.main import _KIT_TOOLS, parse
from copepod_command.parser import _COMMANDS


class Arguments(unittest.TestCase):
    """What is read from arguments, and what is refused."""

    def test_values_and_defaults(self):
        for words, expected in (
            ("run c.yaml --hosts a,b:2 --set x=1", {"set": ['services.hosts=["a", "b:2"]', "x=1"], "ranks": None}),
            ("run c.yaml --restarts 0 -q", {"restarts": 0, "quiet": True, "progress": "auto", "branch_from": None}),
            ("check c.yaml --ranks 2 --body b", {"ranks": 2, "body": "b", "start_components": False, "set": []}),
            ("report a b --at 2e-6 --plane xz", {"directories": ["a", "b"], "at": 2e-6, "plane": "xz", "time": "auto"}),
            ("report a --format pdf svg --time 12", {"format": ["pdf", "svg"], "time": "12", "zoom": "", "x": ""}),
            ("watch r", {"port": 0, "directory": "r"}),
            ("validate --cases wall", {"cases": ["wall"], "json": False, "jobs": None}),
            ("replay r --as fluid -- b", {"stand_in": "fluid", "tolerance": 0.0, "ranks": 1, "component": ["b"]}),
            ("man", {"page": None, "action": "copepod_command.documentation:manual"}),
        ):
            options = vars(parse(words.split()))
            self.assertEqual(options, options | expected, words)

    def test_refusals(self):
        for words, reason in (
            ("run c.yaml --resume --branch-from d", "argument --branch-from: not allowed with argument --resume"),
            ("replay r", "one of the arguments --fluid --body --controller --as is required"),
            ("export r --author a", "the following arguments are required: --license"),
            ("run c.yaml --progress text", "invalid choice: 'text' (choose from 'auto', 'json')"),
            ("run c.yaml --fluid=", "--fluid: the command is empty"),
            ("campaign c.yaml --jobs 0", "--jobs: «0» is not a valid number (integer ≥ 1)"),
            ("watch r --port -1", "--port: «-1» is not a valid port (integer ≥ 0)"),
            ("report r --at -1", "--at: «-1» is not a valid length (metres ≥ 0)"),
            ("report r --time noon", "«noon» is not a time of the flow"),
            ("replay r --body --tolerance inf", "«inf» is not a valid relative difference"),
        ):
            stderr = io.StringIO()
            with contextlib.redirect_stderr(stderr), self.assertRaisesRegex(SystemExit, "^2$"):
                parse(words.split())
            self.assertIn(reason, stderr.getvalue())

    def test_help_has_titles_and_what_they_are_about(self):
        stdout = io.StringIO()
        with contextlib.redirect_stdout(stdout), self.assertRaisesRegex(SystemExit, "^0$"):
            parse(["report", "--help"])
        self.assertIn("\npicture of the flow:\n  of runs that recorded one (output.fields)\n", stdout.getvalue())
        self.assertIn("[--out FOLDER]", stdout.getvalue())

    def test_everything_in_the_table_of_commands_is_there_and_used(self):
        table = tomllib.loads(_COMMANDS.read_text())
        shared = table.pop("shared")
        given = [(words, value) for command in table.values() for words, value in command.get("options", {}).items()]
        self.assertEqual({words for words, value in given if value is True}, set(shared))
        for name, command in table.items():
            if name not in _KIT_TOOLS:
                module, _, function = command["action"].partition(":")
                self.assertTrue(callable(getattr(importlib.import_module(module), function)), name)


class CommandLine(TinyRunTest):
    def ended(self, *arguments, code=0, environment=()):
        session = self.start(*arguments, environment=environment)
        self.assert_ends(session, code)
        return "".join(session.stdout), "".join(session.stderr)

    def test_the_version_is_that_of_the_build(self):
        stdout, _ = self.ended("--version")
        cmake = (ROOT / "CMakeLists.txt").read_text()
        self.assertIn(f"project(copepod VERSION {stdout.split()[1]} ", cmake)

    def test_a_quiet_run_writes_its_result_and_nothing_else(self):
        stdout, stderr = self.ended("run", self.case(steps=5), "-q", "--out", "run")
        self.assertEqual(stderr, "")
        self.assertIn("tiny", stdout)

    def test_a_quiet_command_says_why_it_fails(self):
        self.case(steps=5)
        (self.folder / "run").mkdir()
        (self.folder / "run" / "file").touch()
        _, stderr = self.ended("run", "case.yaml", "-q", "--out", "run", code=2)
        self.assertIn("run exists already", stderr)

    def test_results_come_as_json_on_stdout(self):
        stdout, _ = self.ended("run", self.case(steps=5), "--json", "--out", "run")
        summary = json.loads(stdout)
        self.assertEqual((summary["directory"], summary["status"]), ("run", "finished"))
        stdout, _ = self.ended("check", "case.yaml", "--json")
        checked = json.loads(stdout)
        self.assertEqual((checked["name"], checked["problems"]), ("tiny", []))
        (self.folder / "one.json").write_text((self.folder / "case.yaml").read_text())
        (self.folder / "two.json").write_text(json.dumps({"name": "two", "cases": ["one"]}))
        stdout, _ = self.ended("campaign", "two.json", "--json")
        self.assertEqual([case["state"] for case in json.loads(stdout)["cases"]], ["done"])

    def test_check_warns_of_a_disk_that_is_too_small(self):
        stdout, _ = self.ended("check", self.case(steps=5, field_bytes=10**18), "--json")
        checked = json.loads(stdout)
        self.assertEqual(checked["disk_bytes"]["fields"], 10**18)
        self.assertIn("the run writes about 1e+06 TB", checked["warnings"][0])
        _, stderr = self.ended("run", "case.yaml", "--out", "run")
        self.assertIn("the run writes about 1e+06 TB", stderr)
        stdout, _ = self.ended("check", self.case(steps=5), "--json")
        self.assertEqual(json.loads(stdout)["warnings"], [])

    def completed(self, shell_line):
        """What bash offers for a line that is being typed."""
        script = (
            f'source <("{COMMAND}" completion bash)\n'
            f'COMP_LINE="{shell_line}" COMP_POINT={len(shell_line)} COMP_TYPE=9 COMP_KEY=9\n'
            f'_python_argcomplete "{COMMAND}"\nprintf "%s\\n" "${{COMPREPLY[@]}}"'
        )
        answer = subprocess.run(["bash", "-c", script], stdout=subprocess.PIPE, text=True, check=True, timeout=60)
        return [word.strip() for word in answer.stdout.split("\n") if word.strip()]

    def test_bash_completes_commands_and_options(self):
        self.assertEqual(self.completed("copepod ca"), ["campaign"])
        self.assertEqual(set(self.completed("copepod run --res")), {"--restarts", "--resume"})
        self.assertEqual(self.completed("copepod run --progress "), ["auto", "json"])
        self.assertEqual(self.completed("copepod man ru"), ["run"])
        self.assertEqual(self.completed("copepod recording tr"), ["trace"])
        self.assertEqual(self.completed("copepod conformance --ro"), ["--role"])
        for typed, offered in (
            ("bodies.0.ra", "bodies.0.radius_m="),
            ("fluid.so", "fluid.solver="),
            ("bod", "bodies."),
        ):
            self.assertIn(offered, self.completed(f"copepod run --set {typed}"))

    def test_other_shells_have_a_script(self):
        self.assertIn("bashcompinit", self.ended("completion", "zsh")[0])
        self.assertIn("complete", self.ended("completion", "fish")[0])

    def test_every_command_has_a_manual_page_with_its_options_and_examples(self):
        self.ended("man", "--out", "pages")
        pages = {path.name: path.read_text() for path in (self.folder / "pages").iterdir()}
        help_text, _ = self.ended("--help")
        commands = [line.split()[0] for line in help_text.splitlines() if line.startswith("    ") and line[4] != " "]
        self.assertIn("run", commands)
        self.assertEqual(set(pages), {"copepod.1", *(f"copepod-{command}.1" for command in commands)})
        self.assertIn("\\-\\-resume", pages["copepod-run.1"])
        self.assertIn("copepod run configs/quick/three_sphere.yaml", pages["copepod-run.1"])
        self.assertIn("\ncopepod-run \\- ", pages["copepod-run.1"])
        shown, _ = self.ended("man", "run", environment=[("MANPAGER", "cat"), ("PATH", os.environ["PATH"])])
        self.assertIn("--resume", shown.replace("\u2010", "-"))
        for environment in (
            [("LC_ALL", "C.UTF-8")],
            [("LC_ALL", "xx_YY.UTF-8")],  # of a terminal elsewhere, not installed here
            [("LC_ALL", "xx_YY.UTF-8"), ("PYTHONIOENCODING", "UTF-8:replace")],  # started by another Copepod
        ):
            shown, _ = self.ended("man", "run", environment=[("MANPAGER", "cat"), *environment])
            self.assertIn("A,B:N,…", shown)
        self.assertRegex(self.ended("run", "--help")[0], r"^Usage: \S*copepod run ")
        _, stderr = self.ended("man", "walk", code=2)
        self.assertIn("there is no command «walk»", stderr)


if __name__ == "__main__":
    unittest.main()
