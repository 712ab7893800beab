"""The arrays of a reply as numpy arrays."""

import numpy as np

from copepod_conformance.fluid_case import POSITIONS_M
from copepod_conformance.verdicts import Violation


def rows(message, field, width=3):
    """A field of the reply, shape (bodies, width); raises Violation if it is not of that size."""
    numbers = np.array(getattr(message, field))
    if numbers.size != width * len(POSITIONS_M):
        raise Violation(
            f"{numbers.size} numbers in {message.DESCRIPTOR.name}.{field} "
            f"instead of {width} for each of {len(POSITIONS_M)} bodies"
        )
    return numbers.reshape(len(POSITIONS_M), width)
