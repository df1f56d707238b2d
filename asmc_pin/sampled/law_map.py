"""The sampled closed loop of any law that is linear, frozen at a configuration, as a linear map from tick to tick.

The law is its own `LinearForm`; the arm, drive and sensor are those of `linear_map`, and so is what the states mean.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.linear_form import LinearForm
from asmc_pin.sampled.transition import Transition

if TYPE_CHECKING:
    from asmc_pin.sampled.sampled_loop import SampledLoop

ERRORS = ("angle", "rate", "report")


def law_loop_rows(
    step: Transition, loop: SampledLoop, form: LinearForm, batch: tuple[int, ...], sensed: bool
) -> tuple[dict[str, Array], dict[str, slice], dict[str, slice], Array]:
    """The next state as rows over the present one and the inputs; with where each lies, and the command.

    Args:
        step: The arm over one period.
        loop: Timing and sensor.
        form: The law, in torques.
        batch: Leading axes of the mass matrices.
        sensed: Whether errors of the readings are inputs.

    Returns:
        Rows (..., nv, columns) by the name of the state; the columns of each state and of each input; M̄⁻¹τ, likewise.
    """
    n, whole = loop.nv, math.floor(loop.delay)
    fraction = loop.delay - whole
    names = _state_names(loop, form, sensed)
    inputs = ("load", "extra", *(ERRORS if sensed else ()))
    width = n * (len(names) + len(inputs))

    def signal(place: int) -> Array:
        rows = np.zeros((n, width))
        rows[:, place * n : (place + 1) * n] = np.eye(n)
        return np.broadcast_to(rows, (*batch, n, width))

    now = {name: signal(i) for i, name in enumerate(names)}
    come = {name: signal(len(names) + i) for i, name in enumerate(inputs)}
    angle, rate = now.get("angle", now["q"]), now.get("rate", now["v"])
    # The form is in torques, the rows are in units of acceleration, M̄⁻¹τ.
    readings = (angle, rate, loop.mbar[:, None] * now["report"])
    memory = [now[f"law-{i}"] for i in range(form.out.shape[1])]
    torque = _weighed(form.direct, readings) + _weighed(form.out, memory)
    drive = torque / loop.mbar[:, None]
    commands = [drive + come["extra"]] + [now[name] for name in names if name.startswith("command-")]
    recent = commands[whole]
    older = commands[whole + 1] if fraction else recent
    state = np.concatenate([now["q"], now["v"]], axis=-2)
    moved = step.state @ state + step.recent @ recent + step.older @ older - step.load @ come["load"]
    nxt = {"q": moved[..., :n, :], "v": moved[..., n:, :]}
    nxt |= dict(zip((name for name in names if name.startswith("command-")), commands, strict=False))
    for name in (name for name in names if name[:2] in ("q-", "v-")):
        age = int(name[2:])
        nxt[name] = now[name[0] if age == 1 else f"{name[0]}-{age - 1}"]
    for i in range(len(memory)):
        nxt[f"law-{i}"] = _weighed(form.readings[:, i], readings) + _weighed(form.memory[:, i], memory)
    read, speed = readings_of(loop, nxt)
    report = (1.0 - fraction) * recent + fraction * older
    if sensed:
        read, speed, report = read + come["angle"], speed + come["rate"], report + come["report"]
    if loop.velocity == "difference":
        speed = rate + loop.velocity_smoothing * ((read - angle) / loop.period - rate)
    nxt |= {"angle": read, "rate": speed, "report": report}
    places = {name: slice(i * n, (i + 1) * n) for i, name in enumerate((*names, *inputs))}
    return {name: nxt[name] for name in names}, places, {name: places[name] for name in inputs}, drive


def readings_of(loop: SampledLoop, nxt: dict[str, Array]) -> tuple[Array, Array]:
    """Angle and velocity `reading_delay` periods ago, as the plant's sensors have them.

    Between two ticks by the cubic through both angles and velocities there.
    """
    whole = math.floor(loop.reading_delay)
    rest = loop.reading_delay - whole
    q1, v1 = (nxt[name if whole == 0 else f"{name}-{whole}"] for name in "qv")
    if not rest:
        return q1, v1
    q0, v0 = (nxt[f"{name}-{whole + 1}"] for name in "qv")
    x = 1.0 - rest
    angle = rest**2 * (1.0 + 2.0 * x) * q0 + x**2 * (1.0 + 2.0 * rest) * q1
    return angle + loop.period * x * rest * (rest * v0 - x * v1), rest * v0 + x * v1


def _state_names(loop: SampledLoop, form: LinearForm, sensed: bool) -> list[str]:
    apart = sensed or loop.reading_delay > 0.0 or loop.velocity == "difference"
    names = ["q", "v", "report"]
    names += ["angle", "rate"] if apart else []
    names += [f"law-{i}" for i in range(form.out.shape[1])]
    names += [f"command-{i}" for i in range(1, math.ceil(loop.delay) + 1)]
    return names + [f"{of}-{i}" for i in range(1, math.ceil(loop.reading_delay) + 1) for of in "qv"]


def _weighed(weights: Array, signals: tuple[Array, ...] | list[Array]) -> Array:
    """Sum of signals, (..., nv, columns) each, with weights (nv, signals)."""
    parts = [weights[:, i, None] * signal for i, signal in enumerate(signals)]
    return np.asarray(sum(parts, start=np.zeros(1)))
