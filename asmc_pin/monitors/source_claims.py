"""What the sources of other laws claim, held against a run: the law says what, here is judged why it broke."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.controllers.law_registry import law_name
from asmc_pin.controllers.promises.run_history import Findings, History
from asmc_pin.engine import Rollout
from asmc_pin.monitors.claim_texts import CAUSES, STATEMENTS, Claim, judge, not_applicable
from asmc_pin.monitors.law_signals import DRIVE, NOISE, SATURATION
from asmc_pin.monitors.lyapunov_monitor import SAMPLING
from asmc_pin.monitors.run_again import tried_again
from asmc_pin.monitors.true_arm import World
from asmc_pin.plant import Plant

_AT_LIMIT = 1.0 - 1e-9


def source_claims(
    trial: int, rollout: Rollout, world: World, number: int, law: Any, found: Mapping[str, Array], effort_limit: Array
) -> list[Claim]:
    """The claims that are not those of Baek (2016), on one trial.

    Args:
        trial: Which.
        rollout: What happened.
        world: On what; a claim that broke in the first trial is tried again where it is the plant itself.
        number: The trial's number in its study.
        law: The law that ran; what its source claims is what its `promises` say.
        found: The TDE error N, (batch, T, nv), rad/s², by "error", and Lemma 1's norm, (batch, T), by "norm"; NaN where
            it has none.
        effort_limit: Torque limits, shape (nv,), N·m.
    """
    promised = law.promises() if hasattr(law, "promises") else {}
    at_limit = (np.abs(rollout.torque[trial]) >= _AT_LIMIT * effort_limit).any(axis=1)
    claims = []
    for key, item in STATEMENTS.items():
        if not item.sources:
            continue
        promise = promised.get(key, f"it is claimed of {item.sources}, not of {law_name(law)}")
        if isinstance(promise, str):
            claims.append(not_applicable(key, trial, promise))
            continue
        seen = promise.findings(_history(trial, rollout, law))
        causes = _causes(seen, found["error"][trial], found["norm"][trial], at_limit, rollout)
        again = ""
        broken = seen.checked & (seen.excess > 0.0)
        # A drive's limits and sensors stay what they are, however fast it is sampled.
        if trial == 0 and isinstance(world, Plant) and (causes[broken] == CAUSES.index(SAMPLING)).any():
            again = tried_again(rollout, trial, number, world, law, promise.levers, partial(_kept, key))
        text = "; ".join(part for part in (seen.seen, again) if part)
        claims.append(
            judge(key, trial, rollout.time, seen.excess, seen.checked, causes, seen.seen, seen.untested, text)
        )
    return claims


def _kept(key: str, run: Rollout, law: Any) -> bool:
    """Whether a claim holds in the only trial of a run."""
    seen = law.promises()[key].findings(_history(0, run, law))
    return bool(seen.checked.any() and not (seen.checked & (seen.excess > 0.0)).any())


def _history(trial: int, rollout: Rollout, law: Any) -> History:
    error, rate = rollout.q_ref - rollout.q[trial], rollout.v_ref - rollout.v[trial]
    bend = np.full_like(rate, np.nan)
    bend[:-1] = rollout.a_ref[:-1] - np.diff(rollout.v[trial], axis=0) / rollout.period
    return History(rollout.time, error, rate, bend, rate + law.ks * error, rollout.gain[trial])


def _causes(found: Findings, error: Array, norm: Array, at_limit: BoolArray, run: Rollout) -> IntArray:
    """Index in `CAUSES` at each tick, −1 where Lemma 1's condition is broken: then N grows however fast it is sampled.

    What a law is pushed by is the TDE error N and the rest, by which its torque is not what it asked for. Where N is
    the larger part since the claim was last kept, sampling is named: N is what sampling leaves of the load. Else a
    limit that was reached, else the sensors if they are not ideal, else the drive.
    """
    own = np.diff(error, axis=0, prepend=np.nan) / run.period if found.of_rate else error
    rest = np.abs(np.nan_to_num(found.push - own)).sum(axis=1)
    sampled = np.abs(np.nan_to_num(own)).sum(axis=1)
    over = found.checked & (found.excess > 0.0)
    causes = np.full(len(over), CAUSES.index(SAMPLING))
    begin = 0
    for k in range(len(over)):
        if not over[k]:
            begin = k
            continue
        window = slice(begin, k)
        if (norm[window] >= 1.0).any():
            causes[k] = -1
        elif rest[window].sum() > sampled[window].sum():
            named = SATURATION if at_limit[window].any() else DRIVE if run.ideal_sensor else NOISE
            causes[k] = CAUSES.index(named)
    return causes
