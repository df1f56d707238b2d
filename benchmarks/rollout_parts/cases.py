"""What is run, and what it is compared with: plants, laws, rollouts and bare dynamics, each timed."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time

import numpy as np
import pinocchio as pin

from asmc_pin import Plant, load_arm, rollout
from asmc_pin.controllers import AdaptiveState, Baek2016, Sample, Setpoint, signed
from asmc_pin.plant import Drive, Friction, Sensor
from asmc_pin.references import Multisine

PERIOD = 1e-3  # s
ARM = load_arm("ur5", payload=2.0, armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05])
FRICTION = Friction(coulomb=[8.0, 8.0, 5.0, 2.0, 2.0, 1.0], viscous=[1.0, 1.0, 1.0, 0.2, 0.2, 0.1])
PLANTS = {
    "frictionless": {"friction": Friction()},
    "friction": {"friction": FRICTION},
    "full": {
        "friction": Friction(FRICTION.coulomb, FRICTION.viscous, breakaway=1.4 * FRICTION.coulomb),
        "drive": Drive(delay=0.6, current_hz=400.0, velocity_limit=4.0, corner_speed=3.5, no_load_speed=5.0),
        "sensor": Sensor(
            bits=20, position_noise=1e-7, velocity="filter", filter_hz=200.0, torque_noise=0.01, delay=0.25
        ),
    },
}
GAINS = {"mbar": [0.6228, 0.8771, 0.6488, 0.2616, 0.2080, 0.0198], "ks": 8.0, "beta": 8.0, "period": PERIOD}
ADAPTATION = {"phi": 800.0, "alpha": 0.03, "epsilon": 0.01}
REFERENCE = Multisine(
    offset=[0.0, -1.3, 1.6, -1.2, -1.4, 0.0],
    amplitude=[0.7, 0.35, 0.4, 0.5, 0.5, 0.8],
    frequency=[0.5, 0.6, 0.5, 0.7, 0.6, 0.8],
)


class InNumpy(Baek2016):
    """The law with a step of its own in numpy."""

    def step(self, state: AdaptiveState, sample: Sample, setpoint: Setpoint) -> tuple[np.ndarray, AdaptiveState]:
        """Torque and next state."""
        torque, s, tde = self.pole_placement(state.tde, sample, setpoint)
        size, gain = np.abs(s), state.gain
        outside = np.maximum.reduce(size, axis=-1, keepdims=True) >= self.epsilon
        fall = self.period * self.phi * self.alpha
        drop = np.divide(fall, size, out=gain.copy(), where=gain * size > fall)
        grown = gain + self.period * self.phi / self.alpha * size
        gain = np.where(outside | (gain <= self.threshold), grown, gain - drop)
        return torque + self.mbar * signed(gain, s), AdaptiveState(tde, gain)


LAWS = {"baek2016": Baek2016(**GAINS, **ADAPTATION), "numpy law": InNumpy(**GAINS, **ADAPTATION)}


def best(run: Callable[[], object], repeats: int, clock: Callable[[], float] = process_time) -> float:
    """Least time of a call, s."""
    times = []
    for _ in range(repeats):
        start = clock()
        run()
        times.append(clock() - start)
    return min(times)


def ticks_for(batch: int) -> int:
    return max(60, min(4000, 60_000 // batch))


def bare(batch: int, repeats: int) -> float:
    """Pinocchio's forward dynamics, µs per trial and call."""
    q, v, torque = np.random.default_rng(0).uniform(-1.0, 1.0, (3, batch, ARM.nv))
    out, pool, calls = np.empty_like(q), pin.ModelPool(ARM.model, 1), max(1, 4000 // batch)

    def call() -> None:
        for _ in range(calls):
            pin.abaInParallel(1, pool, q.T, v.T, torque.T, out.T)

    return 1e6 * best(call, 4 * repeats) / calls / batch


def ours(plant: str, law: str, batch: int, repeats: int) -> float:
    """A rollout, µs per trial and tick."""
    ticks = ticks_for(batch)
    world = Plant(ARM, substeps=1, **PLANTS[plant])
    run = rollout(world, LAWS[law], REFERENCE, 5 * PERIOD, batch=batch)  # compile, or load from the cache
    assert set(run.status) == {"ok"}
    seconds = best(lambda: rollout(world, LAWS[law], REFERENCE, (ticks - 1) * PERIOD, batch=batch), repeats)
    return 1e6 * seconds / ticks / batch


def step_alone(batch: int, repeats: int) -> float:
    """The step of the law in numpy by itself, without an engine around it: µs per trial and call."""
    law, source, calls = LAWS["numpy law"], np.random.default_rng(0), max(20, 20_000 // batch)
    told, wanted = source.uniform(-1.0, 1.0, (3, batch, ARM.nv)), source.uniform(-1.0, 1.0, (3, 1, ARM.nv))
    told.setflags(write=False)
    sample, setpoint = Sample(*told), Setpoint(*np.broadcast_to(wanted, told.shape))
    start = law.init(sample)

    def run() -> None:
        state = start
        for _ in range(calls):
            state = law.step(state, sample, setpoint)[1]

    run()
    return 1e6 * best(run, repeats) / calls / batch
