"""A log of the two-link arm, laden and with friction, of which all is known; an experiment whose law made it."""

from __future__ import annotations

from functools import cache

import numpy as np

import asmc_pin
from asmc_pin import Identification, JointLog, identify

PERIOD = 0.002
LENGTH, START = 8.0, np.array([0.4, -0.3])
COULOMB, VISCOUS = np.array([0.1, 0.05]), np.array([0.4, 0.3])
LOAD = {"mass": 0.5, "com": [0.02, 0.0, 0.1]}


def motion() -> asmc_pin.Reference:
    return asmc_pin.REFERENCES["multisine"](
        offset=START,
        amplitude=[[0.7, 0.25], [0.8, 0.3]],
        frequency=[[0.25, 0.7], [0.35, 0.8]],
        phase=[[0.0, 1.0], [2.0, 0.5]],
        rise=0.5,
    )


EXPERIMENT = f"""
name = "two"
period = {PERIOD}
duration = {LENGTH}
arm = "two_link"
[reference]
kind = "multisine"
offset = [0.4, -0.3]
amplitude = [[0.7, 0.25], [0.8, 0.3]]
frequency = [[0.25, 0.7], [0.35, 0.8]]
phase = [[0.0, 1.0], [2.0, 0.5]]
rise = 0.5
[defaults]
mbar = [0.06, 0.025]
ks = 30.0
beta = 30.0
[controllers.TDC]
law = "ppc"
[controllers.Soft]
law = "ppc"
mbar = [0.001, 0.0004]
[controllers.Model]
law = "computed_torque"
coulomb = [0.1, 0.05]
viscous = [0.4, 0.3]
"""


@cache
def logged() -> JointLog:
    """A run of the experiment's own law on a laden arm with friction, its sensors ideal."""
    arm = asmc_pin.load_arm("two_link", payload=LOAD)
    plant = asmc_pin.Plant(arm, friction=asmc_pin.Friction(COULOMB, VISCOUS), effort_limit=np.full(2, np.inf))
    law = asmc_pin.CONTROLLERS["ppc"](mbar=[0.06, 0.025], ks=30.0, beta=30.0, period=PERIOD)
    run = asmc_pin.rollout(plant, law, motion(), LENGTH)
    assert run.status == ("ok",)
    return JointLog(
        "own", arm.joint_names, run.time, run.q[0], run.v[0], run.torque_measured[0], torque_side="motor", found=()
    )


@cache
def found() -> Identification:
    return identify(asmc_pin.load_arm("two_link"), logged(), fix=("stribeck", "torque_constant", "torque_offset"))
