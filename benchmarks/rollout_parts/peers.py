"""What other engines take on the same arm: MuJoCo's loops and Drake's `Simulator`."""

from __future__ import annotations

import numpy as np

from asmc_pin import load_arm
from asmc_pin.agreement.mujoco_model import Twin
from rollout_parts.cases import ARM, PERIOD, REFERENCE, best


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
