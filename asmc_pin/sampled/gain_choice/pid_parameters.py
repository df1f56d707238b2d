"""Gains as parameters of ros2_control's PID controller: the PID that (7) is with backward differences, as YAML."""

from __future__ import annotations

import json
import math

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.gain_choice.gain_design import PID, GainDesign
from asmc_pin.sampled.gain_choice.pid_tuning import pid_of
from asmc_pin.sampled.proof.loop_certificate import not_plain
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.stability_report import margin_words
from asmc_pin.words.text import printable

CONTROLLER = "pid_controller"
"""Name that the file gives the controller."""


def update_rate(period: float) -> int:
    """Rate of the controller manager for a control period, Hz; it is a whole number there.

    Raises:
        ParameterError: this period has none.
    """
    rate = round(1.0 / period)
    if rate < 1 or not math.isclose(rate * period, 1.0, rel_tol=1e-9):
        raise ParameterError(
            "period",
            f"{period:g} s given, which is {1.0 / period:.6g} Hz; ros2_control's update_rate is a whole number of Hz: "
            f"give {1.0 / max(rate, 1):.10g} s",
        )
    return rate


def pid_gains(design: GainDesign) -> tuple[Array, Array, Array]:
    """P = K, i = K/T_I and d = K T_D of a design, shape (nv,) each: N·m/rad, N·m/(rad·s), N·m·s/rad.

    Raises:
        ValueError: there are no gains.
    """
    tuning = pid_of(design.loop)
    return tuning.k, tuning.k / tuning.ti, tuning.k * tuning.td


def pid_yaml(design: GainDesign, arm: Arm) -> str:
    """The gains of a design as parameters of ros2_control's ``pid_controller``.

    The integral is held within the joint's torque limit, where the arm declares one.

    Args:
        design: For the PID's own loop, as of ``suggest_gains(…, pid=True)``, so that its margins are the PID's.
        arm: Its arm.

    Raises:
        ParameterError: there are no gains, they are of another loop, or the period has no rate in whole Hz.
    """
    if design.report is None or design.reached is None:
        raise ParameterError("design", "no gains are stable, so there is no PID of them; its lines say why")
    if design.law != PID:
        raise ParameterError("design", "is not of the PID's own loop, so its margins are not the PID's; take pid=True")
    loop = design.loop
    rate = update_rate(loop.period)
    p, i, d = pid_gains(design)
    unlimited = [name for name, limit in zip(arm.joint_names, arm.effort_limit, strict=True) if not np.isfinite(limit)]
    said = [
        "PID that time-delay control with backward differences is: p = K, i = K/T_I, d = K T_D, for ros2_control's",
        "pid_controller (names of its parameters as in Jazzy).",
        printable(design.about.title),
        f"M = diag{_listed(loop.mbar)} kg·m²",
        f"beta = {float(loop.beta[0])!r} 1/s, K_s = {float(loop.ks[0])!r} 1/s, L = {loop.period!r} s",
        "margins of this PID's own map, at rest under gravity and of the inertia alone, where searched:",
        f"  {margin_words(design.reached.gain, design.reached.delay, loop.period)}",
        *([] if design.met else ["  those asked for were not found"]),
        f"nothing is proven of this loop: {_why_unproven(loop)}",
        "It holds for",
        "- commands that are the whole effort: where the robot adds gravity itself, its loop is another;",
        "- the derivative of the error by difference, which is what the one interface, position, means;",
        "- an integral that has the error of the tick in it, as control_toolbox documents. Where a version adds it",
        f"  after the command only, p has to be p + i L: {_listed(p + i * loop.period)};",
        "- errors that begin near 0: the integral begins at 0, and gravity is what it has to find first.",
        *(
            [f"no anti-windup at {', '.join(map(printable, unlimited))}: no torque limit is declared"]
            if unlimited
            else ["anti-windup: the integral is held within the torque limit that the arm declares"]
        ),
        "It was run on no robot, and not with ROS.",
    ]
    lines = [f"# {line}" for line in said]
    lines += [
        "controller_manager:",
        "  ros__parameters:",
        f"    update_rate: {rate}",
        f"    {CONTROLLER}:",
        "      type: pid_controller/PidController",
        "",
        f"{CONTROLLER}:",
        "  ros__parameters:",
        f"    dof_names: [{', '.join(map(_text, arm.joint_names))}]",
        "    command_interface: effort",
        "    reference_and_state_interfaces: [position]",
        "    gains:",
    ]
    for k, name in enumerate(arm.joint_names):
        limit = float(arm.effort_limit[k])
        clamp = _number(limit) if math.isfinite(limit) else ".inf"
        lines += [
            f"      {_text(name)}:",
            f"        p: {_number(p[k])}",
            f"        i: {_number(i[k])}",
            f"        d: {_number(d[k])}",
            f"        antiwindup: {'true' if math.isfinite(limit) else 'false'}",
            f"        i_clamp_max: {clamp}",
            f"        i_clamp_min: -{clamp}",
        ]
    return "\n".join(lines) + "\n"


def _why_unproven(loop: SampledLoop) -> str:
    """Why `stability --certify` covers no such map."""
    odd = not_plain(loop)
    assert odd is not None  # no proof is made of a law's own map
    return ": ".join(odd)


def _listed(values: Array) -> str:
    return f"({', '.join(repr(float(x)) for x in values)})"


def _number(value: float) -> str:
    """A float as YAML 1.1 reads it as one: with a point, also before an exponent."""
    text = repr(float(value))
    mantissa, e, exponent = text.partition("e")
    if e and "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}{e}{exponent}" if not e or exponent[0] in "+-" else f"{mantissa}e+{exponent}"


def _text(name: str) -> str:
    """A quoted string of JSON is one of YAML too."""
    return json.dumps(name, ensure_ascii=False)
