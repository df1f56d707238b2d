"""The arrays of a run in compiled code: of its trials, of what comes from outside, and of what is logged."""

from __future__ import annotations

from typing import NamedTuple

from asmc_pin._typing import Array, BoolArray, IntArray


class Trials(NamedTuple):
    """What belongs to the trials of a run; the first axis is the trial's.

    Attributes:
        plant: Parameters, (batch, PLANT_ROWS, nv).
        state: (batch, STATE_ROWS, nv).
        drive: What the current loops carry, then commands on their way, oldest first, (batch, rows, nv).
        sensor: Memory of the sensors, (batch, rows, nv).
        seen: Angle, velocity and torque as reported at the present tick, (batch, 3, nv).
        active: Whether it runs, (batch,).
        stopped_at: Tick at which it stopped, (batch,); the number of ticks where it did not.
        reach: How far its joints came, see `asmc_pin.plant.joint_reach`, (batch, 5, nv).
    """

    plant: Array
    state: Array
    drive: Array
    sensor: Array
    seen: Array
    active: BoolArray
    stopped_at: IntArray
    reach: Array


class Inputs(NamedTuple):
    """What comes from outside.

    Attributes:
        q_ref: Reference, (T, nv), rad.
        v_ref: Its velocity.
        a_ref: Its acceleration.
        older_share: Part of each step in which the older of two commands still acts, (substeps,).
        loads: Disturbances, mean over each step, the same for all trials, (ticks·substeps, nv), N·m; empty for none.
        own_loads: Those of each trial, (batch, ticks·substeps, nv); empty for none.
        noise: Of the sensors, (batch, ticks, 3, nv); empty for none.
    """

    q_ref: Array
    v_ref: Array
    a_ref: Array
    older_share: Array
    loads: Array
    own_loads: Array
    noise: Array


class Histories(NamedTuple):
    """What is written of a run, (batch, logged ticks, nv) each; empty where it is not asked for."""

    q: Array
    v: Array
    torque: Array
    friction_torque: Array
    q_measured: Array
    v_measured: Array
    torque_measured: Array
    external_torque: Array
    s: Array
    gain: Array
