"""How far gains, period, drive gain and delay can move before the frozen loop is unstable somewhere."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.sampled.critical_points import Critical
from asmc_pin.sampled.sampled_loop import SampledLoop

Family = Callable[[float], SampledLoop]
"""A loop for each value of one parameter."""

Ends = tuple[float, float]

DELAY_SPAN = 64.0
"""Extra delay beyond which no margin is sought, periods."""

NOWHERE: Ends = (0.0, 0.0)
"""The range of a family of which no member is stable."""

_PRECISION = 1e-5
_ROUNDS = 5
_RATIO = 0.35
_NO_DELAY, _SHORTEST_DELAY = 1e-9, 0.01
_SPAN = 1e4


@dataclass(frozen=True)
class LoopLimits:
    """Ends of the stable region, each in the direction of one parameter, with the others as given.

    They count the same maps as the verdict: the inertia alone, and the arm at rest under gravity. An upper end is inf
    and a lower end 0 where none was found. A range is the one around the given loop; where that is unstable, the next
    one below, or else above.

    Attributes:
        gain_range: β and K_s together may be multiplied by what lies between; (0, 0) if nothing is stable.
        beta_scale: β alone; the largest β is this times β.
        ks_scale: K_s alone.
        period: Largest L, s, with filter (in Hz) and delay (in periods) as given.
        gain_margin: Factors, below and above 1, by which the drives' true torque may differ from the reported one, on
            all joints together (the same as a factor on M̄); nan if the loop is unstable as it is.
        delay_margin: Transport delay that may be added, in periods; inf beyond `DELAY_SPAN`; nan if unstable.
    """

    gain_range: Ends
    beta_scale: float
    ks_scale: float
    period: float
    gain_margin: Ends
    delay_margin: float

    @property
    def gain_scale(self) -> float:
        """The upper end of `gain_range`."""
        return self.gain_range[1]

    @property
    def gain_margin_db(self) -> Ends:
        """The gain margin in dB."""
        low, high = (20.0 * math.log10(end) if end != 0.0 else -math.inf for end in self.gain_margin)
        return low, high


def margins_and_limits(critical: Critical, loop: SampledLoop) -> LoopLimits:
    """All limits of a loop."""
    slower, faster = _gain_grids(loop)
    # Beyond a second an arm that falls is past all figures.
    longer = grid(1.0, max(1.0 / loop.period, 10.0))
    gain_margin, delay_margin = margins_of(critical, loop)
    return LoopLimits(
        gain_range=gain_range(critical, loop),
        beta_scale=stable_range(critical, lambda x: loop.scaled(beta=x), slower, faster)[1],
        ks_scale=stable_range(critical, lambda x: loop.scaled(ks=x), slower, faster)[1],
        period=loop.period * stable_range(critical, lambda x: loop.scaled(period=x), slower, longer)[1],
        gain_margin=gain_margin,
        delay_margin=delay_margin,
    )


def margins_of(critical: Critical, loop: SampledLoop) -> tuple[Ends, float]:
    """Gain margin and delay margin; nan where the loop is unstable as it is."""
    if critical.radius(loop) >= 1.0:
        return (math.nan, math.nan), math.nan
    gain = stable_range(critical, lambda x: loop.scaled(mbar=x), grid(1.0, 1.0 / _SPAN), grid(1.0, _SPAN))
    later = np.append(_NO_DELAY, grid(_SHORTEST_DELAY, DELAY_SPAN))
    if loop.undamped_delay < DELAY_SPAN:
        # A single value, which bisection would pass over.
        later = np.append(later[later < loop.undamped_delay], loop.undamped_delay)
    low, high = stable_range(critical, lambda x: replace(loop, delay=loop.delay + x), later[:1], later)
    return gain, high if low == 0.0 else 0.0


def gain_range(critical: Critical, loop: SampledLoop) -> Ends:
    """The stable range of factors on β and K_s together; see `LoopLimits`."""
    return stable_range(critical, lambda x: loop.scaled(ks=x, beta=x), *_gain_grids(loop))


def _gain_grids(loop: SampledLoop) -> tuple[Array, Array]:
    """Factors on gains, down to a loop so slow that only M̄ matters, and up to one so fast that none is stable."""
    slowest = float((loop.kp / loop.kd).min())
    down = max(1e-4 / (loop.period * float(loop.kd.max())), 1e-7 / (loop.period * slowest))
    return grid(1.0, min(down, 0.1)), grid(1.0, max(1e4 / (loop.period * float(loop.kd.min())), 10.0))


def grid(begin: float, end: float) -> Array:
    """Values a third apart, ends included, from one to the other."""
    return np.geomspace(begin, end, 2 + int(abs(math.log(end / begin)) / _RATIO))


def stable_range(critical: Critical, family: Family, below: Array, above: Array) -> Ends:
    """The stable values of a family around where its grids begin, or next to it.

    Exchange: find the ends on the points that decide, search just inside them, take in what is worse, repeat.

    Args:
        critical: What decides; grows.
        family: The loops.
        below: Descending values from the one in question; only that one where there is no way down.
        above: Ascending values from it.

    Returns:
        The ends; 0 and inf where the grid ends first, `NOWHERE` if no value is stable.
    """

    def unstable(value: float) -> bool:
        return critical.radius(family(value)) >= 1.0

    for _ in range(_ROUNDS):
        low, high = _around(unstable, below, above)
        inside = [end * (1.0 + way) for end, way in ((low, 20.0 * _PRECISION), (high, -20.0 * _PRECISION))]
        worse = [critical.extend(family(x)) for x in inside if 0.0 < x < math.inf]
        if not any(worse):
            return low, high
    return _around(unstable, below, above)


def _around(unstable: Callable[[float], bool], below: Array, above: Array) -> Ends:
    """The range on the points at hand."""
    if not unstable(float(above[0])):
        return _edge(unstable, below, 0.0), _edge(unstable, above, math.inf)
    for way in (below, above):
        for i in range(1, len(way)):
            if not unstable(float(way[i])):
                near = _bisect(unstable, float(way[i]), float(way[i - 1]))
                far = _edge(unstable, way[i:], 0.0 if way is below else math.inf)
                return (far, near) if way is below else (near, far)
    return NOWHERE


def _edge(unstable: Callable[[float], bool], values: Array, none: float) -> float:
    """Where stability ends on the way through values of which the first is stable; `none` if it does not."""
    stable = float(values[0])
    for value in map(float, values[1:]):
        if unstable(value):
            return _bisect(unstable, stable, value)
        stable = value
    return none


def _bisect(unstable: Callable[[float], bool], stable: float, beyond: float) -> float:
    """The end of stability between two values, on its stable side."""
    while abs(beyond / stable - 1.0) > _PRECISION:
        middle = math.sqrt(stable * beyond)
        stable, beyond = (stable, middle) if unstable(middle) else (middle, beyond)
    return stable
