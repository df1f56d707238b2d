"""External loads under way."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.arms.frame_kinematics import FrameKinematics
from asmc_pin.plant.per_trial import row
from asmc_pin.plant.sensor.trial_noise import DISTURBANCE, NormalNoise
from asmc_pin.plant.world.world_parameters import Disturbance


class _Load:
    """One disturbance: its amplitude at the joints, or in the six components of a wrench."""

    def __init__(
        self, given: Disturbance, arm: Arm, period: float, batch: int, seed: int, trials: Sequence[int], index: int
    ) -> None:
        self.given = given
        self.frame = None if given.link is None else FrameKinematics(arm, given.link)
        wrench = self.frame is not None
        self.amplitude = np.concatenate([given.force, given.moment]) if wrench else row(given.torque, arm.nv, 0.0)
        self.present = np.zeros((batch, self.amplitude.size))
        if given.profile == "noise":
            assert given.frequency is not None
            self._stays = math.exp(-2.0 * math.pi * given.frequency * period)
            self._noise = NormalNoise(seed, trials, self.amplitude.size, DISTURBANCE, index)
            self.colour = self._noise.next().copy()  # stationary from the start

    def tick(self) -> None:
        """Noise of the next period."""
        if self.given.profile == "noise":
            fresh = math.sqrt(1.0 - self._stays**2)
            self.colour = self._stays * self.colour + fresh * self._noise.next()

    def hold(self, since: float, until: float) -> None:
        """Keep the mean over an integration step."""
        share = self.given.mean(since, until)
        value = share * self.amplitude
        self.present = (
            value * self.colour if self.given.profile == "noise" else np.broadcast_to(value, self.present.shape)
        )


class Loads:
    """All disturbances of a batch; `tick` once per control tick, `hold` once per integration step.

    Args:
        disturbances: What acts.
        arm: Any arm of the batch: kinematics are the same in all.
        period: Control period, s.
        batch: Number of trials.
        seed: Seed of the experiment.
        trials: Number of each trial.
    """

    def __init__(
        self,
        disturbances: Sequence[Disturbance],
        arm: Arm,
        period: float,
        batch: int,
        seed: int,
        trials: Sequence[int],
    ) -> None:
        self._loads = [
            _Load(given, arm, period, batch, seed, trials, index) for index, given in enumerate(disturbances)
        ]

    def tick(self) -> None:
        """Draw what is random in the next period."""
        for load in self._loads:
            load.tick()

    def hold(self, since: float, until: float) -> None:
        """Take the mean of each profile over an integration step, s."""
        for load in self._loads:
            load.hold(since, until)

    def over(self, k: int, ticks: int, period: float, substeps: int) -> tuple[Array, Array]:
        """What acts at the joints, mean over each integration step of some ticks from k on; none of it a wrench.

        Returns:
            What is the same in all trials, (ticks·substeps, nv), and what each has of its own, (batch, ticks·substeps,
            nv), N·m; empty where there is none.
        """
        step = period / substeps
        since = (np.arange(k, k + ticks)[:, None] * period + np.arange(substeps) * step).ravel()
        batch, nv = self._loads[0].present.shape
        shared, own = np.zeros((len(since), nv)), np.zeros((0, len(since), nv))
        for load in self._loads:
            shares = np.array([load.given.mean(at, at + step) for at in since.tolist()])[:, None]
            if load.given.profile != "noise":
                shared += load.amplitude * shares
                continue
            if not own.size:
                own = np.zeros((batch, len(since), nv))
            for tick in range(ticks):
                load.tick()
                steps = slice(tick * substeps, (tick + 1) * substeps)
                own[:, steps] += load.amplitude * shares[steps] * load.colour[:, None]
        return shared, own

    def torque(self, q: Array) -> Array:
        """What acts at the joints now, (batch, nv), N·m."""
        total = np.zeros_like(q)
        for load in self._loads:
            if load.frame is None:
                total += load.present
            else:
                force, moment = load.present[:, :3], load.present[:, 3:]
                total += load.frame.joint_torques(q, force, moment, local=load.given.axes == "link")
        return total
