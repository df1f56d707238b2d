"""The monitors of a run: arrays tick by tick, and a verdict on each claim."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array, BoolArray
from asmc_pin.controllers.law_registry import law_name
from asmc_pin.engine import Rollout
from asmc_pin.errors import ParameterError
from asmc_pin.monitors import claim_verdicts
from asmc_pin.monitors.claim_texts import BAEK, STATEMENTS, Claim, not_applicable
from asmc_pin.monitors.law_signals import Signals, signals_of
from asmc_pin.monitors.lyapunov_monitor import lyapunov_of
from asmc_pin.monitors.source_claims import source_claims
from asmc_pin.monitors.tde_monitor import contraction_of
from asmc_pin.monitors.true_arm import Truth, World


@dataclass(frozen=True, eq=False)
class Monitors:
    """What only the plant knows, along a run; NaN where not defined.

    Attributes:
        time: Shape (T,), s.
        joint_names: Names along the joint axis.
        error: TDE error N, shape (batch, T, nv), rad/s².
        star: Γ* = max |N| of the run, shape (batch, nv), rad/s². Bounds made from it are checks of consistency, no
            predictions.
        norm: Lemma 1's ‖I − M⁻¹M̄‖₂, shape (batch, T).
        growth: ‖N_k‖₂ − ‖N_{k−1}‖₂, shape (batch, T), rad/s².
        carried: ‖(I − M⁻¹M̄) N_{k−1}‖₂/‖N_{k−1}‖₂, shape (batch, T).
        gain: k̂, shape (batch, T, nv), rad/s².
        gain_bound: What k̂ may be by (12) and (16), shape (batch, T, nv), rad/s²; `baek2016` only, as all that follows.
        lyapunov: V of (12), shape (batch, T), rad²/s².
        excess: V̇ + β‖s‖², shape (batch, T), rad²/s³; (16) says at most 0 where `claimed`.
        claimed: Whether (16) speaks of the period: ‖s‖_∞ ≥ ε at both its ends, shape (batch, T), bool.
        s_size: ‖s‖₂, shape (batch, T), rad/s.
        s_bound: Bound (21), shape (batch,), rad/s.
        t_eps: First time with ‖s‖_∞ < ε, shape (batch,), s.
        claims: Every claim on every trial.
        signals: The quantities behind it; None where the law has no M̄.
    """

    time: Array
    joint_names: tuple[str, ...]
    error: Array
    star: Array
    norm: Array
    growth: Array
    carried: Array
    gain: Array
    gain_bound: Array
    lyapunov: Array
    excess: Array
    claimed: BoolArray
    s_size: Array
    s_bound: Array
    t_eps: Array
    claims: tuple[Claim, ...]
    signals: Signals | None

    def claim(self, key: str, trial: int = 0) -> Claim:
        """One claim on one trial; `key` is one of `STATEMENTS`."""
        for item in self.claims:
            if item.key == key and item.trial == trial:
                return item
        raise ParameterError("key", f"'{key}' on trial {trial} given; known are {', '.join(STATEMENTS)}")


def monitor(
    rollout: Rollout,
    arm: World,
    law: Any,
    *,
    effort_limit: ArrayLike | None = None,
    trials: Sequence[int] | None = None,
) -> Monitors:
    """Hold a run against the paper's theorems; recomputed from the rollout alone (docs/monitors.md).

    Args:
        rollout: What happened.
        arm: The plant that it happened on; or its arm, or one per trial, where nothing is picked up or scattered.
        law: The law that ran. N and Lemma 1 need its ``mbar``; Lemma 2, (16) and (21) are about one with `theorem1`.
        effort_limit: Torque limits of the drives, (nv,) or (batch, nv), N·m; the plant's or the arm's when omitted.
        trials: Numbers of the trials, if the rollout was given any.

    Returns:
        Arrays along the run, and a verdict on each claim. A diverged trial is judged up to its end.

    Raises:
        ParameterError: the arm or the law is for another number of joints or trials, or not every tick is logged.
    """
    rollout.need_every_tick("monitors are")
    truth = Truth(rollout, arm, trials, effort_limit)
    batch, ticks, nv = rollout.q.shape
    numbers = range(batch) if trials is None else trials
    mbar = _mbar(law, nv) if getattr(law, "estimates", True) else None
    out: dict[str, Any] = {name: np.full((batch, ticks), np.nan) for name in _PER_TICK}
    out |= {name: np.full((batch, ticks, nv), np.nan) for name in ("error", "gain_bound")}
    out |= {name: np.full(batch, np.nan) for name in ("s_bound", "t_eps")}
    out |= {"star": np.full((batch, nv), np.nan), "claimed": np.zeros((batch, ticks), dtype=np.bool_), "signals": None}
    claims: list[Claim] = []
    # NaN after a divergence is expected; and a run that blows up may overflow before it is stopped.
    with np.errstate(invalid="ignore", over="ignore"):
        if mbar is not None:
            signals = out["signals"] = signals_of(rollout, law, mbar, truth.effort_limit)
            out["error"] = signals.error
            out["star"] = np.fmax.reduce(np.abs(signals.error), axis=1)
        for trial in range(batch):
            found = _trial(trial, rollout, truth, law, mbar, out)
            found += source_claims(trial, rollout, arm, numbers[trial], law, out, truth.effort_limit[trial])
            if rollout.status[trial] != "ok":
                found = [claim.cut_short(float(rollout.end_time[trial])) for claim in found]
            claims += found
    return Monitors(time=rollout.time, joint_names=rollout.joint_names, gain=rollout.gain, claims=tuple(claims), **out)


_PER_TICK = ("norm", "growth", "carried", "lyapunov", "excess", "s_size")


def _mbar(law: Any, nv: int) -> Array | None:
    given = getattr(law, "mbar", None)
    if given is None:
        return None
    mbar = np.asarray(given, dtype=np.float64)
    if mbar.shape not in ((), (nv,)):
        raise ParameterError("law", f"its mbar has {mbar.size} values, the run has {nv} joints")
    return np.broadcast_to(mbar, (nv,)).copy()


def _trial(
    trial: int, rollout: Rollout, truth: Truth, law: Any, mbar: Array | None, out: dict[str, Any]
) -> list[Claim]:
    """The claims on one trial; its arrays go to `out`."""
    if mbar is None:
        reason = f"{law_name(law)} has no M̄, so there is no Γ of (3)"
        if getattr(law, "estimates", True):
            return [not_applicable(key, trial, reason) for key in BAEK]
        reason = f"{law_name(law)} has an estimate of its own in the place of (6), so there is no N"
        return [not_applicable(key, trial, _other_law(law) if item.adaptive else reason) for key, item in BAEK.items()]
    weight = float(getattr(law, "estimate_weight", 1.0))
    found = contraction_of(out["signals"], rollout, truth, mbar, trial, weight)
    for name in ("norm", "growth", "carried"):
        out[name][trial] = getattr(found, name)
    claims = [claim_verdicts.lemma1(trial, rollout.time, found), claim_verdicts.contraction(trial, rollout.time, found)]
    if not getattr(law, "theorem1", False):
        reason = _other_law(law)
        return claims + [not_applicable(key, trial, reason) for key, item in BAEK.items() if item.adaptive]
    if getattr(law, "switching", "explicit") != "explicit":
        reason = "it is proved for k̂ sgn(s), not for its implicit form, which is less than k̂ inside its band"
        return claims + [not_applicable(key, trial, reason) for key, item in BAEK.items() if item.adaptive]
    proof = lyapunov_of(out["signals"], rollout.gain, law, out["star"], trial)
    out["lyapunov"][trial] = proof.value
    for name in ("excess", "s_size", "claimed", "gain_bound", "s_bound"):
        out[name][trial] = getattr(proof, name)
    inside = np.isfinite(proof.value) & ~proof.outside
    if inside.any():
        out["t_eps"][trial] = rollout.time[np.argmax(inside)]
    return claims + claim_verdicts.about_baek2016(trial, rollout.time, rollout.gain[trial], proof, law)


def _other_law(law: Any) -> str:
    return f"it is proved for the adaptive law (11) of baek2016, not for {law_name(law)}"
