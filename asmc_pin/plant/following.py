"""A law and a plant that is under way, from the first tick to the last: in compiled code, or by Pinocchio."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array, IntArray
from asmc_pin.controllers.one_trial.compiled_law import CompiledLaw
from asmc_pin.controllers.one_trial.state_rows import as_rows, row_of
from asmc_pin.controllers.protocol import Controller, Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.plant.compiled_run.asked_run import AskedRun
from asmc_pin.plant.compiled_run.run_state import CompiledRun
from asmc_pin.plant.joint_reach import all_reached, no_reach
from asmc_pin.plant.plant_state import Motion
from asmc_pin.plant.run_recorder import CHUNK, MEASURED, TRUTH, Recorder, first_logged

Progress = Callable[[int, int], None]

# Joints times trials times ticks that compiled code runs before it comes back, some tens of milliseconds, for the sake
# of Ctrl-C and of whoever watches. With a quarter of them a batch of 1,024 took a third longer: a trial's numbers and
# the ends of its histories had left the cache when it was its turn again.
JOINT_TICKS = 400_000


class Followed(NamedTuple):
    """What is left of trials that ran.

    Attributes:
        histories: By the names that a `Rollout` gives them, (batch, logged ticks, nv) each and read-only.
        stopped_at: Tick at which each trial stopped, (batch,); the number of ticks where it did not.
        reach: How far the joints came at any tick, see `asmc_pin.plant.joint_reach`.
    """

    histories: dict[str, Array]
    stopped_at: IntArray
    reach: Array


def follow_compiled(
    controller: Controller, motion: Motion, wanted: Setpoint, log_every: int, progress: Progress | None
) -> Followed:
    """Run a law in compiled code; a law in numpy is asked tick by tick.

    Args:
        controller: The law.
        motion: The trials as they begin; they do not move themselves, see `CompiledRun`.
        wanted: The reference, fields of shape (T, nv).
        log_every: One tick in how many is logged, from the first on.
        progress: Called now and then with the ticks done and their total.
    """
    ticks, nv = wanted.q.shape
    batch, logged = len(motion.q), len(range(0, ticks, log_every))
    ks = _ks_of(controller, nv)
    step = controller.trial_step if isinstance(controller, CompiledLaw) else None
    names = [*_names(motion), *([] if ks is None else ["s"]), "gain"]
    # One block of memory: arrays of their own were up to a tenth slower, the more of them there are.
    histories = dict(zip(names, np.empty((len(names), batch, logged, nv)), strict=True))
    made = motion, wanted, histories, log_every
    run = CompiledRun(*made) if step is not None else AskedRun(*made, ks)
    state = controller.init(run.sample())
    if not hasattr(state, "gain"):
        del histories["gain"]
    if isinstance(run, AskedRun):
        k = _ask_tick_by_tick(controller, state, run, wanted, progress)
    elif step is not None and isinstance(controller, CompiledLaw):
        _, memory = as_rows(state, (batch, nv))
        law, gain = controller.law_rows(nv), row_of(state, "gain")
        chunk = max(1, JOINT_TICKS // (batch * nv))
        k = 0
        while k < ticks and run.active.any():
            k = run.follow_law(step.address, law, memory, gain, ks, k, min(k + chunk, ticks))
            if progress is not None:
                progress(k, ticks)
    if progress is not None and k < ticks:
        progress(ticks, ticks)
    absent = np.broadcast_to(np.nan, (batch, logged, nv))
    for history in histories.values():
        history.setflags(write=False)
    return Followed({"s": absent, "gain": absent, **histories}, run.stopped_at, run.reach)


def _ask_tick_by_tick(
    controller: Controller, state: Any, run: AskedRun, wanted: Setpoint, progress: Progress | None
) -> int:
    """Ask a law that has its step in numpy at every tick; the tick that comes next."""
    ticks, nv = wanted.q.shape
    batch = len(run.active)
    q_ref, v_ref, a_ref = (np.broadcast_to(x[:, None], (ticks, batch, nv)) for x in (wanted.q, wanted.v, wanted.a))
    logs_gain, step, follow, sample = hasattr(state, "gain"), controller.step, run.follow_command, run.sample
    k = 0
    while k < ticks and run.running:
        command, state = step(state, sample(), Setpoint(q_ref[k], v_ref[k], a_ref[k]))
        follow(_torque_of(controller, command, batch, nv), state.gain if logs_gain else None)
        k += 1
        if progress is not None and (k % CHUNK == 0 or k == ticks):
            progress(k, ticks)
    run.finish()
    return k


def follow_by_pinocchio(
    controller: Controller, motion: Motion, wanted: Setpoint, log_every: int, progress: Progress | None
) -> Followed:
    """Run a law on dynamics by Pinocchio, all trials tick by tick; see `follow_compiled`."""
    ticks, nv = wanted.q.shape
    batch = len(motion.q)
    q_ref, v_ref, a_ref = (np.broadcast_to(x[:, None], (ticks, batch, nv)) for x in (wanted.q, wanted.v, wanted.a))
    stopped_at = np.full(batch, ticks)
    state = controller.init(motion.sample())
    names = _names(motion) + (["gain"] if hasattr(state, "gain") else [])
    logged = Setpoint(*(x[::log_every] for x in (wanted.q, wanted.v, wanted.a)))
    recorder = Recorder(logged, batch, _ks_of(controller, nv), names)
    reach = no_reach(motion.plant, batch)
    k = 0
    while k < ticks and motion.active.any():
        stopped = motion.stop_diverged(wanted.q[k])
        sample = motion.sample()
        command, state = controller.step(state, sample, Setpoint(q_ref[k], v_ref[k], a_ref[k]))
        stopped |= motion.apply(_torque_of(controller, command, batch, nv))
        if stopped:
            stopped_at[~motion.active & (stopped_at == ticks)] = k
        q, v = motion.q, motion.v
        all_reached(reach, np.ascontiguousarray(q), k, motion.active)
        friction = motion.advance()
        if k % log_every == 0:
            values = [q, v, motion.torque, friction]
            values += [] if motion.ideal_sensor else [sample.q, sample.v]
            values += [sample.torque]
            values += [] if motion.external is None else [motion.external]
            values += [state.gain] if names[-1] == "gain" else []
            recorder.write(k // log_every, values)
        k += 1
        if progress is not None and (k % CHUNK == 0 or k == ticks):
            progress(k, ticks)
    if progress is not None and k < ticks:
        progress(ticks, ticks)
    written = recorder.finish(len(range(0, k, log_every)), first_logged(stopped_at, log_every))
    return Followed(written, stopped_at, reach)


def _names(motion: Motion) -> list[str]:
    """What is written of every run, whatever its law."""
    measured = MEASURED[2:] if motion.ideal_sensor else MEASURED
    return [*TRUTH, *measured, *([] if motion.external is None else ["external_torque"])]


def _ks_of(controller: Controller, nv: int) -> Array | None:
    """K_s of a law that has one, or None: a law of the user's own may call anything ``ks``."""
    try:
        ks = np.asarray(getattr(controller, "ks", None), dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return ks if ks.shape in ((), (nv,)) and not np.isnan(ks).any() else None


def _torque_of(controller: Controller, command: ArrayLike, batch: int, nv: int) -> Array:
    if type(command) is np.ndarray and command.shape == (batch, nv) and command.dtype == np.float64:
        return command
    try:
        torque = np.ascontiguousarray(command, dtype=np.float64)
    except (TypeError, ValueError):
        torque = np.empty(0)
    if np.shape(command) != (batch, nv):
        raise ParameterError(
            "controller",
            f"{type(controller).__name__}.step returned a torque of shape {np.shape(command)}; "
            f"expected (batch, nv) = {(batch, nv)}",
        )
    return torque
