"""Arms: a URDF in, mass matrix, Coriolis, gravity, limits and friction out. Pinocchio and yourdfpy live here.

Takes a URDF, xacro file, MJCF file or name with what is changed about it; gives an `Arm`. May import `rigid_body` and
what is open to all.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.arms.arm import Arm as Arm
    from asmc_pin.arms.listing import arms_table as arms_table
    from asmc_pin.arms.loading import load_arm as load_arm
    from asmc_pin.arms.payload import Payload as Payload
    from asmc_pin.arms.registry import ARMS as ARMS
    from asmc_pin.arms.registry import ArmEntry as ArmEntry
    from asmc_pin.arms.registry import arm_names as arm_names

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
