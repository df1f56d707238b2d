"""Drives at their limits, slow drives and trials that stop: no law remembers for how long."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from law_oracles import rail
from law_settings import HELD, required_of

from asmc_pin.controllers import CONTROLLERS, Sample, Setpoint
from asmc_pin.engine import Rollout, rollout
from asmc_pin.plant import Disturbance, Drive, Friction, Plant

AWAY, LIMIT = 0.5, 20.0
# Those for which `law_settings` has gains; a law of the user's own may wind up, as the example of the docs does.
LAWS = [name for name in CONTROLLERS if name in HELD or not required_of(name, 1.0)]


@dataclass(frozen=True)
class Called:
    """A reference that stands `AWAY` until a time, s, and at 0 from then on."""

    until: float
    duration: float = np.inf
    nv: int = 1

    def evaluate(self, t: np.ndarray) -> Setpoint:
        q = np.where(t < self.until, AWAY, 0.0)[:, None]
        return Setpoint(q, 0.0 * q, 0.0 * q)


def law_for(name: str) -> Any:
    return CONTROLLERS[name](mbar=0.6, ks=12.0, beta=9.0, period=1e-3, **HELD.get(name, {}))


def blocked(name: str, held: float) -> Rollout:
    """A mass that a force as large as the drive's limit holds back for a while, and then lets go where it is."""
    block = Disturbance(profile="pulse", torque=-LIMIT, start=0.0, duration=held)
    plant = Plant(rail(1.0), friction=Friction(), effort_limit=LIMIT, disturbances=[block])
    return rollout(plant, law_for(name), Called(held), held + 1.0, q0=[0.0])


@pytest.mark.parametrize("name", LAWS)
def test_how_long_a_drive_was_at_its_limit_makes_no_difference_afterwards(name: str) -> None:
    brief, long = blocked(name, 0.3), blocked(name, 6.0)
    assert brief.status == long.status == ("ok",)
    overshoot = [np.abs(run.q[0, -1000:, 0]).max() for run in (brief, long)]
    assert max(overshoot) < 0.03 * AWAY
    assert overshoot[1] < 1.02 * overshoot[0] + 1e-6


@pytest.mark.parametrize("name", LAWS)
def test_a_drive_that_lags_behind_its_command_is_survived(name: str) -> None:
    """A step that is far too fast for a current loop of 200 Hz at its limit; a velocity that folds the torque back."""
    drive = Drive(current_hz=200.0, velocity_limit=3.0)
    plant = Plant(rail(1.0), friction=Friction(), effort_limit=LIMIT, drive=drive)
    run = rollout(plant, law_for(name), Called(0.5), 5.0, q0=[0.0])
    assert run.status == ("ok",)
    assert np.abs(run.v).max() < 3.3
    assert np.abs(run.q[0, -500:, 0]).max() < 0.02 * AWAY


@pytest.mark.parametrize("name", LAWS)
def test_a_trial_that_stops_leaves_the_others_as_they_are(name: str) -> None:
    plant = Plant(rail(1.0), friction=Friction(), effort_limit=LIMIT, speed_bound=2.0)
    both = rollout(plant, law_for(name), Called(0.0), 0.3, batch=2, q0=[[0.1], [0.1]], v0=[[0.0], [3.0]])
    alone = rollout(plant, law_for(name), Called(0.0), 0.3, q0=[0.1], v0=[0.0])
    assert both.status == ("ok", "diverged")
    np.testing.assert_array_equal(both.q[0], alone.q[0])


def test_the_integral_of_super_twisting_waits_while_the_drive_falls_short() -> None:
    law = law_for("sta")
    x = Sample(*(np.zeros((1, 1)) for _ in range(3)))
    state, ends = law.init(x), []
    for _ in range(3000):
        torque, state = law.step(state, x, Setpoint(x.q + AWAY, x.v, x.v))
        x = Sample(x.q, x.v, np.clip(torque, -LIMIT, LIMIT))
        ends.append(state.integral.item())
    assert ends[0] > 0.0
    assert ends[-1] == ends[100] < 0.2  # not k₂ t = 30
