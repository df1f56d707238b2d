"""From the bits on an encoder's data sheet to the angle of one count."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array


def encoder_count(bits: Array) -> Array:
    """Angle of one count of an encoder with 2^bits of them per turn, rad at the encoder's own shaft."""
    return np.asarray(2.0 * np.pi / 2.0**bits)


MOST_BITS = 64
"""More no register holds; encoders have up to 32."""
