"""Warnings about gains outside the stable region, cheap enough to be given before every run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import BoxLike
from asmc_pin.sampled.frozen_arms import frozen_arms
from asmc_pin.sampled.loop_analysis import loop_for, remedy_of, spaces_of
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

_SAMPLES = 128
_FINEST = 0.01  # of a joint's range


def gain_warnings(
    arm: Arm,
    controllers: Mapping[str, Any],
    period: float | None = None,
    *,
    delay: float = 0.0,
    viscous: ArrayLike | None = None,
    box: BoxLike = None,
    seed: int = 0,
) -> list[str]:
    """What a user should know about gains before a run; a quick search, so silence is not a proof.

    Every law here contains PPC (7), whose frozen loop is examined over the workspace and about rest under gravity.
    Where that is unstable, `stability` says what helps, without the friction, and it is said here in its words.
    Inside a boundary layer β acts as β + K/Φ, which is examined too. Switching terms are not linear and are left out.

    Args:
        arm: The arm.
        controllers: Label -> law. One without `mbar, ks, beta` is not of this kind and is passed over.
        period: Control period, s; by default each law's own.
        delay: The plant's transport delay, periods.
        viscous: Viscous friction that may be counted on, N·m·s/rad, a scalar, (nv,) or (batch, nv), of which the
            least counts; none by default, to be careful.
        box: Joint box; the arm's own by default.
        seed: Of the samples.

    Returns:
        One sentence per finding, laws with the same loop together; empty if nothing was found.

    Raises:
        ParameterError: a law is for another number of joints.
    """
    by_loop: dict[tuple[Any, ...], tuple[SampledLoop, list[str]]] = {}
    layers: list[tuple[str, SampledLoop]] = []
    for label, law in controllers.items():
        if not all(hasattr(law, name) for name in ("mbar", "ks", "beta")):
            continue
        own = law.period if period is None else period
        timing = {
            "acceleration": getattr(law, "acceleration", "velocity"),
            "filter_hz": getattr(law, "filter_hz", None),
            "delay": delay,
        }
        loop = loop_for(arm, law.mbar, law.ks, law.beta, own, **timing)
        key = (loop.mbar.tobytes(), loop.ks.tobytes(), loop.beta.tobytes(), loop.period, *timing.values())
        by_loop.setdefault(key, (loop, []))[1].append(label)
        slope = getattr(law, "boundary_slope", None)
        if slope is not None:
            layers.append((label, loop_for(arm, law.mbar, law.ks, loop.beta + slope, own, **timing)))
    if not by_loop:
        return []
    friction = None if viscous is None else _counted_on(viscous, arm.nv)
    arms = frozen_arms(arm, box)
    quick = [
        space.thinned(_SAMPLES, _FINEST) for space in spaces_of(arms, samples=_SAMPLES, seed=seed, viscous=friction)
    ]

    def advice(loop: SampledLoop) -> str:
        return remedy_of(arms, loop, seed=seed)

    found = [_about_loop(", ".join(labels), loop, quick, advice) for loop, labels in by_loop.values()]
    found += [_about_layer(label, loop, quick[0]) for label, loop in layers]
    return [warning for warning in found if warning]


def _about_loop(
    labels: str, loop: SampledLoop, spaces: Sequence[Workspace], advice: Callable[[SampledLoop], str]
) -> str:
    for space, at_rest in zip(spaces, (False, True), strict=False):
        radius, point, _ = space.worst(loop)
        if radius < 1.0:
            continue
        where = f"q = {_angles(space.arms.q(point))} rad"
        said = (
            f"{labels}: at rest near {where} gravity drives the sampled loop away from its set-point (spectral radius "
            f"{radius:.4f} at L = {loop.period:g} s)"
            if at_rest
            else f"{labels}: the sampled loop is unstable at {where} (spectral radius {radius:.4f} at "
            f"L = {loop.period:g} s)"
        )
        helps = advice(loop)
        return f"{said}; {helps}" if helps else said
    return ""


def _about_layer(label: str, loop: SampledLoop, free: Workspace) -> str:
    radius, point, _ = free.worst(loop)
    if radius < 1.0:
        return ""
    return (
        f"{label}: inside its boundary layer, where β acts as β + K/Φ = {_angles(loop.beta)}, the sampled loop is "
        f"unstable (spectral radius {radius:.4f} at q = {_angles(free.arms.q(point))} rad), so expect chatter; widen Φ "
        "or lower K"
    )


def _counted_on(viscous: ArrayLike, nv: int) -> Array | None:
    """The least friction of each joint over the trials; None if there is none, so that modes separate."""
    given = np.asarray(viscous, dtype=np.float64)
    least = np.broadcast_to(given, np.broadcast_shapes(given.shape, (1, nv))).min(axis=0)
    return least if least.any() else None


def _angles(q: Array) -> str:
    return "(" + ", ".join(f"{angle:.3g}" for angle in q) + ")"
