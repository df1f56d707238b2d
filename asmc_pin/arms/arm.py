"""An arm: its dynamics as equation (1) of Baek (2016) without friction, and what its URDF declares."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pinocchio as pin

from asmc_pin._typing import Array, BoolArray
from asmc_pin.arms.arm_options import UNCHANGED, Armature, ChainEnds, Gravity, Load, Lock, Unchanged, Variant
from asmc_pin.arms.payload import Payload
from asmc_pin.arms.registry import ArmEntry
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.arms.urdf.urdf_reading import Mimic, Robot
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.rigid_body.leading_axes import joint_rows
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
class Arm(Shown):
    """A robot arm on a fixed base; immutable, arrays read-only. Make one with `load_arm`.

    M(q) q̈ + C(q, q̇) q̇ + g(q) = τ − f(q̇): this class gives M, C and g; friction and damping are reported, the plant
    applies them. Every joint has one coordinate: rad, rad/s, N·m, kg·m² where it turns, m, m/s, N, kg where it slides.

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
    def nv(self) -> int:
        """Number of driven joints."""
        return len(self.joint_names)

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

    def mass_matrix(self, q: Array) -> Array:
        """Joint-space inertia M(q), armature included.

        Args:
            q: Shape (..., nv).

        Returns:
            Shape (..., nv, nv), exactly symmetric.
        """
        mass = self._batched(pin.crba, (self.model.nv, self.model.nv), q=q)
        if not self.mimics:
            return mass
        mass = self.tree.coupling.form(mass)
        return np.asarray(0.5 * (mass + mass.swapaxes(-1, -2)))

    def coriolis(self, q: Array, v: Array) -> Array:
        """The matrix C(q, q̇) of Christoffel symbols: C q̇ is the Coriolis torque, and Ṁ − 2C is skew-symmetric.

        Args:
            q: Shape (..., nv).
            v: Shape (..., nv).

        Returns:
            Shape (..., nv, nv).
        """
        # S does not change, so the symbols of SᵀMS are those of M, and no term comes of S.
        return self.tree.coupling.form(
            self._batched(pin.computeCoriolisMatrix, (self.model.nv, self.model.nv), q=q, v=v)
        )

    def gravity(self, q: Array) -> Array:
        """Torque g(q) that holds the arm against gravity.

        Args:
            q: Shape (..., nv).

        Returns:
            Shape (..., nv).
        """
        return self.tree.coupling.forces(self._batched(pin.computeGeneralizedGravity, (self.model.nv,), q=q))

    def bias(self, q: Array, v: Array) -> Array:
        """C(q, q̇) q̇ + g(q), without friction.

        Args:
            q: Shape (..., nv).
            v: Shape (..., nv).

        Returns:
            Shape (..., nv).
        """
        return self.tree.coupling.forces(self._batched(pin.nonLinearEffects, (self.model.nv,), q=q, v=v))

    @property
    def inertial_parameters(self) -> Array:
        """What `regressor` multiplies: ten for each moving link, from the base on, then the armature of each joint.

        A link's are mass, mass × centre of mass (3) and the inertia about the joint's frame (xx, xy, yy, xz, yz, zz).
        """
        links = [inertia.toDynamicParameters() for inertia in list(self.model.inertias)[1:]]
        return np.concatenate([*links, self.armature])

    def regressor(self, q: Array, v: Array, v_r: Array, a_r: Array) -> Array:
        """The matrix Y with Y θ = M(q) a_r + C(q, v) v_r + g(q), θ the `inertial_parameters`.

        C is that of Christoffel symbols, so that C(q, x) y is bilinear and symmetric in x and y: it is a quarter of the
        difference of C(q, x + y)(x + y) and C(q, x − y)(x − y), of which Pinocchio has regressors.

        Args:
            q: Shape (..., nv).
            v: Velocity, shape (..., nv).
            v_r: Reference velocity of Slotine and Li, shape (..., nv).
            a_r: Reference acceleration, shape (..., nv).

        Returns:
            Shape (..., nv, 10 links + nv).

        Raises:
            ParameterError: a joint mimics another: Pinocchio's regressor knows no such joint.
        """
        if self.mimics:
            raise ParameterError(
                "arm",
                "has joints that mimic others, for which there is no regressor; lock the joint that they follow, or "
                "take a law that needs none",
            )
        still = np.zeros(self.nv)

        def rows(model: pin.Model, data: pin.Data, q: Array, v: Array, v_r: Array, a_r: Array) -> Array:
            def part(velocity: Array, acceleration: Array) -> Array:
                return np.array(pin.computeJointTorqueRegressor(model, data, q, velocity, acceleration))

            if np.array_equal(v, v_r):  # what Pinocchio has, three times as quick
                return np.concatenate([part(v, a_r), np.diag(a_r)], axis=1)
            links = part(still, a_r) + 0.25 * (part(v + v_r, still) - part(v - v_r, still))
            return np.concatenate([links, np.diag(a_r)], axis=1)

        return self._batched(rows, (self.nv, self.inertial_parameters.size), q=q, v=v, v_r=v_r, a_r=a_r)

    def forward_dynamics(self, q: Array, v: Array, torque: Array) -> Array:
        """Acceleration M⁻¹(τ − C q̇ − g), without friction.

        Args:
            q: Shape (..., nv).
            v: Shape (..., nv).
            torque: Shape (..., nv).

        Returns:
            Shape (..., nv).
        """
        if not self.mimics:
            return self._batched(pin.aba, (self.nv,), q=q, v=v, torque=torque)
        # Pinocchio's aba knows no joint that follows another: M and the forces are projected, and solved for.
        lead, (q, v, torque) = joint_rows(self.joint_names, {"q": q, "v": v, "torque": torque})
        left = torque - self.bias(q, v)
        return np.asarray(np.linalg.solve(self.mass_matrix(q), left[..., None])[..., 0].reshape(*lead, self.nv))

    def link_poses(self, q: Array) -> Array:
        """Pose of every link in the base frame, in the order of `link_names`.

        Args:
            q: Shape (..., nv).

        Returns:
            Homogeneous matrices, shape (..., nlinks, 4, 4), m.
        """
        frames = [self.model.getFrameId(name, pin.FrameType.BODY) for name in self.link_names]

        def poses(model: pin.Model, data: pin.Data, q: Array) -> list[Array]:
            pin.framesForwardKinematics(model, data, q)
            return [data.oMf[frame].homogeneous for frame in frames]

        return self._batched(poses, (len(frames), 4, 4), q=q)

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

    def _batched(self, function: Callable[..., Any], shape: tuple[int, ...], **arguments: Array) -> Array:
        """Apply a Pinocchio function over the leading axes of its arguments, which broadcast, joint by joint."""
        lead, rows = joint_rows(self.joint_names, arguments)
        to_joints = {"q": self.tree.coupling.joints, "v": self.tree.coupling.rates}
        rows = [to_joints.get(name, np.asarray)(row) for name, row in zip(arguments, rows, strict=True)]
        out = np.empty((rows[0].shape[0], *shape))
        data = self._data()
        for k, row in enumerate(zip(*rows, strict=True)):
            out[k] = function(self.model, data, *row)
        return out.reshape(*lead, *shape)

    def _data(self) -> pin.Data:
        """Pinocchio's scratch memory, one per thread."""
        data = getattr(self._local, "data", None)
        if data is None:
            data = self._local.data = self.model.createData()
        return data
