"""The logged torque as a model says it: rigid body, rotor, friction, what is carried, and the sensor's own faults.

    u(t − d) = κ [ M q̈ + C q̇ + g + armature q̈ + Y π(m, c) + level(q̇) sgn(q̇) + viscous q̇ ] + offset
    level(v) = coulomb + weakening exp(−(v/stribeck_velocity)²)

per joint, with u what was logged, κ the torque constant (1 where the log is right), d the delay and Y π the torque of a
point of mass m at c on the last link. Every term goes through the filter that the logged torque goes through.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import maximum_filter1d

from asmc_pin._typing import Array, BoolArray
from asmc_pin.arms import Arm
from asmc_pin.identification.filtered_motion import FilteredMotion

PER_JOINT = ("coulomb", "viscous", "weakening", "stribeck_velocity", "armature", "torque_constant", "torque_offset")
PAYLOAD = ("payload.mass", "payload.moment.x", "payload.moment.y", "payload.moment.z")

_WINDOW = 0.8
"""Half the window of the filter in periods of its band: beyond it a step leaves less than a hundredth."""

START = {"torque_constant": 1.0, "stribeck_velocity": 0.1}
"""Values of what is not estimated, where that is not 0."""

LEAST = {"coulomb": 0.0, "viscous": 0.0, "weakening": 0.0, "armature": 0.0}
"""What cannot be less, by physics."""


@dataclass(frozen=True, eq=False)
class TorqueModel:
    """The terms of the model at the rows that are fitted.

    Attributes:
        arm: Whose M, C and g are taken as its URDF says.
        motion: The log.
        names: All parameters, in the order of the vectors below.
        rigid: Model torque of the URDF, filtered, shape (R, nv), N·m.
        carried: Torque for each entry of mass, moment (3) and inertia (6) of the last link, shape (R, nv, 10).
        acceleration: Filtered, shape (R, nv), rad/s².
        velocity: Filtered, shape (R, nv), rad/s.
        usable: Rows in which a joint slides all through the filter's window, shape (R, nv).
    """

    arm: Arm
    motion: FilteredMotion
    names: tuple[str, ...]
    rigid: Array
    carried: Array
    acceleration: Array
    velocity: Array
    usable: BoolArray
    sign: Array
    signs: Array
    _known: dict[bytes, tuple[Array, Array]] = field(default_factory=dict)

    @property
    def time(self) -> Array:
        """Times of the rows, s."""
        return np.asarray(self.motion.time[self.motion.rows])

    def start(self) -> Array:
        """Values before anything is estimated: those of the URDF, with nothing added."""
        return np.array([START.get(name.split(":")[0], 0.0) for name in self.names])

    def logged(self, delay: float, *, derivative: int = 0) -> Array:
        """The logged torque at times t − delay, (R, nv), or its derivative."""
        span = self.motion.time
        return np.asarray(self.motion.torque(np.clip(self.time - delay, span[0], span[-1]), derivative))

    def weakening(self, velocity: Array) -> tuple[Array, Array]:
        """exp(−(v/v_s)²) sgn v, filtered, and its derivative by v_s; each (R, nv)."""
        key = velocity.tobytes()
        if key not in self._known:
            share = np.exp(-((self.motion.v / velocity) ** 2)) * self.signs
            slope = share * 2.0 * self.motion.v**2 / velocity**3
            self._known.clear()
            self._known[key] = self.motion.fitted(share), self.motion.fitted(slope)
        return self._known[key]

    def residual(self, values: Array) -> tuple[Array, Array]:
        """Logged − model torque, (R, nv), and its derivative by every parameter, (R, nv, parameters)."""
        nv, rows = self.arm.nv, len(self.rigid)
        of = self.joint_values(values)
        share, slope = self.weakening(np.maximum(of["stribeck_velocity"], 1e-3))
        mass, moment = values[self.index("payload.mass")], values[self._moment]
        pi, pi_mass, pi_moment = point_mass(mass, moment)
        extra = of["weakening"]
        inner = (
            self.rigid
            + of["armature"] * self.acceleration
            + self.carried @ pi
            + of["coulomb"] * self.sign
            + extra * share
            + of["viscous"] * self.velocity
        )
        kappa, delay = of["torque_constant"], float(values[self.index("delay")])
        residual = self.logged(delay) - kappa * inner - of["torque_offset"]
        jacobian = np.zeros((rows, nv, len(self.names)))
        terms = {
            "coulomb": kappa * self.sign,
            "viscous": kappa * self.velocity,
            "weakening": kappa * share,
            "stribeck_velocity": kappa * extra * slope,
            "armature": kappa * self.acceleration,
            "torque_constant": inner,
            "torque_offset": np.ones((rows, nv)),
        }
        for j in range(nv):
            for kind, term in terms.items():
                jacobian[:, j, self.index(kind, j)] = -term[:, j]
        jacobian[:, :, self.index("payload.mass")] = -kappa * (self.carried @ pi_mass)
        jacobian[:, :, self._moment] = -kappa[:, None] * (self.carried @ pi_moment)
        jacobian[:, :, self.index("delay")] = -self.logged(delay, derivative=1)
        return residual, jacobian

    def joint_values(self, values: Array) -> dict[str, Array]:
        """The parameters of the joints, by kind, each (nv,)."""
        nv = self.arm.nv
        return {kind: values[i * nv : (i + 1) * nv] for i, kind in enumerate(PER_JOINT)}

    def index(self, kind: str, joint: int | None = None) -> int:
        """Where a parameter stands."""
        if joint is not None:
            return PER_JOINT.index(kind) * self.arm.nv + joint
        return self.names.index(kind)

    @property
    def _moment(self) -> slice:
        first = self.index("payload.moment.x")
        return slice(first, first + 3)


def parameter_names(joints: Sequence[str]) -> tuple[str, ...]:
    """Names of all parameters: ``kind:joint``, then those of the payload, then the delay."""
    return (*(f"{kind}:{joint}" for kind in PER_JOINT for joint in joints), *PAYLOAD, "delay")


def point_mass(mass: float, moment: Array) -> tuple[Array, Array, Array]:
    """Mass, moment and inertia of a point, in Pinocchio's order, with derivatives by mass, (10,), and moment, (10, 3).

    The inertia about the frame is (|h|² 1 − h hᵀ)/m with h = m c; without a mass there is none.
    """
    inertia, of_mass, of_moment = np.zeros(6), np.zeros(6), np.zeros((6, 3))
    entries = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
    if abs(mass) > 1e-6:
        for k, (i, j) in enumerate(entries):
            same = float(i == j)
            inertia[k] = (same * moment @ moment - moment[i] * moment[j]) / mass
            of_mass[k] = -inertia[k] / mass
            for axis in range(3):
                own = float(axis == i) * moment[j] + float(axis == j) * moment[i]
                of_moment[k, axis] = (2.0 * same * moment[axis] - own) / mass
    pi = np.concatenate([[mass], moment, inertia])
    pi_mass = np.concatenate([[1.0], np.zeros(3), of_mass])
    pi_moment = np.concatenate([np.zeros((1, 3)), np.eye(3), of_moment])
    return pi, pi_mass, pi_moment


def torque_model(arm: Arm, motion: FilteredMotion, rest: Array) -> TorqueModel:
    """The terms of the model along a log.

    Args:
        arm: As its URDF says.
        motion: The log.
        rest: Speeds below which a joint is taken to stick or to be about to, shape (nv,), rad/s.
    """
    rows = motion.fitted
    links = arm.regressor(motion.q, motion.v, motion.v, motion.a)
    bodies = arm.inertial_parameters.size - arm.nv
    rigid = links @ arm.inertial_parameters
    last = links[..., bodies - 10 : bodies]
    # The mean of sgn over a step along a straight line of velocities: no jump is late by a share of a step.
    turn = np.abs(motion.a) * motion.step * 0.5
    signs = np.clip(motion.v / np.maximum(turn, 1e-12), -1.0, 1.0)
    still = np.abs(motion.v) < rest
    return TorqueModel(
        arm=arm,
        motion=motion,
        names=parameter_names(arm.joint_names),
        rigid=rows(rigid),
        carried=rows(last),
        acceleration=rows(motion.a),
        velocity=rows(motion.v),
        usable=_all_through(motion, still),
        sign=rows(signs),
        signs=signs,
    )


def _all_through(motion: FilteredMotion, still: BoolArray) -> BoolArray:
    """Rows in whose window of the filter no joint rests, and that does not reach beyond the log; (R, nv)."""
    reach = _WINDOW / motion.band
    near = maximum_filter1d(still, size=2 * int(reach / motion.step) + 1, axis=0)[:: motion.stride]
    times = motion.time[motion.rows]
    inside = (times > motion.time[0] + 2.0 * reach) & (times < motion.time[-1] - 2.0 * reach)
    return np.asarray(~near & inside[:, None])
