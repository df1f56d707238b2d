"""How the state is carried over one step; a scheme is a function, and `INTEGRATORS` names them.

To add one: write a function of the shape of `Integrator`, register it with the order that it claims, and the tests
measure it. It asks `Mechanics` for accelerations and lets it apply friction, and knows nothing of drives, sensors or
controllers. Which to take: docs/plant.md.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from asmc_pin._typing import Array, BoolArray


class Mechanics(Protocol):
    """What a scheme may ask of the plant; arrays of shape (batch, n), n coordinates.

    Attributes:
        frictionless: Whether no trial has any friction.
    """

    frictionless: bool

    def acceleration(self, q: Array, v: Array, torque: Array) -> Array:
        """Acceleration without friction, rad/s²."""
        ...

    def after_friction(
        self,
        q: Array,
        v: Array,
        acceleration: Array,
        step: float,
        impulse: Array,
        *,
        sliding_at: Array | None = None,
        implicit: float = 1.0,
        trial_run: bool = False,
    ) -> Array:
        """Velocity after a step under that acceleration and friction; adds friction's impulse, N·m·s, to `impulse`.

        Friction's levels are those at the velocity `sliding_at`, v if omitted; viscous friction acts at
        implicit·v⁺ + (1 − implicit)·v. A `trial_run` leaves the state of presliding as it is.
        """
        ...

    def sliding_friction(self, v: Array) -> Array:
        """Torque of friction on joints that slide at v, N·m; at rest that of Coulomb friction is left out."""
        ...

    def slides(self, *velocities: Array) -> BoolArray:
        """Which trials, (batch,) bool, keep sliding the same way at all of these velocities in every joint."""
        ...


Integrator = Callable[[Mechanics, Array, Array, Array, float, Array], tuple[Array, Array]]
"""(mechanics, q, v, torque held over the step, step, impulse of friction to add to) -> q and v after the step."""


def semi_implicit(
    mechanics: Mechanics, q: Array, v: Array, torque: Array, step: float, impulse: Array
) -> tuple[Array, Array]:
    """Moreau's midpoint rule: half a drift, a kick with friction at the middle, half a drift.

        q_m = q + (h/2) v,    M(q_m)(v⁺ − v) = h (τ − C(q_m, v) v − g(q_m)) + friction(v⁺),    q⁺ = q_m + (h/2) v⁺

    One evaluation of the dynamics per step, as the plain semi-implicit Euler scheme q⁺ = q + h v⁺ needs, but exact for
    constant inertia under constant torque, where q⁺ = q + h (v + v⁺)/2. Without velocity-dependent forces it is the
    Störmer–Verlet scheme: of second order, symplectic, so that energy does not drift. Coriolis forces are taken at v,
    before the step, and friction at v⁺: both make it first order. A joint at rest that sticks keeps its q to the last
    bit, since v = v⁺ = 0.

    Source: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", in Nonsmooth Mechanics and
    Applications, CISM Courses and Lectures 302, Springer (1988).
    """
    half = 0.5 * step
    middle = q + half * v
    next_v = mechanics.after_friction(middle, v, mechanics.acceleration(middle, v, torque), step, impulse)
    return middle + half * next_v, next_v


def midpoint(
    mechanics: Mechanics, q: Array, v: Array, torque: Array, step: float, impulse: Array
) -> tuple[Array, Array]:
    """The same with Coriolis forces and friction's levels at the middle too: second order between stick and slip.

    v_m after half a step at q_m = q + (h/2) v is predicted first; then, with viscous friction at (v + v⁺)/2,

        M(q_m)(v⁺ − v) = h (τ − C(q_m, v_m) v_m − g(q_m)) + friction,    q⁺ = q + (h/2)(v + v⁺)

    Two evaluations of the dynamics per step. A step in which a joint stops, starts or turns is of first order, as in
    every scheme that does not look for the instant. Sticking joints keep their q to the last bit.
    """
    half = 0.5 * step
    middle = q + half * v
    early = mechanics.acceleration(middle, v, torque)
    v_m = mechanics.after_friction(middle, v, early, half, np.zeros_like(impulse), trial_run=True)
    late = mechanics.acceleration(middle, v_m, torque)
    next_v = mechanics.after_friction(middle, v, late, step, impulse, sliding_at=v_m, implicit=0.5)
    return q + half * (v + next_v), next_v


def rk4(mechanics: Mechanics, q: Array, v: Array, torque: Array, step: float, impulse: Array) -> tuple[Array, Array]:
    """The classical Runge–Kutta scheme where every joint slides on, the `midpoint` step in trials where one does not.

    Friction of a joint that slides is a smooth function of its velocity, so the step is of fourth order then. A trial
    in which a joint with Coulomb friction rests, stops or turns during the step takes the midpoint step instead, whose
    sticking is exact. Four evaluations of the dynamics per step, six if a trial falls back.
    """
    half = 0.5 * step
    impulses = np.zeros_like(impulse)
    weights = (1.0, 2.0, 2.0, 1.0)
    spans = (half, half, step, 0.0)
    velocities, slopes_q, slopes_v = [], np.zeros_like(q), np.zeros_like(v)
    q_at, v_at = q, v
    for weight, span in zip(weights, spans, strict=True):
        velocities.append(v_at)
        friction = 0.0 if mechanics.frictionless else mechanics.sliding_friction(v_at)
        slope = mechanics.acceleration(q_at, v_at, torque + friction)
        slopes_q = slopes_q + weight * v_at
        slopes_v = slopes_v + weight * slope
        impulses = impulses + (weight * step / 6.0) * friction
        q_at, v_at = q + span * v_at, v + span * slope
    next_q, next_v = q + (step / 6.0) * slopes_q, v + (step / 6.0) * slopes_v
    if mechanics.frictionless:
        return next_q, next_v
    smooth = mechanics.slides(*velocities, next_v)[:, None]
    if smooth.all():
        impulse += impulses
        return next_q, next_v
    other = np.zeros_like(impulse)
    other_q, other_v = midpoint(mechanics, q, v, torque, step, other)
    impulse += np.where(smooth, impulses, other)
    return np.where(smooth, next_q, other_q), np.where(smooth, next_v, other_v)


INTEGRATORS: dict[str, Integrator] = {"semi_implicit": semi_implicit, "midpoint": midpoint, "rk4": rk4}
"""The schemes by the names that experiments use."""

ORDERS: dict[str, int] = {"semi_implicit": 1, "midpoint": 2, "rk4": 4}
"""Order of convergence of each scheme while no joint stops, starts or turns; measured by the tests."""
