"""What the sensors' noise will do to the drives, said before a run, and what filter, bits or period would do."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.sampled.law_loops import LawLoop, law_loops
from asmc_pin.sampled.noise.noise_response import noise_rms
from asmc_pin.sampled.noise.sensor_model import LoopSensor
from asmc_pin.sampled.noise.sensor_noise import LoopNoise, count_formula, loop_noise
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace, workspace_of

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

BUDGET = 0.05
"""Share of a drive's torque limit that noise may take, RMS, before a remedy is named."""

_SAMPLES = 128
_LONGEST = 32.0  # times the period
_LOWEST_HZ = 1.0
_BITS = 32
_STEPS = 24
_LOOKS = 8


@dataclass(frozen=True, eq=False)
class _Arm:
    """One of the arms of a run: when it moves and with which links, where it works, and a loop's noise there."""

    words: str
    space: Workspace
    noise: LoopNoise


def noise_warnings(
    arm: Arm | Mapping[str, Arm],
    controllers: Mapping[str, Any],
    sensor: LoopSensor,
    period: float | None = None,
    *,
    delay: float = 0.0,
    effort_limit: Array,
) -> list[str]:
    """What a count of the encoder is worth, the torque noise to expect, and where it is much what would lower it.

    By the linear map: it holds while no drive is at its limits, and leaves switching terms out, which add to it.

    Args:
        arm: The arm; or every arm that a run has, by words that say when it moves and with which links, of which each
            loop is judged by the noisiest, joint by joint.
        controllers: Label -> law.
        sensor: What the plant's sensors do.
        period: Control period, s; by default each law's own.
        delay: The plant's transport delay, periods.
        effort_limit: Torque limits of the drives, shape (nv,), N·m; inf where there is none.

    Returns:
        One sentence per loop; none where nothing that is reported is off.
    """
    if not sensor.noisy:
        return []
    arms = dict(arm) if isinstance(arm, Mapping) else {"": arm}
    first = next(iter(arms.values()))
    spaces = {
        words: workspace_of(each, samples=_SAMPLES, gravity=bool(np.any(each.gravity_vector)))
        for words, each in arms.items()
    }
    found = []
    for item in law_loops(first, controllers, period, delay=delay, sensor=sensor):
        noises = [
            _Arm(words, space, loop_noise(space, item.loop, sensor, quick=True)) for words, space in spaces.items()
        ]
        found.append(_about(item, noises, effort_limit))
    return found


def _about(item: LawLoop, arms: Sequence[_Arm], limit: Array) -> str:
    loop, parts, noise = item.loop, [], arms[0].noise
    drives = f"on drives of {_numbers(limit)} N·m"
    if noise.count_torque is not None:
        through = "" if noise.share == 1.0 else f" ({100.0 * noise.share:.3g} % of it through the filter at once)"
        parts.append(
            f"one count of the encoder is worth {count_formula(loop)} = {_numbers(noise.count_torque)} N·m{through} "
            f"{drives}"
        )
    each = np.array([one.noise.torque_rms for one in arms])
    if not np.isfinite(each).all():
        unstable = next(one for one in arms if not np.isfinite(one.noise.torque_rms).all())
        where = f" {unstable.words}" if unstable.words else ""
        return f"{item.title}: " + "; ".join([*parts, f"the loop is unstable{where}, so its noise grows without end"])
    rms = each.max(axis=0)
    crossed = " where counts are crossed every period" if noise.count_torque is not None else f" {drives}"
    several = ""
    if len(arms) > 1:
        worst = list(dict.fromkeys(arms[k].words for k in each.argmax(axis=0)))
        several = f", the largest over the {len(arms)} arms of the run ({'; '.join(worst)})"
    parts.append(f"the sensors' noise makes a torque of {_numbers(rms)} N·m RMS{crossed}{several}")
    if (rms > BUDGET * limit).any():
        parts.append(f"for {100.0 * BUDGET:g} % of the drives' limits: {_noise_remedy(loop, arms, limit)}")
    elif noise.count_torque is not None:
        parts.append("a bit more halves what comes of rounding")
    return f"{item.title}: " + "; ".join(parts)


def _noise_remedy(loop: SampledLoop, arms: Sequence[_Arm], limit: Array) -> str:
    """What bits, filter or period, each alone, would bring the torque noise of every arm within `BUDGET` of the limits.

    Args:
        loop: Gains and timing.
        arms: The arms, with the noise of that loop.
        limit: Torque limits, shape (nv,), N·m.
    """
    sensor = arms[0].noise.sensor
    looked = [
        (one.space, *one.space.frozen(np.concatenate([one.noise.worst, one.space.points[:_LOOKS]]))) for one in arms
    ]

    def share(other: SampledLoop, seen: LoopSensor = sensor) -> float:
        """Largest share of a drive's limit that the noise takes."""
        each = (
            noise_rms(mass, other, seen, viscous=space.viscous, stiffness=stiffness)[0]
            for space, mass, stiffness in looked
        )
        return max(float((rms / limit).max()) for rms in each)

    found = []
    if arms[0].noise.count_torque is not None:
        finer = (replace(sensor, count=sensor.count / 2.0**n) for n in range(1, _BITS))
        bits = next((n for n, better in enumerate(finer, start=1) if share(loop, better) <= BUDGET), None)
        found.append(f"{bits} bits more" if bits is not None else "no number of bits alone")
    corners = [_two_digits(x) for x in np.geomspace(0.25 / loop.period, _LOWEST_HZ, _STEPS)]
    filters = ((f"filter_hz = {x:g}", replace(loop, filter_hz=x)) for x in corners)
    periods = loop.period * np.geomspace(1.0, _LONGEST, _STEPS)[1:]
    longer = ((f"L = {1e3 * x:.3g} ms", replace(loop, period=float(x))) for x in periods)
    found += [_first_or_best(filters, share, "filter_hz"), _first_or_best(longer, share, "a longer L")]
    return ", or ".join(found)


def _first_or_best(changed: Iterable[tuple[str, SampledLoop]], share: Callable[[SampledLoop], float], name: str) -> str:
    """The first change that is enough, or how far the best of them gets."""
    best, said = math.inf, ""
    for words, loop in changed:
        reached = share(loop)
        if reached <= BUDGET:
            return words
        if reached < best:
            best, said = reached, words
    return f"{said}, which alone gets to {100.0 * best:.2g} %" if said else f"no {name}, which makes the loop unstable"


def _two_digits(value: float) -> float:
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.floor(value / step) * step


def _numbers(values: Array) -> str:
    return "(" + ", ".join(f"{value:.4g}" if math.isfinite(value) else "no limit" for value in values) + ")"
