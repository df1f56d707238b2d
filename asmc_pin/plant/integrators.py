"""How the state is carried over one step; a scheme is a function, and `INTEGRATORS` names them.

To add one: write a function of the shape of `Integrator`, register it. It asks `Mechanics` for accelerations and lets
it apply friction, and knows nothing of drives, sensors or controllers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from asmc_pin._typing import Array


class Mechanics(Protocol):
    """What a scheme may ask of the plant; arrays of shape (batch, nv)."""

    def acceleration(self, q: Array, v: Array, torque: Array) -> Array:
        """Joint acceleration without friction, rad/s²."""
        ...

    def after_friction(self, q: Array, v: Array, acceleration: Array, step: float, impulse: Array) -> Array:
        """Velocity after a step under that acceleration and friction; adds friction's impulse, N·m·s, to `impulse`."""
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


INTEGRATORS: dict[str, Integrator] = {"semi_implicit": semi_implicit}
"""The schemes by the names that experiments use."""
