"""Broken: announces a feature that does not exist, because of a typing error."""

import sys

from foundation import BODY, Masses
from copepod_component import Capabilities, run_body_component

sys.exit(run_body_component(Masses, Capabilities(BODY.name, BODY.version, [*BODY.features, "springz"])))
