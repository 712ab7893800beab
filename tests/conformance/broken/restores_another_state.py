"""Broken: a restored run continues with the positions of the checkpoint and the velocities of the setup."""

import sys

from foundation import BODY, Masses
from copepod_component import run_body_component


class ForgetfulMasses(Masses):
    def restore(self, path):
        velocity_m_per_s = self.state.velocity_m_per_s
        super().restore(path)
        self.state.velocity_m_per_s = velocity_m_per_s


sys.exit(run_body_component(ForgetfulMasses, BODY))
