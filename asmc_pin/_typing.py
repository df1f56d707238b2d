"""Array aliases used throughout the package."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

Number = TypeVar("Number", float, Array)
"""One number, or an array of them: of a formula that is both compiled for a joint and computed in numpy."""
