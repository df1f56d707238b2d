"""Stiff stops at the ends of the joints' ranges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from asmc_pin._typing import Array, Number
from asmc_pin.numerics.short_loops import as_written, short_loops
from asmc_pin.parameters import PerJoint
from asmc_pin.plant.per_trial import row, sized


@dataclass(frozen=True, kw_only=True, eq=False)
class EndStops:
    r"""Springs at the position limits that the URDF declares.

    Beyond a limit by d > 0, moving outwards at ḋ, a joint feels −stiffness·d·max(0, 1 + damping·ḋ): the stop pushes and
    never pulls, and its torque is continuous. Joints without limits have no stops.

    Source: K. H. Hunt, F. R. E. Crossley, "Coefficient of restitution interpreted as damping in vibroimpact", ASME
    Journal of Applied Mechanics 42(2), 1975.
    """

    stiffness: PerJoint = PerJoint("stiffness of the stops", "N·m/rad (N/m)", above=0.0, default=1e4)
    damping: PerJoint = PerJoint("damping over stiffness of the stops", "s/rad (s/m)", at_least=0.0, default=0.5)

    def check(self, nv: int) -> None:
        """Check the sizes against the arm; raises `ParameterError`."""
        sized("end_stops", self, nv)


@short_loops
def stop_torque(q: Number, v: Number, lower: Number, upper: Number, stiffness: Number, damping: Number) -> Number:
    """Torque of a stop on its joint; see `EndStops`."""
    above, below = np.maximum(q - upper, 0.0), np.maximum(lower - q, 0.0)
    rate = damping * v
    pushed: Number = stiffness * (below * np.maximum(1.0 - rate, 0.0) - above * np.maximum(1.0 + rate, 0.0))
    return pushed


class StopForces:
    """End stops of a batch.

    Args:
        stops: The parameters.
        lower: Lower limits, (nv,), rad; −inf for none.
        upper: Upper limits.
    """

    def __init__(self, stops: EndStops, lower: Array, upper: Array) -> None:
        nv = lower.size
        self.lower, self.upper = lower, upper
        # A joint without limits has no stop, so its stiffness must not ask for short steps either.
        limited = np.isfinite(lower) | np.isfinite(upper)
        self.stiffness, self.damping = row(stops.stiffness, nv, 0.0) * limited, row(stops.damping, nv, 0.0)

    def torque(self, q: Array, v: Array) -> Array:
        """Torque of the stops on the joints, (batch, nv), N·m."""
        return np.asarray(as_written(stop_torque)(q, v, self.lower, self.upper, self.stiffness, self.damping))

    def energy(self, q: Array) -> Array:
        """Energy stored in the stops, (...), J."""
        past = np.maximum(q - self.upper, 0.0) + np.maximum(self.lower - q, 0.0)
        return np.asarray(0.5 * np.sum(self.stiffness * past**2, axis=-1))
