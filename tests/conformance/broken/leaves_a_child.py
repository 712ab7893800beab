"""Broken: starts a process and forgets it."""

import subprocess
import sys

from foundation import BODY, Masses
from copepod_component import run_body_component


class MassesWithAChild(Masses):
    def __init__(self, setup, context):
        super().__init__(setup, context)
        subprocess.Popen(["sleep", "600"], start_new_session=True)


sys.exit(run_body_component(MassesWithAChild, BODY))
