"""Why some printed numbers cannot hold, whatever the plant's details: two lower bounds on the error of PPC.

Both follow from (7). In a period L the torque of PPC moves by M̄ (q̈_d + K_d ė + K_p e − q̈), K_d = K_s + βI, K_p = βK_s.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.controllers import Setpoint, TdeLaw
from asmc_pin.experiment import Experiment
from asmc_pin.reproduction.printed_tables import PPC, Printed
from asmc_pin.sampled import SampledLoop, drift_error


def limits(experiment: Experiment, printed: Printed) -> dict[str, Any]:
    """The bounds along the reference of an experiment, with its gains of PPC.

    Returns:
        ``drift_deg``: RMS error that the drift of the gravity torque alone leaves, by joint, deg. ``reversals``: for
        each joint the reversal that asks for the largest error, None without one: ``time`` s, ``error_deg`` when the
        joint breaks away, and ``gain``, the β = k_s that would break it away within the error that the figure shows.
    """
    arm = experiment.build_arm()
    time, setpoint = experiment.setpoints()
    law = experiment.build_controllers()[PPC]
    assert isinstance(law, TdeLaw)
    law = law.for_joints(arm.nv)
    drift = gravity_error(arm, setpoint, law)[time <= (printed.window or math.inf)]
    coulomb = np.broadcast_to(experiment.build_plant().friction.coulomb, (arm.nv,))
    reversals: list[dict[str, float] | None] = []
    for joint in range(arm.nv):
        turns = np.flatnonzero(setpoint.v[1:-1, joint] * setpoint.v[2:, joint] < 0.0) + 1
        found = None
        for turn in turns:
            path = setpoint.q[turn:, joint] - setpoint.q[turn, joint]
            pace = (path, setpoint.v[turn:, joint], setpoint.a[turn:, joint])
            jump, rate = 2.0 * float(coulomb[joint]), float(law.mbar[joint])
            error = break_away(*pace, jump, rate, law.period, float(law.beta), float(law.ks[joint]))
            if found is None or error > found["error"]:
                gain = needed_gain(pace, jump, rate, law.period, math.radians(printed.error_deg[joint]))
                found = {"time": float(time[turn]), "error": error, "gain": gain}
        reversals.append(
            found and {"time": found["time"], "error_deg": math.degrees(found["error"]), "gain": found["gain"]}
        )
    return {"drift_deg": np.degrees(np.sqrt(np.mean(drift**2, axis=0))).tolist(), "reversals": reversals}


def gravity_error(arm: Arm, setpoint: Setpoint, law: TdeLaw) -> Array:
    """Steady error under the drift of the gravity torque along the reference, (T, nv), rad; see `drift_error`.

    Exact for a slow drift on a joint of constant inertia: the torque has to move by L ḣ in every period, and with ė = 0
    only K_p e moves it.
    """
    drift = np.gradient(arm.gravity(setpoint.q), law.period, axis=0)
    return drift_error(SampledLoop(law.mbar, law.ks, np.asarray(law.beta), law.period), drift)


def break_away(
    path: Array, speed: Array, pace: Array, jump: float, mbar: float, period: float, beta: float, ks: float
) -> float:
    """Error at which a joint that stuck at a reversal of its reference moves again, rad.

    Where the reference reverses, Coulomb friction F does too: the joint sticks until its torque has moved by 2F. While
    it sticks, q̈ = 0 and e is all of the reference's motion since.

    Args:
        path: q_d since the reversal, shape (T,), rad.
        speed: q̇_d there, rad/s.
        pace: q̈_d there, rad/s².
        jump: 2F, N·m.
        mbar: m̄ of the joint, kg·m².
        period: L, s.
        beta: β, 1/s.
        ks: k_s, 1/s.

    Returns:
        The error; that of the end of the path if the torque does not get there.
    """
    torque = np.cumsum(mbar * (pace + (beta + ks) * speed + beta * ks * path))
    sign = np.sign(path[min(len(path) - 1, round(0.01 / period) + 1)])
    there = np.flatnonzero(sign * torque >= jump)
    return float(np.abs(path[there[0] if there.size else -1]))


def needed_gain(pace: tuple[Array, Array, Array], jump: float, mbar: float, period: float, error: float) -> float:
    """The smallest β = k_s with which the joint breaks away within an error, 1/s, to a part in a thousand."""
    low, high = 0.0, 1.0
    while break_away(*pace, jump, mbar, period, high, high) > error and high < 1e6:
        low, high = high, 2.0 * high
    while high - low > 1e-3 * high:
        middle = 0.5 * (low + high)
        if break_away(*pace, jump, mbar, period, middle, middle) > error:
            low = middle
        else:
            high = middle
    return high
