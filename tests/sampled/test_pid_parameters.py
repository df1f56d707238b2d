"""`design --gains --yaml`: the PID in the file is TDC with backward differences, and has the margins that it states."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from asmc_pin import load_arm
from asmc_pin._typing import Array
from asmc_pin.cli import main
from asmc_pin.controllers import CONTROLLERS, Sample, Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.critical_points import critical_set
from asmc_pin.sampled.frozen_arms import frozen_arms
from asmc_pin.sampled.gain_choice.gain_design import PID, GainDesign
from asmc_pin.sampled.gain_choice.gain_search import Margins
from asmc_pin.sampled.gain_choice.pid_parameters import CONTROLLER, pid_yaml, update_rate
from asmc_pin.sampled.gain_choice.stored_pid import StoredPid, pid_loop
from asmc_pin.sampled.loop_analysis import examine, spaces_of
from asmc_pin.sampled.loop_limits import margins_of
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.stability_report import margin_words
from asmc_pin.sampled.transition import transition

PERIOD = 0.001
ARM = load_arm("two_link")
GAINS = {"mbar": np.array([0.0119, 0.0118]), "ks": 5.9, "beta": 250.0}
"""What `suggest_gains(…, pid=True)` comes to for this arm, rounded."""


@pytest.fixture(scope="module")
def design() -> GainDesign:
    loop = pid_loop(SampledLoop(**GAINS, period=PERIOD, velocity="difference", pairing="last"))
    arms = frozen_arms(ARM)
    report = examine(spaces_of(arms, samples=256, seed=0), loop, limits=True)
    return GainDesign(arms.about, loop, Margins((0.5, 2.0), 0.9), report, None, (), None, law=PID)


def parameters(design: GainDesign) -> dict[str, Any]:
    loaded = yaml.safe_load(pid_yaml(design, ARM))
    assert loaded["controller_manager"]["ros__parameters"]["update_rate"] == 1000
    return dict(loaded[CONTROLLER]["ros__parameters"])


class Pid:
    """ros2_control's PID as its documentation has it: p e + i Σ e dt + d Δe/dt, from the numbers of the file."""

    def __init__(self, told: dict[str, Any]) -> None:
        gains = [told["gains"][joint] for joint in told["dof_names"]]
        self.p, self.i, self.d = (np.array([each[name] for each in gains]) for name in "pid")
        self.last, self.sum = np.zeros(len(gains)), np.zeros(len(gains))

    def command(self, error: Array) -> Array:
        self.sum = self.sum + self.i * PERIOD * error
        rate = (error - self.last) / PERIOD
        self.last = error
        return np.asarray(self.p * error + self.sum + self.d * rate)


def test_the_file_is_yaml_with_the_names_of_ros2_controls_pid_controller_and_the_tuning_of_the_design(
    design: GainDesign,
) -> None:
    told, loop = parameters(design), design.loop
    assert told["dof_names"] == ["joint_1", "joint_2"]
    assert (told["command_interface"], told["reference_and_state_interfaces"]) == ("effort", ["position"])
    for k, name in enumerate(told["dof_names"]):
        gains = told["gains"][name]
        assert all(isinstance(gains[key], float) for key in ("p", "i", "d", "i_clamp_max", "i_clamp_min"))
        assert gains["p"] == pytest.approx(loop.mbar[k] * (loop.beta[0] + loop.ks[0]) / PERIOD, rel=1e-12)
        assert gains["i"] == pytest.approx(loop.mbar[k] * loop.beta[0] * loop.ks[0] / PERIOD, rel=1e-12)
        assert gains["d"] == pytest.approx(loop.mbar[k] / PERIOD, rel=1e-12)
        assert gains["antiwindup"] is False  # its URDF declares no limits
        assert (gains["i_clamp_max"], gains["i_clamp_min"]) == (np.inf, -np.inf)
    head = pid_yaml(design, ARM)
    assert "nothing is proven of this loop: law: a proof is of PPC's loop" in head
    assert "no anti-windup at joint_1, joint_2" in head


def test_the_integral_is_held_within_a_torque_limit_that_is_declared(design: GainDesign) -> None:
    limited = load_arm("two_dofs")
    assert np.isfinite(limited.effort_limit).all()
    gains = yaml.safe_load(pid_yaml(design, limited))[CONTROLLER]["ros__parameters"]["gains"]
    for name, limit in zip(limited.joint_names, limited.effort_limit, strict=True):
        assert gains[name]["antiwindup"] is True
        assert (gains[name]["i_clamp_max"], gains[name]["i_clamp_min"]) == (limit, -limit)


def test_in_closed_loop_the_pid_is_time_delay_control_with_backward_differences_to_rounding(design: GainDesign) -> None:
    rng, loop = np.random.default_rng(4), design.loop
    law = CONTROLLERS["ppc"](
        mbar=loop.mbar, ks=float(loop.ks[0]), beta=float(loop.beta[0]), period=PERIOD, pairing="last"
    )
    inertia = np.array([[0.9, 0.2], [0.2, 0.15]])
    wanted = np.cumsum(rng.normal(scale=1e-4, size=(400, 2)), axis=0)
    wanted[:3] = 0.0
    load = np.where(np.arange(400) > 100, 0.3, 0.0)[:, None]

    def run(torque_of: Any) -> Array:
        q, v, torque, path = np.zeros(2), np.zeros(2), np.zeros(2), []
        for k in range(400):
            torque = torque_of(k, q, torque)
            a = np.linalg.solve(inertia, torque - load[k])
            q, v = q + PERIOD * v + PERIOD**2 / 2.0 * a, v + PERIOD * a
            path.append(q)
        return np.array(path)

    memory: dict[str, Any] = {"q": np.zeros((2, 2))}
    wanted_v = np.diff(wanted, axis=0, prepend=wanted[:1]) / PERIOD
    wanted_a = np.diff(wanted_v, axis=0, prepend=wanted_v[:1]) / PERIOD

    def tdc(k: int, q: Array, torque: Array) -> Array:
        seen = Sample(q[None], (q - memory["q"])[:1] / PERIOD, torque[None])
        memory["q"] = np.tile(q, (2, 1))
        state = memory.get("state", law.init(seen))
        command, memory["state"] = law.step(
            state, seen, Setpoint(wanted[k, None], wanted_v[k, None], wanted_a[k, None])
        )
        return np.asarray(command[0])

    pid = Pid(parameters(design))
    by_pid, by_tdc = run(lambda k, q, _: pid.command(wanted[k] - q)), run(tdc)
    assert np.abs(by_tdc).max() > 1e-4
    np.testing.assert_allclose(by_pid, by_tdc, rtol=0.0, atol=1e-9 * np.abs(by_tdc).max())


def test_the_margins_that_are_printed_are_those_of_the_pid_in_the_file(design: GainDesign) -> None:
    """Within them its own recursion on the linear arm dies out at the configuration that decides; beyond it grows."""
    loop, reached = design.loop, design.reached
    assert reached is not None
    assert design.met
    assert margin_words(reached.gain, reached.delay, PERIOD) in pid_yaml(design, ARM)
    arms = frozen_arms(ARM)
    spaces = spaces_of(arms, samples=512, seed=0)
    critical = critical_set(spaces, loop, [space.worst(loop)[1] for space in spaces])
    margins_of(critical, loop)
    told = parameters(design)
    low, high = reached.gain
    for edge in ({"factor": low}, {"factor": high}, {"delay": reached.delay}):
        for share, grows in ((0.9, False), (1.1, True)):
            factor = edge.get("factor", 1.0) ** share
            delay = share * edge.get("delay", 0.0)
            _, point = critical.worst(replace(loop.scaled(mbar=factor), delay=delay))
            assert growth(arms, point, told, factor, delay) == grows, (edge, share)


def growth(arms: Any, point: Array, told: dict[str, Any], factor: float, delay: float) -> bool:
    """Whether the PID's own recursion moves the linear arm at a point further away later on than earlier."""
    whole = int(delay)
    mass, stiffness = arms.mass(point[None]), arms.stiffness(point[None])
    plant = transition(mass, np.ones(2), PERIOD, fraction=delay - whole, stiffness=stiffness)
    pid, state, queue, sizes = Pid(told), np.full(4, 1e-6), [np.zeros(2)] * 4, []
    for _ in range(6000):
        queue = [factor * pid.command(-state[:2]), *queue[:3]]
        state = plant.state[0] @ state + plant.recent[0] @ queue[whole] + plant.older[0] @ queue[whole + 1]
        sizes.append(float(np.abs(state[:2]).max()))
        if not np.isfinite(sizes[-1]) or sizes[-1] > 1e6:
            return True
    return max(sizes[-1000:]) > max(sizes[2000:3000])


def test_a_delay_is_another_to_a_pid_that_is_not_told_what_was_applied_and_modes_are_the_whole(
    design: GainDesign,
) -> None:
    late = replace(design.loop, delay=1.0)
    told = SampledLoop(late.mbar, late.ks, late.beta, PERIOD, delay=1.0, velocity="difference", pairing="last")
    space = spaces_of(frozen_arms(ARM), samples=64, seed=0)[0]
    assert np.abs(space.radii(late) - space.radii(told)).max() > 1e-3
    on_time = replace(design.loop, delay=0.0), replace(told, delay=0.0)
    np.testing.assert_allclose(space.radii(on_time[0]), space.radii(on_time[1]), rtol=1e-6)

    class Whole(StoredPid):
        separates = False

    law = Whole(mbar=late.mbar, ks=late.ks, beta=float(late.beta[0]), period=PERIOD)
    np.testing.assert_allclose(space.radii(replace(late, law=law)), space.radii(late), rtol=1e-6)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--yaml", "x.yaml"], "--gains"),
        (["--gains", "--period", "0.001", "--velocity", "measured"], "--velocity"),
        (["--gains", "--period", "0.001", "--pairing", "mean"], "--pairing"),
        (["--gains", "--period", "0.001", "--filter-hz", "50"], "--filter-hz"),
        (["--gains", "--period", "0.001", "--law", "dob"], "--law"),
        (["--gains", "--period", "0.0015"], "0.001499250375 s"),
    ],
)
def test_what_is_no_pid_is_refused_before_anything_is_searched(options: list[str], named: str, capfd: Any) -> None:
    yaml_option = [] if "--yaml" in options else ["--yaml", "x.yaml"]
    with pytest.raises(SystemExit) as end:
        main(["design", "two_link", *options, *yaml_option])
    out, err = capfd.readouterr()
    assert (end.value.code, out) == (2, "")
    assert named in err.splitlines()[-1]


def test_a_design_of_another_loop_is_no_pid(design: GainDesign) -> None:
    with pytest.raises(ParameterError, match="not of the PID's own loop"):
        pid_yaml(replace(design, law=""), ARM)
    assert update_rate(0.002) == 500


@pytest.mark.long
def test_the_command_writes_the_file_and_says_so_in_json(tmp_path: Path, capfd: Any) -> None:
    file = tmp_path / "pid.yaml"
    with pytest.raises(SystemExit) as end:
        main(["design", "two_link", "--gains", "--period", "0.001", "--yaml", str(file), "--json"])
    out, _ = capfd.readouterr()
    assert end.value.code == 0
    told = json.loads(out)["gains"]
    gains = yaml.safe_load(file.read_text(encoding="utf-8"))[CONTROLLER]["ros__parameters"]["gains"]
    assert told["pid"]["yaml"] == str(file)
    assert told["pid"]["p"] == [each["p"] for each in gains.values()]
    assert (told["velocity"], told["pairing"], told["met"]) == ("difference", "last", True)
