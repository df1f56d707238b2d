"""What the last joint carries must be a body that can be: its pseudo-inertia has no negative eigenvalue.

The pseudo-inertia of a body is J = [[Σ, h], [hᵀ, m]] with the second moments Σ = ½ tr(I) 1 − I about the joint's frame,
h = m c and the mass m; a body is possible exactly where J is positive semidefinite (Wensing, Kim, Slotine (2018), IEEE
Robotics and Automation Letters 3(1)), which is what `repair` looks for too. To the last body J₀ of the URDF the log
adds a point: J = J₀ + x xᵀ/m with x = (h, m). With m > 0 that is always possible. With m < 0 something is taken away,
and J ⪰ 0 where [[J₀, x], [xᵀ, −m]] ⪰ 0 (Schur), which is linear in h and m: the step of Gauss and Newton within it is a
semidefinite program.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array, IntArray
from asmc_pin.arms import Arm
from asmc_pin.identification.torque_model import PAYLOAD, TorqueModel, point_mass

_THICKNESS = 0.01  # of its radius of gyration: a rod as thin as a line, of which nothing off it can be taken, has that
_SLACK = 1e-6  # of the body's largest eigenvalue: what a solver leaves
_MARGIN = 1e-9  # by which the program stays inside


def pseudo_inertia(parameters: Array) -> Array:
    """The pseudo-inertia, (4, 4), of mass, moment (3) and inertia (xx, xy, yy, xz, yz, zz) about a frame, (10,)."""
    mass, hx, hy, hz, xx, xy, yy, xz, yz, zz = parameters
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    whole = np.empty((4, 4))
    whole[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    whole[:3, 3] = whole[3, :3] = hx, hy, hz
    whole[3, 3] = mass
    return whole


@dataclass(frozen=True, eq=False)
class LastBody:
    """What the URDF, and the payload that the arm was loaded with, put on the last joint.

    Attributes:
        own: Its pseudo-inertia, shape (4, 4), of a mass above 0.
    """

    own: Array

    @classmethod
    def of(cls, arm: Arm) -> LastBody:
        """The last body of an arm; a link of no thickness is given a hundredth of its radius of gyration."""
        own = pseudo_inertia(np.asarray(arm.model.inertias[arm.model.njoints - 1].toDynamicParameters()))
        centre = own[:3, 3] / own[3, 3]
        spread = own[:3, :3] - own[3, 3] * np.outer(centre, centre)
        moments, axes = np.linalg.eigh(spread)
        least = _THICKNESS**2 * max(float(np.trace(spread)), 1e-12 * float(own[3, 3]))
        own[:3, :3] += (axes * np.maximum(least - moments, 0.0)) @ axes.T
        return cls(own)

    @property
    def mass(self) -> float:
        """Its mass, kg."""
        return float(self.own[3, 3])

    def least_share(self, model: TorqueModel, values: Array) -> float:
        """The least eigenvalue of the pseudo-inertia with what the log adds, over the largest of the body's own."""
        x = _payload(model, values)
        whole = self.own + pseudo_inertia(point_mass(float(x[0]), x[1:])[0])
        scaled = self._scaled(whole)
        return float(np.linalg.eigvalsh(scaled)[0] / np.linalg.eigvalsh(self._scaled(self.own))[-1])

    def is_possible(self, model: TorqueModel, values: Array) -> bool:
        """Whether the last body can be, with what the log adds."""
        return self.least_share(model, values) > -_SLACK

    def step(
        self,
        factor: Array,
        target: Array,
        ends: tuple[Array, Array],
        scale: Array,
        payload: Sequence[int | None],
        at: Array,
    ) -> Array:
        """The step with the least ‖factor y − target‖, y = scale · step, after which the last body is possible.

        Args:
            factor: Upper triangular, shape (p, p).
            target: Shape (p,).
            ends: Of y, each of shape (p,).
            scale: Of the p parameters, shape (p,).
            payload: Which of them are `PAYLOAD`; None for what is not estimated.
            at: Where they are now, shape (p,).

        Returns:
            y, shape (p,). Where the solver finds none, nothing.
        """
        import cvxpy

        cp: Any = cvxpy
        step = cp.Variable(len(target))
        limits = [step[k] >= ends[0][k] for k in np.flatnonzero(np.isfinite(ends[0]))]
        limits += [step[k] <= ends[1][k] for k in np.flatnonzero(np.isfinite(ends[1]))]
        mass, *moment = [0.0 if k is None else at[k] + step[k] / scale[k] for k in payload]
        size = self._size
        added = cp.vstack([*(part / size for part in moment), mass]) / self.mass
        own = self._scaled(self.own) / self.mass - _MARGIN * np.eye(4)
        if payload[0] is None:
            column = cp.vstack([*(part / size for part in moment), 0.0]) / self.mass
            last = np.array([[0.0, 0.0, 0.0, 1.0]])
            limits.append(own + column @ last + last.T @ column.T >> 0)
        else:
            limits.append(cp.bmat([[own, added], [added.T, cp.reshape(-mass / self.mass, (1, 1), order="F")]]) >> 0)
        program = cp.Problem(cp.Minimize(cp.sum_squares(factor @ step - target)), limits)
        try:
            with warnings.catch_warnings():
                # An almost solved step is a step; whether it is worth something the fit looks at.
                warnings.filterwarnings("ignore", "Solution may be inaccurate", UserWarning)
                program.solve(solver=cp.CLARABEL)
        except (cp.error.SolverError, ValueError, ArithmeticError):
            return np.zeros(len(target))
        return np.zeros(len(target)) if step.value is None else np.asarray(step.value)

    @property
    def _size(self) -> float:
        """Radius of gyration, m: the length by which moments and masses become alike."""
        return float(np.sqrt(max(np.trace(self.own[:3, :3]) / self.mass, 1e-8)))

    def _scaled(self, whole: Array) -> Array:
        scale = np.array([1.0 / self._size] * 3 + [1.0])
        return np.asarray(scale[:, None] * whole * scale)


def payload_entries(model: TorqueModel, places: IntArray) -> list[int | None]:
    """Which of some parameters are those of `PAYLOAD`; None for what is not among them."""
    found = [np.flatnonzero(places == model.index(name)) for name in PAYLOAD]
    return [int(each[0]) if each.size else None for each in found]


def _payload(model: TorqueModel, values: Array) -> Array:
    return np.asarray(values[[model.index(name) for name in PAYLOAD]])
