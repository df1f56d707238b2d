"""Arms: a URDF in, mass matrix, Coriolis, gravity, limits and friction out. Pinocchio and yourdfpy live here."""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.arms.arm import Arm as Arm
    from asmc_pin.arms.kernels import mass_matrices as mass_matrices
    from asmc_pin.arms.load import load_arm as load_arm
    from asmc_pin.arms.payload import Payload as Payload
    from asmc_pin.arms.registry import ARMS as ARMS
    from asmc_pin.arms.registry import ArmEntry as ArmEntry
    from asmc_pin.arms.registry import arm_names as arm_names
    from asmc_pin.arms.table import arms_table as arms_table
    from asmc_pin.arms.tree import Tree as Tree

load_on_first_use(
    __name__,
    {
        "ARMS": "registry",
        "Arm": "arm",
        "ArmEntry": "registry",
        "Payload": "payload",
        "Tree": "tree",
        "arm_names": "registry",
        "arms_table": "table",
        "load_arm": "load",
        "mass_matrices": "kernels",
    },
)

__all__ = ["ARMS", "Arm", "ArmEntry", "Payload", "Tree", "arm_names", "arms_table", "load_arm", "mass_matrices"]
