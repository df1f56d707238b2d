"""For which inertias a law's frozen loop is stable: what limits the gains that its card suggests."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.controllers.linear_form import linear_form
from asmc_pin.controllers.ppc import Ppc
from asmc_pin.sampled.linear_map import closed_loop
from asmc_pin.sampled.sampled_loop import SampledLoop

_GRID = np.geomspace(1e-3, 40.0, 400)
_WITHIN = 0.5
_HALVINGS = 30


def stable_ratios(law: Any) -> tuple[float, float] | None:
    """Least and largest a = m̄/m between which a joint under a law, near its set point, is stable; None if it switches.

    The frozen loop of one joint, with an ideal drive and ideal sensors, without gravity: searched on a grid of a from
    0.001 to 40, about a = 0.5, with both ends bisected and rounded inwards. M̄ is suitable for an arm where all
    eigenvalues of its M⁻¹M̄ lie between.

    Args:
        law: With scalar parameters; its K_s, β and period are the loop's.
    """
    if linear_form(law, 1) is None:
        return None
    mbar = np.array(law.mbar, ndmin=1)
    loop = SampledLoop(mbar, law.ks, law.beta, law.period, law=law)

    def stable(ratios: Array) -> BoolArray:
        radii = closed_loop(mbar[0] / np.asarray(ratios)[..., None, None], loop).spectral_radius()
        return np.asarray(radii < 1.0)

    found = stable(_GRID)
    middle = int(np.argmin(np.abs(_GRID - _WITHIN)))
    if not found[middle]:
        return None
    below, above = np.flatnonzero(~found[:middle]), np.flatnonzero(~found[middle:])
    low, high = float(_GRID[0]), float(_GRID[-1])
    if below.size:
        low = _edge(stable, float(_GRID[below[-1] + 1]), float(_GRID[below[-1]]))
    if above.size:
        high = _edge(stable, float(_GRID[middle + above[0] - 1]), float(_GRID[middle + above[0]]))
    return _digits(low, math.ceil), _digits(high, math.floor)


def stable_words(law: Any) -> str:
    """The same in a sentence of a card; of a law that switches it is that of the PPC in it."""
    found, what = stable_ratios(law), ""
    if found is None:
        plain = Ppc(mbar=law.mbar, ks=law.ks, beta=law.beta, period=law.period)
        found, what = stable_ratios(plain), "near its set point it switches; the PPC in it is "
    loop = f"K_s = {float(law.ks):g}, β = {law.beta:g} 1/s, L = {law.period:g} s"
    if found is None:
        return f"nowhere with these values and {loop}"
    between = f"stable for all eigenvalues of M⁻¹M̄ from {found[0]:g} to {found[1]:g}"
    return f"{what}{between}, frozen, with these values and {loop}"


def _edge(stable: Callable[[Array], BoolArray], inside: float, outside: float) -> float:
    for _ in range(_HALVINGS):
        middle = math.sqrt(inside * outside)
        if bool(stable(np.array([middle]))[0]):
            inside = middle
        else:
            outside = middle
    return inside


def _digits(value: float, rounding: Callable[[float], int]) -> float:
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return float(f"{rounding(value / step) * step:.3g}")
