"""The curves of a run as a page takes them: of every few ticks the lowest and the highest, in half precision."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from asmc_pin._typing import Array, IntArray

WINDOWS = 400
"""Into how many windows a run is cut; of each the lowest and the highest value are kept."""

_DEGREES = 180.0 / np.pi


class Signal(NamedTuple):
    """One quantity of every controller and joint.

    Attributes:
        key: Its name in the page.
        title: What a person reads.
        units: Of each joint.
        values: Shape (controllers, T, nv), in those units; NaN where there is none.
        low: Lower end of the band of all trials, the same shape; None without.
        high: Its upper end.
    """

    key: str
    title: str
    units: list[str]
    values: Array
    low: Array | None = None
    high: Array | None = None


def signals_of(dataset: xr.Dataset, monitors: xr.Dataset | None, ended: bool = True) -> Iterator[Signal]:
    """The quantities of the first trial, with the bands of all where the result has them.

    Args:
        dataset: See `asmc_pin.results.result_folder.Result`.
        monitors: What only the plant knows, among it the TDE error; None without.
        ended: Whether their last tick is that of the run, whose torque acts in no period any more.
    """
    run = dataset.isel(trial=0)
    slides = run.joint_kind.to_numpy() == "prismatic"
    metre = ["m" if each else "rad" for each in slides]
    angle = np.where(slides, 1e3, _DEGREES)

    def signal(key: str, title: str, units: list[str], values: Array, factor: Array | float = 1.0) -> Signal:
        ends = [
            factor * dataset[f"{key}_{end}"].transpose("controller", "time", "joint").to_numpy()
            if f"{key}_{end}" in dataset
            else None
            for end in ("low", "high")
        ]
        return Signal(key, title, units, factor * values, *ends)

    def of(name: str) -> Array:
        return np.asarray(run[name].transpose("controller", "time", "joint").to_numpy(), dtype=np.float64)

    force = ["N" if each else "N·m" for each in slides]
    yield signal(
        "error", "Tracking error e", ["mm" if each else "deg" for each in slides], run.q_ref.to_numpy() - of("q"), angle
    )
    yield signal("s", "Sliding variable s", [f"{each}/s" for each in metre], of("s"))
    torque = of("torque")
    if ended:
        torque[:, -1] = np.nan
    yield signal("torque", "Torque τ", force, torque)
    yield signal("gain", "Switching gain k̂", [f"{each}/s²" for each in metre], of("gain"))
    yield signal("friction_torque", "Friction torque", force, of("friction_torque"))
    if monitors is not None:
        error = monitors.tde_error.isel(trial=0).transpose("controller", "time", "joint").to_numpy()
        if error.shape == torque.shape:
            yield signal("tde_error", "TDE error N", [f"{each}/s²" for each in metre], error)


def window_edges(ticks: int) -> IntArray:
    """Where the windows begin and end, as indices of ticks; shape (windows + 1,)."""
    return np.unique(np.linspace(0, ticks, min(WINDOWS, ticks) + 1).astype(int))


def extremes(values: Array, edges: IntArray) -> Array:
    """Lowest and highest value of each window, in the order in which they come; shape (2 windows,), NaN in a gap.

    Args:
        values: Shape (T,).
        edges: See `window_edges`.
    """
    low, high = np.fmin.reduceat(values, edges[:-1]), np.fmax.reduceat(values, edges[:-1])
    pairs = np.stack([low, high], axis=1)
    for k, (begin, end) in enumerate(pairwise(edges)):
        part = values[begin:end]
        if np.isfinite(pairs[k]).all() and np.nanargmax(part) < np.nanargmin(part):
            pairs[k] = high[k], low[k]
    return pairs.ravel()


def described(dataset: xr.Dataset, monitors: xr.Dataset | None, ended: bool = True) -> dict[str, Any]:
    """All curves, ready for JSON: see ``static/signals.js`` for how they are read, and `signals_of` for arguments."""
    time = dataset.time.to_numpy()
    edges = window_edges(len(time))
    begin, end = time[edges[:-1]], time[edges[1:] - 1]
    points = np.stack([begin + 0.25 * (end - begin), begin + 0.75 * (end - begin)], axis=1).ravel()
    told = []
    for signal in signals_of(dataset, monitors, ended):
        if not np.isfinite(signal.values).any():
            continue
        joints = range(signal.values.shape[2])
        told.append(
            {
                "key": signal.key,
                "title": signal.title,
                "units": signal.units,
                "curves": [[_packed(extremes(one[:, j], edges)) for j in joints] for one in signal.values],
                "bands": _bands(signal, edges),
                "words": [_words(one, time) for one in signal.values],
            }
        )
    return {"points": [round(float(t), 6) for t in points], "every": int(np.max(np.diff(edges))), "signals": told}


def _bands(signal: Signal, edges: IntArray) -> list[list[list[dict[str, Any] | None]]] | None:
    """Lower and upper ends of every controller and joint; None where no trial differs, or there are no others."""
    if signal.low is None or signal.high is None:
        return None
    starts = edges[:-1]
    return [
        [
            [_packed(np.fmin.reduceat(low[:, j], starts)), _packed(np.fmax.reduceat(high[:, j], starts))]
            for j in range(low.shape[1])
        ]
        for low, high in zip(signal.low, signal.high, strict=True)
    ]


def _packed(values: Array) -> dict[str, Any] | None:
    """Half precision of the values over the largest, which keeps three digits over nine decades; None without any."""
    largest = float(np.max(np.abs(values), initial=0.0, where=np.isfinite(values)))
    if not np.isfinite(values).any():
        return None
    scaled = values / largest * 1024.0 if largest > 0.0 else values
    data = base64.b64encode(scaled.astype("<f2").tobytes()).decode()
    return {"scale": largest / 1024.0 if largest > 0.0 else 1.0, "data": data}


def _words(values: Array, time: Array) -> list[list[float] | None]:
    """Largest size of each joint and when, for who hears a figure; None where there is none."""
    size = np.abs(values)
    found: list[list[float] | None] = []
    for j in range(size.shape[1]):
        if not np.isfinite(size[:, j]).any():
            found.append(None)
            continue
        k = int(np.nanargmax(size[:, j]))
        found.append([float(f"{size[k, j]:.3g}"), round(float(time[k]), 3)])
    return found
