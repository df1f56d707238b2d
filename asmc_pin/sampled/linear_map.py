"""The sampled closed loop of PPC (7), frozen at a configuration, as a linear map from tick to tick.

Everything is written with the command in units of acceleration, u = M̄⁻¹τ, so that the arm enters through M⁻¹M̄ alone
(and through M⁻¹ times viscous friction and gravity's stiffness, where asked for). Derived in docs/stability.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.errors import NotPositiveDefinite, ParameterError
from asmc_pin.sampled.law_map import ERRORS, law_loop_rows, readings_of
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.transition import Transition, transition


@dataclass(frozen=True)
class ClosedLoop:
    """The map z_{k+1} = F z_k + E h_k + B w_k + S n_{k+1} of the frozen loop around a set point.

    Attributes:
        matrix: F, shape (..., N, N).
        load: E, shape (..., N, nv): response to a load torque h (N·m, resisting: M q̈ = τ − h) held over one period.
        command: B, shape (..., N, nv): response to an addition w (rad/s²) to the commanded acceleration M̄⁻¹τ_k.
        blocks: Where each part of z lies. "q" and "v" are the deviation from the set point (−e, −ė); "tde" is the term
            M̄⁻¹τ(t−L) − q̈(t−L) that the controller adds; the rest is memory of readings, estimate, filters and delay.
        sensed: S by what is added to: the "angle" read (rad), the "rate" where it is measured (rad/s), and the "report"
            of the torque (as acceleration, rad/s²); each of shape (..., N, nv). Empty unless asked for.
        drive: U with M̄⁻¹τ_k = U z_k (w_k apart), the command as acceleration, shape (..., nv, N).
    """

    matrix: Array
    load: Array
    command: Array
    blocks: dict[str, slice]
    sensed: dict[str, Array]
    drive: Array

    def spectral_radius(self) -> Array:
        """Largest modulus of F's eigenvalues, shape (...). Below 1 the frozen loop is asymptotically stable."""
        return np.asarray(np.abs(np.linalg.eigvals(self.matrix)).max(axis=-1), dtype=np.float64)


def closed_loop(
    mass: Array,
    loop: SampledLoop,
    *,
    viscous: ArrayLike | None = None,
    stiffness: Array | None = None,
    substeps: int | None = None,
    sensed: bool = False,
) -> ClosedLoop:
    """The linear map of the sampled loop (7) with M(q) held constant.

    Args:
        mass: Inertia M(q), symmetric positive definite, shape (..., nv, nv), kg·m².
        loop: Gains and timing.
        viscous: Viscous friction, shape (nv,), N·m·s/rad; none by default.
        stiffness: ∂g/∂q there, shape (..., nv, nv), N·m/rad, for the linearisation about rest; none by default.
        substeps: None: the exact solution under held torque. A number: as many steps of the plant's own scheme, which
            differs from it only where there is friction, stiffness, or a delay that ends within a step.
        sensed: Whether to work out what errors of the readings do, which takes a few more states.

    Returns:
        The map. State order: q, v, tde, then as needed angle and rate (what is read of them), slope (position
        estimate), acceleration (filter), report (the last torque reported), command-1, command-2, … (delay), q-1, v-1,
        … (age of the readings).
    """
    if loop.law is not None:
        return _loop_of_law(mass, loop, viscous=viscous, stiffness=stiffness, substeps=substeps, sensed=sensed)
    n, whole = loop.nv, math.floor(loop.delay)
    fraction = loop.delay - whole
    names = _state_names(loop, sensed)
    blocks = {name: slice(i * n, (i + 1) * n) for i, name in enumerate(names)}
    size = n * len(names)
    inputs = ("load", "extra", *(ERRORS if sensed else ()))
    batch = np.shape(mass)[:-2]

    def signal(columns: slice) -> Array:
        rows = np.zeros((n, size + len(inputs) * n))
        rows[:, columns] = np.eye(n)
        return np.broadcast_to(rows, (*batch, n, size + len(inputs) * n))

    columns = {name: slice(size + i * n, size + (i + 1) * n) for i, name in enumerate(inputs)}
    now = {name: signal(where) for name, where in blocks.items()}
    come = {name: signal(where) for name, where in columns.items()}
    step = transition(
        mass, loop.mbar, loop.period, fraction=fraction, viscous=viscous, stiffness=stiffness, substeps=substeps
    )

    # The controller, (7) with q_d = 0: e = −q, ė = −v, as they are read.
    angle, rate = (now.get(seen, now[true]) for seen, true in (("angle", "q"), ("rate", "v")))
    drive = now["tde"] - loop.kd[:, None] * rate - loop.kp[:, None] * angle
    commands = [drive + come["extra"]] + [now[name] for name in names if name.startswith("command-")]
    recent = commands[whole]
    older = commands[whole + 1] if fraction else recent
    nxt = _advance(step, now, recent, older, come["load"])
    for name, value in zip((name for name in names if name.startswith("command-")), commands, strict=False):
        nxt[name] = value
    for name in (name for name in names if name[:2] in ("q-", "v-")):
        age = int(name[2:])
        nxt[name] = now[name[0] if age == 1 else f"{name[0]}-{age - 1}"]

    # What the drive reports, and the estimate of the acceleration that goes with it.
    reported = (1.0 - fraction) * recent + fraction * older
    read, speed = readings_of(loop, nxt)
    if sensed:
        read, speed, reported = read + come["angle"], speed + come["rate"], reported + come["report"]
    difference = (read - angle) / loop.period
    if loop.velocity == "difference":
        speed = rate + loop.velocity_smoothing * (difference - rate)
    if loop.acceleration == "velocity":
        estimate = (speed - rate) / loop.period
    elif "slope" in blocks:
        estimate = (difference - now["slope"]) / loop.period
        nxt["slope"] = difference
    else:
        estimate = (difference - rate) / loop.period
    if loop.filter_hz is not None:
        estimate = now["acceleration"] + loop.smoothing * (estimate - now["acceleration"])
        nxt["acceleration"] = estimate
    paired = reported
    if loop.averages_torque:
        paired = 0.5 * (reported + now["report"])
    nxt |= {"angle": read, "rate": speed, "report": reported, "tde": paired - estimate}
    rows = np.concatenate([nxt[name] for name in names], axis=-2)
    found = {name: rows[..., where] for name, where in columns.items()}
    return ClosedLoop(
        rows[..., :size], found.pop("load"), found.pop("extra"), blocks, found, np.asarray(drive[..., :size])
    )


def _loop_of_law(
    mass: Array,
    loop: SampledLoop,
    *,
    viscous: ArrayLike | None,
    stiffness: Array | None,
    substeps: int | None,
    sensed: bool,
) -> ClosedLoop:
    """The map with a law other than PPC; see `law_map`. Its states are q, v, report and then the law's memory."""
    step = transition(
        mass,
        loop.mbar,
        loop.period,
        fraction=loop.delay % 1.0,
        viscous=viscous,
        stiffness=stiffness,
        substeps=substeps,
    )
    nxt, places, inputs, drive = law_loop_rows(step, loop, loop.form, np.shape(mass)[:-2], sensed)
    rows = np.concatenate(list(nxt.values()), axis=-2)
    size = rows.shape[-2]
    found = {name: rows[..., where] for name, where in inputs.items()}
    blocks = {name: places[name] for name in nxt}
    return ClosedLoop(
        rows[..., :size], found.pop("load"), found.pop("extra"), blocks, found, np.asarray(drive[..., :size])
    )


def _state_names(loop: SampledLoop, sensed: bool) -> list[str]:
    """What the state is made of: readings are states where they are not those of the true q and v."""
    apart = sensed or loop.reading_delay > 0.0
    names = ["q", "v", "tde"]
    names += ["angle"] if apart else []
    names += ["rate"] if apart or loop.velocity == "difference" else []
    same = loop.velocity == "difference" and loop.velocity_filter_hz is None  # the rate is the slope
    names += ["slope"] if loop.acceleration == "position" and not same else []
    names += ["acceleration"] if loop.filter_hz is not None else []
    names += ["report"] if loop.averages_torque else []
    names += [f"command-{i}" for i in range(1, math.ceil(loop.delay) + 1)]
    return names + [f"{of}-{i}" for i in range(1, math.ceil(loop.reading_delay) + 1) for of in "qv"]


def _advance(step: Transition, now: dict[str, Array], recent: Array, older: Array, load: Array) -> dict[str, Array]:
    """Angles and velocities one period on, as rows over the state and the load."""
    n = now["q"].shape[-2]
    state = np.concatenate([now["q"], now["v"]], axis=-2)
    rows = step.state @ state + step.recent @ recent + step.older @ older - step.load @ load
    return {"q": rows[..., :n, :], "v": rows[..., n:, :]}


def inertia_ratios(mass: Array, mbar: Array) -> Array:
    """Eigenvalues a of M⁻¹M̄, ascending, shape (..., nv), dimensionless and positive.

    Raises:
        NotPositiveDefinite: carries the index of the first such matrix and its smallest eigenvalue.
    """
    root = np.sqrt(mbar)
    ratio = np.linalg.eigvalsh(mass / (root[:, None] * root))
    if not (ratio[..., 0] > 0.0).all():
        index = tuple(int(i) for i in np.argwhere(~(ratio[..., 0] > 0.0))[0])
        raise NotPositiveDefinite(index, float(np.linalg.eigvalsh(mass[index])[0]))
    return np.asarray((1.0 / ratio)[..., ::-1], dtype=np.float64)


def spectral_radius(
    mass: Array, loop: SampledLoop, *, viscous: ArrayLike | None = None, stiffness: Array | None = None
) -> Array:
    """Spectral radius of the frozen loop, shape (...).

    Where an alternating torque goes on for ever (`SampledLoop.undamped_delay`) it is at least 1, and not what rounding
    makes of a pole at −1; viscous friction may damp it. Takes one mode at a time where that is exact (K_s and β
    multiples of the identity, neither viscous friction nor stiffness); the two ways give the same figure.

    Raises:
        NotPositiveDefinite: a matrix of `mass` is not positive definite.
    """
    ratios = inertia_ratios(mass, loop.mbar)
    if loop.modal and viscous is None and stiffness is None:
        return np.asarray(modal_radius(ratios, loop).max(axis=-1))
    radius = closed_loop(mass, loop, viscous=viscous, stiffness=stiffness).spectral_radius()
    return radius if viscous is not None else _undamped(radius, loop)


def modal_radius(ratios: Array, loop: SampledLoop) -> Array:
    """Spectral radius of single modes with eigenvalues a of M⁻¹M̄, the shape of `ratios`; `loop` needs K_s = k_s I."""
    if not loop.modal:
        raise ParameterError("ks", "modes separate only when every joint has the same k_s and β; use spectral_radius")
    return _undamped(closed_loop(1.0 / ratios[..., None, None], loop.mode).spectral_radius(), loop)


def _undamped(radius: Array, loop: SampledLoop) -> Array:
    return np.maximum(radius, 1.0) if loop.undamped_delay == 0.0 else radius
