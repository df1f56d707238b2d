"""An arm: its dynamics as equation (1) of Baek (2016) without friction, and what its URDF declares."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array, BoolArray
from asmc_pin.arms.arm_dynamics import ArmDynamics
from asmc_pin.arms.arm_options import UNCHANGED, Armature, ChainEnds, Gravity, Load, Lock, Unchanged, Variant
from asmc_pin.arms.payload import Payload
from asmc_pin.arms.registry import ArmEntry
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.arms.urdf.urdf_reading import Mimic, Robot
from asmc_pin.errors import ArmError
from asmc_pin.rigid_body.tree import Tree
from asmc_pin.words.provisos import Proviso
from asmc_pin.words.shown import Cells, Shown
from asmc_pin.words.text import printable, quoted


class MadeOf(Protocol):
    """What an arm is made of, and how it is made again."""

    @property
    def robot(self) -> Robot:
        """The checked URDF."""

    @property
    def entry(self) -> ArmEntry | None:
        """The registry's entry, where the arm was asked for by name."""

    @property
    def variant(self) -> Variant:
        """The options."""

    def assemble(self) -> Arm:
        """The arm."""

    def vary(self, arm: Arm, changes: Mapping[str, Any]) -> Arm:
        """The arm with some options replaced, see `Arm.replace`."""


@dataclass(frozen=True, eq=False, repr=False)
class Arm(ArmDynamics, Shown):
    """A robot arm on a fixed base; immutable, arrays read-only. Make one with `load_arm`.

    M(q) q̈ + C(q, q̇) q̇ + g(q) = τ − f(q̇): this class gives M, C and g (`ArmDynamics`); friction and damping are
    reported, the plant applies them. Every joint has one coordinate: rad, rad/s, N·m, kg·m² where it turns, m, m/s, N,
    kg where it slides.

    Attributes:
        name: The name it is known by, or the file's stem.
        joint_names: Driven joints, base first; those that are locked or mimic others are not among them.
        joint_kinds: ``"revolute"`` or ``"prismatic"``, per joint.
        continuous: Whether a joint turns without end, shape (nv,).
        lower: Lower limits, shape (nv,), −inf where undeclared.
        upper: Upper limits, shape (nv,), +inf where undeclared.
        effort_limit: Torque limits, shape (nv,), inf where undeclared.
        velocity_limit: Velocity limits, shape (nv,), inf where undeclared.
        friction: Coulomb friction as the URDF declares it, with that of mimicking joints, shape (nv,), N·m.
        damping: Viscous friction, the same, shape (nv,), N·m·s/rad.
        armature: Reflected rotor inertia, part of M(q), that of mimicking joints included, shape (nv,).
        gravity_vector: Acceleration of gravity in the base frame, shape (3,), m/s².
        link_names: All links, those behind fixed and locked joints included.
        locked: Joints that were locked, and where.
        mimics: Joints that move with a driven one, value = multiplier · driven + offset; S of `Tree.coupling`.
        payload: What it carries, with the link resolved; None for nothing.
        warnings: What was taken otherwise than written, in plain words.
        provisos: In what it is not as its file says, for every statement about it.
        source: The URDF file.
        sha256: Hex digest of the file's bytes.
        urdf_text: The URDF as it was computed with: the file as it stands, or what was made of it, see `provisos`.
        files: Where its packages and meshes are looked for.
        model: Pinocchio's model, one coordinate for every joint that moves, mimicking ones included, so that
            nq = nv + the number of `mimics`. Treat it as read-only.
        tree: The same in plain arrays, for compiled kernels.
        made_of: What it is made of: the checked URDF, the registry's entry and the options.
    """

    name: str
    joint_names: tuple[str, ...]
    joint_kinds: tuple[str, ...]
    continuous: BoolArray
    lower: Array
    upper: Array
    effort_limit: Array
    velocity_limit: Array
    friction: Array
    damping: Array
    armature: Array
    gravity_vector: Array
    link_names: tuple[str, ...]
    locked: Mapping[str, float]
    mimics: Mapping[str, Mimic]
    payload: Payload | None
    warnings: tuple[str, ...]
    provisos: tuple[Proviso, ...]
    source: Path
    sha256: str
    urdf_text: str
    files: RobotFiles
    model: pin.Model
    tree: Tree
    made_of: MadeOf
    _local: threading.local = field(default_factory=threading.local)

    def __repr__(self) -> str:
        changed = {"payload": self.payload, "locked": dict(self.locked)}
        return f"Arm({self.name!r}, nv={self.nv}" + "".join(f", {k}={v!r}" for k, v in changed.items() if v) + ")"

    def lines(self) -> list[str]:
        """What it is and what it carries, and what was taken otherwise than written."""
        said = [
            f"{quoted(self.name)}: {self.nv} moving joint{'s' if self.nv > 1 else ''}, "
            f"{self.tree.mass.sum():.1f} kg move (URDF {self.sha256[:16]}…)"
        ]
        if self.payload is not None:
            said.append(f"payload: {self.payload.mass:g} kg on {quoted(str(self.payload.link))}")
        if self.locked:
            said.append("locked: " + ", ".join(f"{quoted(name)} at {angle:g}" for name, angle in self.locked.items()))
        said += [f"{proviso.kind}: {proviso.text}" for proviso in self.provisos]
        for name, mimic in self.mimics.items():
            offset = f" {mimic.offset:+g}" if mimic.offset else ""
            said.append(f"mimics: {quoted(name)} = {mimic.multiplier:g} · {quoted(mimic.joint)}{offset}")
        return [*said, *(f"note: {line}" for line in self.warnings)]

    def table(self) -> Cells:
        """Range, limits, friction and armature, joint by joint; what is not declared is said."""
        columns = (self.lower, self.upper, self.effort_limit, self.velocity_limit)
        rows = []
        for i, (name, kind) in enumerate(zip(self.joint_names, self.joint_kinds, strict=True)):
            limits = [f"{x[i]:g}" if np.isfinite(x[i]) else "not declared" for x in columns]
            losses = [f"{x[i]:g}" for x in (self.friction, self.damping, self.armature)]
            rows.append([printable(name), kind, *limits, *losses])
        figures = ["lower", "upper", "torque limit", "speed limit", "friction", "damping", "armature"]
        return ["joint (SI units)", "kind", *figures], rows

    def __reduce__(self) -> tuple[Any, ...]:
        # Pinocchio's scratch memory does not travel between processes; the arm is made anew where it arrives.
        return self.made_of.assemble, ()

    @property
    def source_name(self) -> str:
        """The name that it was asked for by, or the path of its file: how an experiment names it."""
        entry = self.made_of.entry
        return entry.name if entry is not None else str(self.source)

    @property
    def returns(self) -> BoolArray:
        """Whether the arm is as it was after a whole turn of a joint, what follows it included, shape (nv,)."""
        coupling, whole = self.tree.coupling, ~self.tree.prismatic
        whole = whole & (coupling.ratio == np.round(coupling.ratio))
        return np.array([bool(whole[coupling.coordinate == i].all()) for i in range(self.nv)], dtype=np.bool_)

    @property
    def box(self) -> tuple[Array, Array]:
        """Joint box, lower and upper, each of shape (nv,) and finite.

        A turning joint that is continuous or declares no limit gets one full turn.

        Raises:
            ArmError: A prismatic joint declares no limit, or joints that mimic one without limits are elsewhere after
                its turn, so no box can be assumed.
        """
        lower, upper = self.lower.copy(), self.upper.copy()
        for i, kind in enumerate(self.joint_kinds):
            if np.isfinite(lower[i]) and np.isfinite(upper[i]):
                continue
            name = self.joint_names[i]
            if kind == "revolute" and not self.returns[i]:
                raise ArmError(
                    self.source,
                    f"joint '{name}' of {self.name} declares no limits, and joints that mimic it are not where they "
                    f"were after a turn of it, so its range cannot be guessed; give it: --box {name}=lo:hi",
                )
            if kind == "prismatic":
                raise ArmError(
                    self.source,
                    f"joint '{name}' of {self.name} slides and declares no limits, and its range cannot be guessed; "
                    f"give it in metres: --box {name}=lo:hi",
                )
            if np.isfinite(lower[i]):
                upper[i] = lower[i] + 2.0 * np.pi
            elif np.isfinite(upper[i]):
                lower[i] = upper[i] - 2.0 * np.pi
            else:
                lower[i], upper[i] = -np.pi, np.pi
        return lower, upper

    def replace(
        self,
        *,
        payload: Load | Unchanged | None = UNCHANGED,
        armature: Armature | Unchanged | None = UNCHANGED,
        lock: Lock | Unchanged | None = UNCHANGED,
        gravity: Gravity | Unchanged | None = UNCHANGED,
        repair: bool | Unchanged | None = UNCHANGED,
        chain: ChainEnds | Unchanged | None = UNCHANGED,
    ) -> Arm:
        """The same URDF with other options; one that is not given stays as it is, None takes it away.

        Args:
            payload: As in `load_arm`.
            armature: As in `load_arm`.
            lock: As in `load_arm`; replaces all earlier locks except the entry's own.
            gravity: As in `load_arm`.
            repair: As in `load_arm`.
            chain: As in `load_arm`.

        Returns:
            A new arm.

        Raises:
            ArmError: The options leave no arm.
            ParameterError: An option at fault.
        """
        options = {
            "payload": payload,
            "armature": armature,
            "lock": lock,
            "gravity": gravity,
            "repair": repair,
            "chain": chain,
        }
        return self.made_of.vary(
            self, {name: value for name, value in options.items() if not isinstance(value, Unchanged)}
        )
