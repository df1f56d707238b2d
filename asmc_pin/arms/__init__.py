"""Arms: a URDF in, mass matrix, Coriolis, gravity, limits and friction out. Pinocchio and yourdfpy live here."""

from asmc_pin.arms.arm import Arm
from asmc_pin.arms.kernels import mass_matrices
from asmc_pin.arms.load import load_arm
from asmc_pin.arms.payload import Payload
from asmc_pin.arms.registry import ARMS, ArmEntry, arm_names
from asmc_pin.arms.table import arms_table
from asmc_pin.arms.tree import Tree

__all__ = ["ARMS", "Arm", "ArmEntry", "Payload", "Tree", "arm_names", "arms_table", "load_arm", "mass_matrices"]
