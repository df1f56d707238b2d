"""Warnings about gains outside the stable region, cheap enough to be given before every run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import BoxLike
from asmc_pin.numerics.float_range import LARGEST
from asmc_pin.sampled.frozen_arms import FrozenArms, frozen_arms
from asmc_pin.sampled.law_loops import law_loops
from asmc_pin.sampled.loop_analysis import remedy_of, spaces_of
from asmc_pin.sampled.noise.sensor_model import LoopSensor
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


_SAMPLES = 128
_FINEST = 0.01  # of a joint's range


@dataclass(frozen=True, eq=False)
class _Searched:
    """One of the arms that a loop has to hold, and where it is searched.

    Attributes:
        words: When it moves and with which links; empty where there is no other.
        arms: The arm over its joint box.
        spaces: A quick look at it: the inertia alone and, where gravity acts, at rest.
    """

    words: str
    arms: FrozenArms
    spaces: tuple[Workspace, ...]

    @property
    def place(self) -> str:
        """For a sentence that goes on with a configuration."""
        return f"{self.words}, " if self.words else ""


def _searched(words: str, arm: Arm, box: BoxLike, viscous: Array | None) -> _Searched:
    arms = frozen_arms(arm, box)
    spaces = spaces_of(arms, samples=_SAMPLES, seed=0, viscous=viscous)
    return _Searched(words, arms, tuple(space.thinned(_SAMPLES, _FINEST) for space in spaces))


def gain_warnings(
    arm: Arm | Mapping[str, Arm],
    controllers: Mapping[str, Any],
    period: float | None = None,
    *,
    delay: float = 0.0,
    sensor: LoopSensor | None = None,
    viscous: ArrayLike | None = None,
    box: BoxLike = None,
) -> list[str]:
    """What a user should know about gains before a run; a quick search, so silence is not a proof.

    Every law here contains PPC (7), whose frozen loop is examined over the workspace and about rest under gravity.
    Where that is unstable, `stability` says what helps, without the friction, and it is said here in its words.
    Inside a boundary layer β acts as β + K/Φ, which is examined too. Switching terms are not linear and are left out.

    Args:
        arm: The arm; or every arm that a run has, by words that say when it moves and with which links, of which each
            loop is judged by the worst.
        controllers: Label -> law. One without `mbar, ks, beta` is not of this kind and is passed over.
        period: Control period, s; by default each law's own.
        delay: The plant's transport delay, periods.
        sensor: Its sensors, which change the loop; ideal ones by default.
        viscous: Viscous friction that may be counted on, N·m·s/rad, a scalar, (nv,) or (batch, nv), of which the
            least counts; none by default, to be careful.
        box: Joint box; the arm's own by default.

    Returns:
        One sentence per finding, laws with the same loop together; empty if nothing was found.

    Raises:
        ParameterError: a law is for another number of joints.
    """
    arms = dict(arm) if isinstance(arm, Mapping) else {"": arm}
    first = next(iter(arms.values()))
    loops = law_loops(first, controllers, period, delay=delay, sensor=sensor)
    if not loops:
        return []
    friction = None if viscous is None else _counted_on(viscous, first.nv)
    searched = [_searched(words, each, box, friction) for words, each in arms.items()]
    found = [_about_loop(item.title, item.loop, searched) for item in loops]
    for item in loops:
        inside = {label: np.minimum(item.loop.beta + slope, LARGEST) for label, slope in item.layers.items()}
        layers = {label: replace(item.loop, beta=beta) for label, beta in inside.items()}
        found += [_about_layer(label, loop, searched) for label, loop in layers.items()]
        found += [_about_band(label, loop, searched) for label, loop in item.bands.items()]
    return [warning for warning in found if warning]


def _about_loop(labels: str, loop: SampledLoop, searched: Sequence[_Searched]) -> str:
    for at_rest in (False, True)[: len(searched[0].spaces)]:
        radius, q, where = _worst(loop, searched, at_rest)
        if radius < 1.0:
            continue
        said = (
            f"{labels}: {where.place}at rest near q = {_angles(q)} rad gravity drives the sampled loop away from its "
            f"set point (spectral radius {radius:.4f} at L = {loop.period:g} s)"
            if at_rest
            else f"{labels}: the sampled loop is unstable {where.place}at q = {_angles(q)} rad (spectral radius "
            f"{radius:.4f} at L = {loop.period:g} s)"
        )
        helps = remedy_of(where.arms, loop)
        about = f" (searched for the arm {where.words})" if where.words else ""
        return f"{said}; {helps}{about}" if helps else said
    return ""


def _about_layer(label: str, loop: SampledLoop, searched: Sequence[_Searched]) -> str:
    radius, q, where = _worst(loop, searched, at_rest=False)
    if radius < 1.0:
        return ""
    return (
        f"{label}: inside its boundary layer, where β acts as β + K/Φ = {_angles(loop.beta)}, the sampled loop is "
        f"unstable (spectral radius {radius:.4f} {where.place}at q = {_angles(q)} rad), so expect chatter; widen Φ or "
        "lower K"
    )


def _about_band(label: str, loop: SampledLoop, searched: Sequence[_Searched]) -> str:
    radius, q, where = _worst(loop, searched, at_rest=False)
    if radius < 1.0:
        return ""
    return (
        f"{label}: inside its band, where the law is linear, the sampled loop is unstable (spectral radius "
        f"{radius:.4f} {where.place}at q = {_angles(q)} rad), so expect chatter; {loop.law.band_remedy}"
    )


def _worst(loop: SampledLoop, searched: Sequence[_Searched], at_rest: bool) -> tuple[float, Array, _Searched]:
    """Largest radius over several arms, its configuration, and which of them it is."""
    found = [(*item.spaces[at_rest].worst(loop)[:2], item) for item in searched]
    radius, point, item = max(found, key=lambda one: one[0])
    return radius, item.arms.q(point), item


def _counted_on(viscous: ArrayLike, nv: int) -> Array | None:
    """The least friction of each joint over the trials; None if there is none, so that modes separate."""
    given = np.asarray(viscous, dtype=np.float64)
    least = np.broadcast_to(given, np.broadcast_shapes(given.shape, (1, nv))).min(axis=0)
    return least if least.any() else None


def _angles(q: Array) -> str:
    return "(" + ", ".join(f"{angle:.3g}" for angle in q) + ")"
