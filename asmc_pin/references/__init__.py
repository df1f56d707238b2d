"""Trajectories to follow: position, velocity and acceleration in closed form, in rad, rad/s and rad/s².

Takes parameters, or a file, and times; gives set points. May import `arms`, `parameters`, and of the controllers what a
set point is.
"""

from __future__ import annotations

from asmc_pin.references.feasibility import check_reference, required_torque
from asmc_pin.references.reference import REFERENCES, OnAnArm, Reference, reference_words

# Every file with kinds, in the order of the tables. The import is what registers them.
# isort: off
from asmc_pin.references.moves import Quintic as Quintic, Ramps as Ramps
from asmc_pin.references.periodic import Multisine as Multisine, Fourier as Fourier
from asmc_pin.references.csv_path import CsvPath as CsvPath
from asmc_pin.references.cartesian import CartesianPath as CartesianPath, SolvedPath as SolvedPath
# isort: on

__all__ = [
    "REFERENCES",
    "OnAnArm",
    "Reference",
    "check_reference",
    "reference_words",
    "required_torque",
]
