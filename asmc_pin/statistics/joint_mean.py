"""One figure of several joints: their geometric mean, in which a joint that does not move cannot hide the others."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array


def joint_logs(figures: ArrayLike, least: float) -> Array:
    """Logarithms of what the figures of joints count as; see `joint_mean`, which is the exponential of their mean."""
    return np.log(np.maximum(np.asarray(figures, dtype=np.float64), least))


def joint_mean(figures: ArrayLike, least: float) -> Array:
    """Geometric mean over the last axis, of figures of `least` at least.

    It asks for no weights between joints, nor between rad and m: ten per cent less error counts the same on each of
    them. A joint that sticks where it is to stay has an error of exactly 0, and a geometric mean with a 0 in it is 0,
    whatever the others do; so what is too small to matter counts as `least`.

    Args:
        figures: Shape (…, nv), 0 or more; +∞ for a failure, NaN where undefined.
        least: What a smaller figure counts as, above 0; that of a metric is `asmc_pin.metrics.Metric.least`.

    Returns:
        Shape (…); +∞ where a figure is, NaN where one is undefined.
    """
    return np.asarray(np.exp(np.mean(joint_logs(figures, least), axis=-1)))
