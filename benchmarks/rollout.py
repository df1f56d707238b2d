"""What a rollout costs over bare dynamics: the processor time of a run over that of as many `pin.abaInParallel` calls.

    python benchmarks/rollout.py [--repeats 7] [--scaling] [--readme]

A run is a UR5 under a law at 1 kHz with one integration step per period, every tick logged: law, torque limits, check
for divergence, dynamics, friction, integration, log, and all that a `rollout` does before and after. The baseline calls
Pinocchio's forward dynamics alone, on arrays made beforehand, once per tick and trial. Both are measured in one process
on one thread, in processor time, which other programs disturb less than the clock; of each the best repeat counts.

"numpy law" is the same law with its adaptation written in numpy, as a user's own would be, asked tick by tick. "full"
has a Stribeck curve, drives with delay, current loop and speed limits, and encoders with noise, a filter and a delay.

Beside them stand MuJoCo's on the same arm, without friction and law: a Python loop round `mj_step`, and its `rollout`
in C, open loop; and Drake's `Simulator` with a `LeafSystem` in Python. They are left out, and that is said, where they
are not installed.

With ``--scaling``: cost against batch, horizon and joints, drawn into docs/images/rollout_scaling.png, and what a
second thread brings; that by the clock, so it wants idle processors.
"""

from __future__ import annotations

import argparse
import platform
import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
import pinocchio as pin

from asmc_pin import Arm, Plant, load_arm, rollout
from asmc_pin.agreement.mujoco_model import Twin
from asmc_pin.controllers import AdaptiveState, Baek2016, Ppc, Sample, Setpoint, signed
from asmc_pin.errors import MissingDependencyError
from asmc_pin.plant import Drive, Friction, Sensor
from asmc_pin.references import Multisine

README = Path(__file__).with_name("README.md")
FIGURE = README.parent.parent / "docs" / "images" / "rollout_scaling.png"
GOALS = {
    **{("frictionless", "baek2016", batch): goal for batch, goal in ((1, 1.0), (16, 0.7), (256, 0.65), (1024, 0.65))},
    **{("friction", "baek2016", batch): goal for batch, goal in ((1, 1.2), (16, 0.8), (256, 0.8), (1024, 0.85))},
    **{("friction", "numpy law", batch): goal for batch, goal in ((1, 11.0), (16, 1.9), (256, 0.8))},
    ("full", "baek2016", 256): 1.3,
}
"""The largest ratio that a row is to have."""

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


def mujoco_loop(repeats: int) -> float:
    """A Python loop round `mj_step`, the torque written at every tick: µs per tick."""
    import mujoco

    model = Twin(ARM)._model
    model.opt.timestep, model.opt.integrator = PERIOD, mujoco.mjtIntegrator.mjINT_EULER
    data = mujoco.MjData(model)
    start, torque = REFERENCE.evaluate(np.zeros(1)).q[0], ARM.gravity(REFERENCE.evaluate(np.zeros(1)).q[0])

    def run() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[:] = start
        for _ in range(2000):
            data.qfrc_applied[:] = torque
            mujoco.mj_step(model, data)

    return 1e6 * best(run, repeats) / 2000


def mujoco_rollout(batch: int, repeats: int) -> float:
    """MuJoCo's own rollout in C, open loop, on one thread: µs per trial and tick."""
    import mujoco
    import mujoco.rollout

    model = Twin(ARM)._model
    model.opt.timestep, model.opt.integrator = PERIOD, mujoco.mjtIntegrator.mjINT_EULER
    data = mujoco.MjData(model)
    data.qpos[:] = REFERENCE.evaluate(np.zeros(1)).q[0]
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    ticks = max(20, 8000 // batch)
    torque = np.tile(ARM.gravity(np.array(data.qpos)), (batch, ticks, 1))
    applied = int(mujoco.mjtState.mjSTATE_QFRC_APPLIED)

    def run() -> None:
        mujoco.rollout.rollout(model, data, np.tile(state, (batch, 1)), torque, control_spec=applied)

    return 1e6 * best(run, repeats) / ticks / batch


def drake_loop(repeats: int) -> float:
    """Drake's `Simulator` with a `LeafSystem` in Python that gives the torque at every step: µs per tick.

    The arm is bare, with the armature on its joints, and Drake's discrete plant steps once per period.
    """
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import BasicVector, DiagramBuilder, LeafSystem

    arm = load_arm("ur5")
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(time_step=PERIOD))
    (model,) = Parser(plant).AddModelsFromString(arm.urdf_text, "urdf")
    if plant.num_joints() == arm.nv:  # the base is free as yet
        plant.WeldFrames(plant.world_frame(), plant.get_body(plant.GetBodyIndices(model)[0]).body_frame())
    if plant.num_actuators() == 0:  # else the file has transmissions
        for name in arm.joint_names:
            plant.AddJointActuator(name, plant.GetJointByName(name))
    actuators = [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices()]
    places = [arm.joint_names.index(actuator.joint().name()) for actuator in actuators]
    for actuator, place in zip(actuators, places, strict=True):
        actuator.set_default_rotor_inertia(float(ARM.armature[place]))
        actuator.set_default_gear_ratio(1.0)
    plant.Finalize()
    start = REFERENCE.evaluate(np.zeros(1)).q[0]
    torque = arm.gravity(start)[places]

    class Law(LeafSystem):
        """A torque, asked for in Python at every step."""

        def __init__(self) -> None:
            super().__init__()
            self.DeclareVectorInputPort("state", 2 * arm.nv)
            self.DeclareVectorOutputPort("torque", BasicVector(arm.nv), self.calculate)

        def calculate(self, context: object, output: BasicVector) -> None:
            self.get_input_port(0).Eval(context)
            output.SetFromVector(torque)

    law = builder.AddSystem(Law())
    builder.Connect(plant.get_state_output_port(), law.get_input_port(0))
    builder.Connect(law.get_output_port(0), plant.get_actuation_input_port())
    simulator = Simulator(builder.Build())

    def run() -> None:
        context = simulator.get_mutable_context()
        context.SetTime(0.0)
        plant.SetPositions(plant.GetMyMutableContextFromRoot(context), start)
        plant.SetVelocities(plant.GetMyMutableContextFromRoot(context), np.zeros(arm.nv))
        simulator.Initialize()
        simulator.AdvanceTo(2000 * PERIOD)

    return 1e6 * best(run, repeats) / 2000


def chain(joints: int, folder: Path) -> Arm:
    """A chain of equal links that turn about x, y, z and so on."""
    axes = ("1 0 0", "0 1 0", "0 0 1")
    text = '<link name="link0"/>'
    for k in range(joints):
        text += (
            f'<link name="link{k + 1}"><inertial><origin xyz="0 0 0.1"/><mass value="1"/>'
            '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>'
            f'<joint name="joint{k}" type="continuous"><origin xyz="0 0 0.2"/><parent link="link{k}"/>'
            f'<child link="link{k + 1}"/><axis xyz="{axes[k % 3]}"/></joint>'
        )
    path = folder / f"chain{joints}.urdf"
    path.write_text(f'<robot name="chain">{text}</robot>')
    return load_arm(path)


def scaling(repeats: int) -> dict[str, dict[int, float]]:
    """How the cost grows, µs per trial and tick: against batch, horizon in ticks, and joints."""
    found = {"batch": {b: ours("friction", "baek2016", b, repeats) for b in (1, 4, 16, 64, 256, 1024)}}
    world = Plant(ARM, substeps=1, friction=FRICTION)
    found["ticks, batch 1"] = {}
    for ticks in (250, 1000, 4000, 16000):
        span = (ticks - 1) * PERIOD
        seconds = best(lambda span=span: rollout(world, LAWS["baek2016"], REFERENCE, span), repeats)
        found["ticks, batch 1"][ticks] = 1e6 * seconds / ticks
    found["joints, batch 16"] = {}
    with tempfile.TemporaryDirectory() as folder:
        for joints in (2, 4, 7, 12, 20, 30):
            arm = chain(joints, Path(folder))
            law = Ppc(mbar=0.01, ks=5.0, beta=5.0, period=PERIOD)
            still = Multisine(offset=np.zeros(joints), amplitude=np.full(joints, 1e-3), frequency=np.ones(joints))
            plant = Plant(arm, substeps=1, friction=Friction(0.1, 0.1))
            seconds = best(lambda p=plant, r=still, law=law: rollout(p, law, r, 0.4, batch=16), repeats)
            found["joints, batch 16"][joints] = 1e6 * seconds / 401 / 16
    return found


def threads_gain(repeats: int) -> float:
    """How much faster two threads are than one, batch 1024, by the clock."""
    clocked = {}
    for threads in (1, 2):
        world = Plant(ARM, substeps=1, friction=FRICTION, threads=threads)
        clocked[threads] = best(
            lambda w=world: rollout(w, LAWS["baek2016"], REFERENCE, 0.2, batch=1024), repeats, perf_counter
        )
    return clocked[1] / clocked[2]


def drawn(found: dict[str, dict[int, float]], path: Path) -> None:
    """The scaling as a figure; where joints vary, the line is proportional to the first cost times joints."""
    import matplotlib.pyplot as plt

    from asmc_pin.pages.figure_style import GREY, PAGE, paper_style

    with paper_style():
        figure, axes = plt.subplots(1, len(found), figsize=(PAGE, 2.0), layout="constrained")
        for axis, (name, costs) in zip(axes, found.items(), strict=True):
            axis.loglog(list(costs), list(costs.values()), "o-", color="#1F77B4", markersize=3)
            axis.set_xlabel(name)
            if name.startswith("joints"):
                first = next(iter(costs))
                axis.loglog(list(costs), [costs[first] * n / first for n in costs], "--", color=GREY, label="linear")
                axis.legend()
            axis.set_ylim(0.1, 20.0)
            axis.set_xticks(list(costs), [f"{n:,}" for n in costs])
            axis.set_yticks([0.1, 0.3, 1, 3, 10], ["0.1", "0.3", "1", "3", "10"])
            axis.minorticks_off()
        axes[0].set_ylabel("µs per trial and tick")
        figure.savefig(path, metadata={"Software": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--scaling", action="store_true", help="cost against batch, horizon, joints, threads too")
    parser.add_argument("--readme", action="store_true", help="replace the table of benchmarks/README.md")
    options = parser.parse_args()
    repeats = options.repeats

    print(f"UR5, 1 step of {PERIOD * 1e3:g} ms per period; processor time, best of {repeats};", end=" ")
    print(f"pin {pin.__version__}, numpy {np.__version__}, Python {platform.python_version()}, {platform.machine()}")
    print(
        "{:>14} {:>10} {:>6} {:>14} {:>13} {:>6}".format(
            "plant", "law", "batch", "µs/trial/tick", "bare aba, µs", "ratio"
        )
    )
    rows = [(plant, "baek2016", batch) for batch in (1, 16, 256, 1024) for plant in ("frictionless", "friction")]
    rows += [("friction", "numpy law", batch) for batch in (1, 16, 256)]
    rows += [("full", "baek2016", batch) for batch in (1, 16, 256)]
    table = [
        "| plant | law | batch | µs per trial and tick | baseline, µs | ratio | goal |",
        "| --- | --- | ----: | --------------------: | -----------: | ----: | ---: |",
    ]
    for plant, law, batch in rows:
        base = bare(batch, repeats)
        cost = ours(plant, law, batch, repeats)
        base = min(base, bare(batch, repeats))
        print(f"{plant:>14} {law:>10} {batch:>6} {cost:>14.2f} {base:>13.2f} {cost / base:>6.2f}", flush=True)
        goal = f"{GOALS[plant, law, batch]:g}" if (plant, law, batch) in GOALS else ""
        table.append(f"| {plant} | {law} | {batch} | {cost:.2f} | {base:.2f} | {cost / base:.2f} | {goal} |")
        if law == "numpy law":
            alone = step_alone(batch, repeats)
            print(f"{'':>14} its step {batch:>7} {alone:>14.2f} {'':>13} {alone / base:>6.2f}", flush=True)
            table.append(f"| none | its step alone | {batch} | {alone:.2f} | {base:.2f} | {alone / base:.2f} |  |")
    try:
        loop, rolled = mujoco_loop(repeats), mujoco_rollout(256, repeats)
        one, many = loop / bare(1, repeats), rolled / bare(256, repeats)
        print(f"Python loop round mj_step: {loop:.2f} µs per tick, {one:.2f} of bare aba at batch 1")
        print(f"mujoco.rollout, open loop, 256: {rolled:.2f} µs, {many:.2f} of bare aba there")
        table += [
            f"| none | MuJoCo, Python loop round `mj_step` | 1 | {loop:.2f} | {loop / one:.2f} | {one:.2f} |  |",
            f"| none | MuJoCo, `rollout` in C, open loop | 256 | {rolled:.2f} | {rolled / many:.2f} | {many:.2f} |  |",
        ]
    except MissingDependencyError as error:
        print(f"MuJoCo left out: {error}")
    try:
        loop = drake_loop(repeats)
        one = loop / bare(1, repeats)
        print(f"Drake, Simulator with a Python LeafSystem: {loop:.2f} µs per tick, {one:.2f} of bare aba at batch 1")
        row = f"| {loop:.2f} | {loop / one:.2f} | {one:.2f} |  |"
        table.append(f"| none | Drake, `Simulator` with a Python `LeafSystem` | 1 {row}")
    except ImportError as error:
        print(f"Drake left out, it is not installed: {error}")
    if options.readme:
        pattern = re.compile(r"(<!-- from here: rollout -->\n).*?(<!-- to here: rollout -->)", re.DOTALL)
        text = README.read_text(encoding="utf-8")
        rows_text = "\n".join(table)
        README.write_text(pattern.sub(lambda found: f"{found[1]}{rows_text}\n{found[2]}", text), encoding="utf-8")
    if options.scaling:
        found = scaling(repeats)
        for name, costs in found.items():
            print(f"{name}:", *(f"{n}: {cost:.2f}" for n, cost in costs.items()))
        drawn(found, FIGURE)
        print(f"drawn: {FIGURE}")
        print(f"two threads over one, batch 1024, by the clock: {threads_gain(repeats):.2f} times as fast")


if __name__ == "__main__":
    main()
