"""What `copepod run` and `copepod check` refuse before anything starts."""

import os
import unittest

from copepod_session import FAKES, TinyRunTest


class Refusals(TinyRunTest):
    def test_bad_case_shows_every_error_and_leaves_nothing(self):
        session = self.start("run", self.case(errors=["radius is zero (…). Give one.", "unknown key «fluit» (…). …"]))
        self.assert_ends(session, 2)
        self.assertIn("case.yaml:1: error: radius", session.stderr[0])
        self.assertIn("case.yaml:2: error: unknown", session.stderr[1])
        self.assertFalse((self.folder / "runs").exists())

    def test_missing_replacement_is_found_before_anything_starts(self):
        session = self.start("run", self.case(), "--fluid", "no_such_solver --fast")
        self.assert_ends(session, 2)
        self.assertIn("no_such_solver", session.last_line)
        self.assertFalse((self.folder / "runs").exists())

    def test_empty_command_and_no_number_are_refused_on_the_command_line(self):
        for arguments, words in (
            (("--fluid", ""), "--fluid: the command is empty (a variable that is not set?). Name a program."),
            (("--body", " "), "--body: the command is empty"),
            (("--ranks", "abc"), "--ranks: «abc» is not a valid rank count (integer ≥ 1)"),
            (("--restarts", "-1"), "--restarts: «-1» is not a valid number (integer ≥ 0)"),
        ):
            session = self.start("run", self.case(), *arguments)
            self.assert_ends(session, 2)
            self.assertIn(words, session.last_line)
        self.assertFalse((self.folder / "runs").exists())

    def test_component_of_the_other_role_is_refused_before_the_run(self):
        session = self.start("run", self.case(), "--body", f"{FAKES}/fluid_service")
        self.assert_ends(session, 2)
        self.assertIn("cannot be used as body component (it is a fluid component). Use --fluid.", session.last_line)
        self.assertFalse((self.folder / "runs").exists())

    def test_component_estimates_its_memory_before_the_run(self):
        answer = '{"memory_bytes": 1048576000, "problem": "the table of its radii is coarse"}'
        component = self.estimating_component(f"cat > asked; echo '{answer}'")
        session = self.start("check", self.case(), "--body", component)
        self.assert_ends(session, 0)
        self.assertIn("memory           1000 MiB (body 1000)", "".join(session.stdout))
        self.assertIn("warning: body: the table of its radii is coarse", "".join(session.stdout))
        self.assertEqual((self.folder / "asked").read_text(), "setup of body\n")

    def test_component_refuses_a_setup_before_the_run(self):
        refusal = "7 ranks cannot divide 24 cells (a rank needs at least 4 layers). Use 6."
        component = self.estimating_component(f"echo 'error: {refusal}' >&2; exit 2")
        for command in ("check", "run"):
            session = self.start(command, self.case(), "--body", component)
            self.assert_ends(session, 2)
            self.assertIn(refusal, "".join([*session.stdout, *session.stderr]))
        self.assertFalse((self.folder / "runs").exists())

    def estimating_component(self, commands):
        """A body component that answers --capabilities, and --estimate with `commands` of bash."""
        announced = '{"name": "own", "role": "body", "features": ["estimate"]}'
        script = self.folder / "estimates.sh"
        script.write_text(f"#!/bin/bash\n[ $1 = --capabilities ] && echo '{announced}' && exit\n{commands}\n")
        script.chmod(0o755)
        return script

    def test_options_that_a_sweep_does_not_have_are_refused_by_name(self):
        sweep = {"parameters": [{"key": "a.b", "scale": "linear"}], "members": [{"values": [1], "set": []}]}
        for words in (("--resume",), ("--restarts", "2")):
            session = self.start("run", self.case(sweep=sweep), *words)
            self.assert_ends(session, 2)
            self.assertIn(f"{words[0]} is not for sweeps", session.last_line)

    def test_run_directory_whose_name_is_no_text_is_refused_before_it_is_made(self):
        out = os.fsdecode(os.fsencode(self.folder) + b"/m\xfcnchen")
        session = self.start("run", self.case(steps=2), "--out", out)
        self.assert_ends(session, 2)
        self.assertIn("m\\xfcnchen cannot be the folder of a run (its name is not UTF-8 text)", session.last_line)
        self.assertFalse(os.path.exists(out))

    def test_check_refuses_what_a_component_cannot_do(self):
        session = self.start("check", self.case(requires=["collision:bgk", "collision:cumulant"]))
        self.assertEqual(session.end(), 2)
        self.assertIn("collision:cumulant", "".join(session.stdout))
        self.assertNotIn("«collision:bgk»", "".join(session.stdout))

    def test_check_refuses_what_is_no_component_of_the_role(self):
        for arguments, words in (
            (
                ("--fluid", "/bin/true"),
                "error: /bin/true cannot be used as fluid component (it does not answer --capabilities",
            ),
            (
                ("--body", f"{FAKES}/fluid_service"),
                "error: fake fluid cannot be used as body component (it is a fluid component). Use --fluid.",
            ),
        ):
            session = self.start("check", self.case(), *arguments)
            self.assertEqual(session.end(), 2)
            self.assertIn(words, "".join(session.stdout))
            self.assertNotIn("ok\n", session.stdout)

    def test_check_starts_no_command_of_the_case_unless_the_user_trusts_it(self):
        script = self.component("exit 1")
        script.write_text(f"#!/bin/bash\ntouch {self.folder}/started\nexec {FAKES}/body_service --capabilities\n")
        for role, ranks in (("body", 1), ("fluid", 3)):
            case = self.case(**{role: str(script)}, ranks=ranks)
            session = self.start("check", case)
            self.assert_ends(session, 0)
            self.assertFalse((self.folder / "started").exists())
            said = "".join(session.stdout)
            self.assertIn(f"warning: the {role} component was not asked what it can do", said)
            self.assertIn(f"a command of the case: {script}). Use --start-components if you trust the case.", said)
        self.assert_ends(self.start("check", self.case(body=str(script)), "--start-components"), 0)
        self.assertTrue((self.folder / "started").exists())

    def test_resume_of_nothing_is_an_error(self):
        session = self.start("run", self.case(), "--resume")
        self.assert_ends(session, 2)
        self.assertIn("does not hold a run", session.last_line)


if __name__ == "__main__":
    unittest.main()
