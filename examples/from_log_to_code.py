"""From a log of an arm to code for it: the plant as measured, an M̄ proven for it, gains, C, and that C in MuJoCo."""

import tempfile

import mujoco
import numpy as np

import asmc_pin

# The robot, which nobody knows: it has rotors, a load and friction that its URDF has not. It moves, and logs at 500 Hz.
friction, load = {"coulomb": [0.3, 0.2], "viscous": [0.4, 0.3]}, {"mass": 0.5, "com": [0.02, 0.0, 0.1]}
swing = {"kind": "multisine", "offset": [0.4, -0.3], "amplitude": [[0.7, 0.25], [0.8, 0.3]], "rise": 0.5}
swing |= {"frequency": [[0.25, 0.7], [0.35, 0.8]], "phase": [[0.0, 1.0], [2.0, 0.5]]}
sensor = {"bits": 19, "velocity": "filter", "filter_hz": 60.0, "torque_noise": 0.3}
tables = {"name": "robot", "period": 0.002, "duration": 20.0, "reference": swing}
tables |= {"arm": {"source": "two_link", "payload": load, "armature": [0.10, 0.05]}}
tables |= {"plant": {"friction": friction, "sensor": sensor, "effort_limit": [200.0, 60.0]}}
robot = asmc_pin.Experiment.from_dict(tables | {"controllers": {"Own": {"law": "pd_gravity", "kp": 400.0, "kd": 40.0}}})
run = asmc_pin.rollout(robot.build_plant(), robot.build_controllers()["Own"], robot.build_reference(), 20.0)
told = [run.time, run.q_measured[0], run.v_measured[0], run.torque_measured[0]]
log = asmc_pin.JointLog("robot.log", run.joint_names, *told, torque_side="motor", found=())
arm = asmc_pin.load_arm("two_link")
found = asmc_pin.identify(arm, log, fix=["torque_constant", "torque_offset"])
print("1. the log:", *(f"{name} {x.low:.3f}…{x.high:.3f}" for name, x in found.parameters.items()), sep="\n   ")
measured = asmc_pin.plant_tables(found)
ranges = asmc_pin.measured_ranges(measured["arm"])
gains = asmc_pin.suggest_gains(arm, asmc_pin.design(arm, **ranges).mbar, 0.002, **ranges)  # M̄ may become smaller
law = {"law": "ppc", "mbar": gains.mbar.round(3).tolist(), "beta": round(float(gains.loop.beta[0]), 1)}
law["ks"] = gains.loop.ks.round(1).tolist()
proof = asmc_pin.certify(arm, law["mbar"], **ranges, levels=False)
print(f"2. M̄ = {law['mbar']} kg·m²: Lemma 1 {proof.verdict} for every payload and armature within the intervals")
print(f"3. gains at 2 ms: K_s = {law['ks']} 1/s, β = {law['beta']} 1/s")
plant = {**measured["plant"], "effort_limit": [200.0, 60.0]}
twin = robot.replace(name="twin", arm=measured["arm"], plant=plant, controllers={"TDC": law}, duration=4.0)
with tempfile.TemporaryDirectory() as folder:
    done = asmc_pin.export(twin, "TDC", f"{folder}/c")
    code = asmc_pin.load_exported(f"{folder}/c")
print(f"4. C: {done.checked_ticks} ticks run, at most {done.largest_difference:g} N·m from Python")

spec = mujoco.MjSpec.from_string(robot.build_arm().urdf_text)  # the same robot in another engine
spec.body("link_2").add_body(pos=load["com"], mass=load["mass"], inertia=[1e-6] * 3, explicitinertial=True)
model, wanted, error = spec.compile(), robot.build_reference().evaluate(0.002 * np.arange(2001)), []
model.dof_armature, model.dof_frictionloss, model.dof_damping = tables["arm"]["armature"], *friction.values()
model.opt.timestep, data = 0.0005, mujoco.MjData(model)
data.qpos, data.qvel, torque = wanted.q[0], wanted.v[0], robot.build_arm().gravity(wanted.q[0])
for setpoint in zip(wanted.q, wanted.v, wanted.a, strict=True):
    torque = code(data.qpos, data.qvel, torque, *setpoint)
    error.append(np.abs(setpoint[0] - data.qpos).max())
    data.qfrc_applied = torque
    mujoco.mj_step(model, data, nstep=4)
run = asmc_pin.rollout(twin.build_plant(), twin.build_controllers()["TDC"], twin.build_reference(), 4.0)
ours = np.abs(run.q_ref - run.q[0]).max()
print(
    f"5. largest tracking error: the C in MuJoCo {max(error):.4f} rad, the law on the plant as measured {ours:.4f} rad"
)
