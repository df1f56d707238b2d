"""Trajectories to follow: position, velocity and acceleration in closed form, in rad, rad/s and rad/s²."""

from __future__ import annotations

from asmc_pin.references.cartesian import CartesianPath, SolvedPath
from asmc_pin.references.csv_path import CsvPath
from asmc_pin.references.feasibility import check_reference, required_torque
from asmc_pin.references.moves import Quintic, Ramps
from asmc_pin.references.periodic import Fourier, Multisine
from asmc_pin.references.reference import Reference

__all__ = [
    "REFERENCES",
    "CartesianPath",
    "CsvPath",
    "Fourier",
    "Multisine",
    "Quintic",
    "Ramps",
    "Reference",
    "SolvedPath",
    "check_reference",
    "required_torque",
]

REFERENCES: dict[str, type[Quintic | Multisine | Ramps | Fourier | CsvPath | CartesianPath]] = {
    "quintic": Quintic,
    "multisine": Multisine,
    "ramps": Ramps,
    "fourier": Fourier,
    "csv": CsvPath,
    "cartesian": CartesianPath,
}
"""The kinds of reference by the names that experiments use."""
