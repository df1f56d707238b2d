"""How far gains, period, drive gain and delay can move before the frozen loop is unstable somewhere."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.sampled.linear_map import inertia_ratios, modal_radius, spectral_radius
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace, gravity_stiffness

Family = Callable[[float], SampledLoop]
"""A loop for each value of one parameter."""

DELAY_SPAN = 64.0
"""Extra delay beyond which no margin is sought, periods."""

_PRECISION = 1e-5
_ROUNDS = 4
_WORST = 4
_THIN = 256
_RATIO = 0.35
_MODES = 96


@dataclass(frozen=True)
class LoopLimits:
    """Ends of the stable region in one direction each, the rest as given. inf: no end was found; nan: unstable already.

    A stable range of gains or period starts at slow loops: it is the connected one that a user reaches by raising them.

    Attributes:
        gain_scale: β and K_s may be multiplied by this together; 0 if no gains are stable.
        beta_scale: β alone; the largest β is this times β.
        ks_scale: K_s alone.
        period: Largest L, s, with filter (in Hz) and delay (in periods) as given.
        gain_margin: Factors, below and above 1, by which the drives' true torque may differ from the reported one, on
            all joints together (the same as a factor on M̄, or on M⁻¹).
        delay_margin: Transport delay that may be added, in periods; inf beyond `DELAY_SPAN`.
    """

    gain_scale: float
    beta_scale: float
    ks_scale: float
    period: float
    gain_margin: tuple[float, float]
    delay_margin: float

    @property
    def gain_margin_db(self) -> tuple[float, float]:
        """The gain margin in dB."""
        low, high = (20.0 * math.log10(end) if end != 0.0 else -math.inf for end in self.gain_margin)
        return low, high


def limits_of(workspace: Workspace, loop: SampledLoop, worst_q: Array) -> LoopLimits:
    """All limits of a loop.

    Args:
        workspace: Where the arm works.
        loop: Gains and timing.
        worst_q: Its worst configuration, shape (nv,).
    """
    critical = critical_set(workspace, loop, worst_q)
    rising, outward = gain_grid(loop), grid(1.0, 1e4)
    stable = critical.radius(loop) < 1.0
    low = 1.0 / _end(critical, lambda x: loop.scaled(mbar=1.0 / x), outward) if stable else math.nan
    high = _end(critical, lambda x: loop.scaled(mbar=x), outward) if stable else math.nan
    return LoopLimits(
        gain_scale=_end(critical, lambda x: loop.scaled(ks=x, beta=x), rising),
        beta_scale=_end(critical, lambda x: loop.scaled(beta=x), rising),
        ks_scale=_end(critical, lambda x: loop.scaled(ks=x), rising),
        period=loop.period * _end(critical, lambda x: loop.scaled(period=x), rising),
        gain_margin=(low, high),
        delay_margin=_delay_margin(critical, loop) if stable else math.nan,
    )


class Critical(Protocol):
    """What decides stability over a workspace, reduced to little."""

    def radius(self, loop: SampledLoop) -> float:
        """Largest spectral radius over it."""
        ...

    def extend(self, loop: SampledLoop) -> bool:
        """Search the workspace where `loop` ought to be stable; take in what is not. False if all is."""
        ...


@dataclass(frozen=True)
class Modes:
    """Where modes separate: eigenvalues a of M⁻¹M̄, the extremes found over the workspace and some in between.

    Attributes:
        ratios: Shape (count,), for `mbar`.
        mbar: Shape (nv,), kg·m².
    """

    ratios: Array
    mbar: Array

    def radius(self, loop: SampledLoop) -> float:
        """Largest spectral radius over the modes; M̄ of the loop must be a multiple of `mbar`."""
        return float(modal_radius(self.ratios * (loop.mbar[0] / self.mbar[0]), loop).max())

    def extend(self, loop: SampledLoop) -> bool:
        """Never: the range of a is known already."""
        return False


@dataclass
class Configurations:
    """Elsewhere: the configurations that decide; grows when a search finds a worse one.

    Attributes:
        workspace: Where they are from.
        q: Shape (count, nv), the worst first.
    """

    workspace: Workspace
    q: Array

    def __post_init__(self) -> None:
        """Evaluate the arm there."""
        self._mass = self.workspace.arm.mass_matrix(self.q)
        self._stiffness = gravity_stiffness(self.workspace.arm, self.q) if self.workspace.gravity else None

    def radius(self, loop: SampledLoop) -> float:
        """Largest spectral radius over them; over the first few where a long delay makes the map large."""
        some = slice(None) if loop.delay <= 4.0 else slice(4)
        stiffness = None if self._stiffness is None else self._stiffness[some]
        radii = spectral_radius(self._mass[some], loop, viscous=self.workspace.viscous, stiffness=stiffness)
        return float(radii.max())

    def extend(self, loop: SampledLoop) -> bool:
        """Search the workspace; take in the worst configuration, in front, if it is unstable."""
        if loop.delay > 4.0:
            return False
        radius, q, _ = self.workspace.thinned(_THIN).worst(loop)
        if radius >= 1.0:
            self.q = np.concatenate([q[None], self.q])
            self.__post_init__()
        return radius >= 1.0


def modes_of(workspace: Workspace, mbar: Array, count: int = _MODES) -> Modes:
    """The extreme modes over a workspace, and `count` in between."""
    (low, _), (high, _) = workspace.ratio_range(mbar)
    found = np.sort(inertia_ratios(workspace.mass, mbar), axis=None)
    some = found[np.linspace(0, found.size - 1, min(count, found.size)).astype(np.int64)]
    return Modes(np.concatenate([[low, high], some]), mbar)


def critical_set(workspace: Workspace, loop: SampledLoop, worst_q: Array) -> Critical:
    """What decides about a loop and its like: modes where they separate, else configurations."""
    if loop.modal and workspace.viscous is None and not workspace.gravity:
        return modes_of(workspace, loop.mbar)
    (_, q_low), (_, q_high) = workspace.ratio_range(loop.mbar)
    ranked = [np.argsort(-workspace.radii(loop.scaled(ks=x, beta=x)))[:_WORST] for x in (1.0, 3.0)]
    others = workspace.q[np.unique(np.concatenate(ranked))]
    return Configurations(workspace, np.concatenate([worst_q[None], q_low[None], q_high[None], others]))


def gain_grid(loop: SampledLoop) -> Array:
    """Factors from a loop so slow that only M̄ matters to one so fast that no M̄ is stable."""
    return grid(1e-4 / (loop.period * float(loop.kd.max())), 1e4 / (loop.period * float(loop.kd.min())))


def grid(low: float, high: float) -> Array:
    """Values a third apart, ends included."""
    return np.geomspace(low, high, 2 + int(math.log(high / low) / _RATIO))


def _end(critical: Critical, family: Family, values: Array) -> float:
    """First of ascending values at which the family is unstable somewhere; 0 if at the first, inf if at none.

    Exchange: find the end on what is critical, search the workspace just inside it, take in what is worse, repeat.
    """
    end = first_crossing(lambda x: critical.radius(family(x)), values)
    for _ in range(_ROUNDS):
        inside = end * (1.0 - 20.0 * _PRECISION)
        if not (values[0] < inside < math.inf and critical.extend(family(inside))):
            break
        end = first_crossing(lambda x: critical.radius(family(x)), np.append(values[values < inside], inside))
    return end


def first_crossing(radius: Callable[[float], float], values: Array) -> float:
    """Where `radius` first reaches 1 as its argument runs through ascending values, refined by bisection.

    Returns:
        The value; 0 if the first is unstable already, inf if none is.
    """
    stable = 0.0
    for value in map(float, values):
        if radius(value) >= 1.0:
            if stable == 0.0:
                return 0.0
            unstable = value
            while unstable / stable - 1.0 > _PRECISION:
                middle = math.sqrt(stable * unstable)
                stable, unstable = (stable, middle) if radius(middle) >= 1.0 else (middle, unstable)
            return math.sqrt(stable * unstable)
        stable = value
    return math.inf


def _delay_margin(critical: Critical, loop: SampledLoop) -> float:
    return _end(critical, lambda x: replace(loop, delay=loop.delay + x), grid(0.01, DELAY_SPAN))
