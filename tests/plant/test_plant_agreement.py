"""Friction against independent solvers: Pinocchio's constraints of joint friction, and the limit of MuJoCo's."""

from __future__ import annotations

from itertools import pairwise

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from plant_cases import OpenLoop, Still

from asmc_pin.agreement.mujoco_model import Twin
from asmc_pin.arms import load_arm
from asmc_pin.engine import rollout
from asmc_pin.plant import Friction, Plant
from asmc_pin.plant.friction.compiled_friction import slide_or_stick

STEP = 1e-3
# What the solvers themselves leave, rad/s and N·m·s per kg·m²: ours puts a sticking joint at exactly 0.
TOLERANCE = {"PGS": 1e-9, "ADMM": 2e-7}
SOLVERS = {
    "PGS": (pin.PGSConstraintSolver, pin.PGSSolverSettings, pin.PGSSolverResult),
    "ADMM": (pin.ADMMConstraintSolver, pin.ADMMSolverSettings, pin.ADMMSolverResult),
}


def pinocchio_says(solver, arm, q, free, forward, backward):
    """Velocity after the step and friction's impulse, from Pinocchio's solver for constraints of joint friction."""
    joints = pin.StdVec_Index()
    for joint in range(1, arm.nv + 1):
        joints.append(joint)
    friction = pin.JointFrictionConstraintModel(arm.model, joints, -forward, backward)
    friction.setTimeStep(STEP)
    friction.setCompliance(np.zeros(arm.nv))
    models, datas, data = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData(), arm.model.createData()
    models.append(pin.ConstraintModel(friction))
    datas.append(models[0].createData())
    pin.crba(arm.model, data, q)
    models[0].calc(arm.model, data, datas[0])
    inverse = np.linalg.inv(arm.mass_matrix(q))
    make, settings, result = (kind() for kind in SOLVERS[solver])
    settings.max_iterations = 20000
    for name in ("feasibility", "complementarity"):
        setattr(settings, f"absolute_{name}_tol", 1e-13)
        setattr(settings, f"relative_{name}_tol", 1e-13)
    make.solve(pin.DelassusOperatorDense(np.asfortranarray(inverse)), free, models, datas, settings, result)
    impulse = np.array(result.retrieveConstraintImpulses())
    return free + inverse @ impulse, impulse


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", ["two_link", "ur5", "panda"])
def test_a_step_is_that_of_pinocchios_joint_friction_constraints(name, solver):
    arm = load_arm(name)
    rng = np.random.default_rng(8)
    stuck = 0
    for _ in range(40):
        q = rng.uniform(-2.0, 2.0, arm.nv)
        v = rng.normal(0.0, 0.3, arm.nv) * (rng.random(arm.nv) < 0.5)
        scale = np.diag(arm.mass_matrix(q))
        forward, backward = rng.uniform(0.5, 20.0, (2, arm.nv)) * scale
        a = arm.forward_dynamics(q, v, arm.gravity(q) + 15.0 * scale * rng.normal(0.0, 1.0, arm.nv))
        expected, push = pinocchio_says(solver, arm, q, v + STEP * a, forward, backward)
        next_v, impulse = np.empty((1, arm.nv)), np.zeros((1, arm.nv))
        one = tuple(x[None] for x in (arm.mass_matrix(q), v, a, forward, backward, np.zeros(arm.nv)))
        slide_or_stick(*one, STEP, np.ones(1, dtype=bool), next_v, impulse)
        np.testing.assert_allclose(next_v[0], expected, rtol=0, atol=TOLERANCE[solver])
        np.testing.assert_allclose(impulse[0], push, rtol=0, atol=TOLERANCE[solver] * scale.max())
        stuck += np.count_nonzero(next_v == 0.0)
    assert stuck > 10


def mujoco_says(arm, q, level, torque, duration, step):
    """Motion under frictionloss, as hard as MuJoCo's soft constraint can be made at this step."""
    model = Twin(arm)._model
    dofs = [model.joint(name).dofadr[0] for name in arm.joint_names]
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    model.opt.timestep, model.opt.tolerance, model.opt.iterations = step, 1e-14, 200
    model.dof_frictionloss[dofs] = level
    model.dof_solref[dofs] = 2.0 * step, 1.0
    model.dof_solimp[dofs] = 0.9999, 0.9999, 1e-3, 0.5, 2.0
    data = mujoco.MjData(model)
    data.qpos[dofs] = q
    ticks = round(duration / STEP)
    path = np.empty((ticks + 1, arm.nv))
    for k in range(ticks + 1):
        path[k] = data.qpos[dofs]
        data.qfrc_applied[dofs] = torque(k * STEP)
        for _ in range(round(STEP / step)):
            mujoco.mj_step(model, data)
    return path


@pytest.mark.parametrize("name", ["two_link", "ur5"])
def test_mujocos_frictionloss_comes_to_the_same_motion_as_its_step_shrinks(name):
    arm = load_arm(name)
    q = np.array([0.3, -1.0, 1.2, 0.4, 0.8, 0.2])[: arm.nv]
    scale, hold = np.diag(arm.mass_matrix(q)), arm.gravity(q)
    level = 4.0 * scale

    def torque(t):
        return hold + 8.0 * scale * np.sin(30.0 * t + np.arange(arm.nv))

    plant = Plant(arm, friction=Friction(level), integrator="midpoint", substeps=60, effort_limit=np.inf)
    ours = rollout(plant, OpenLoop(torque, STEP), Still(q), 0.3)
    sticks = np.mean(ours.v[0] == 0.0)
    assert 0.05 < sticks < 0.9
    steps = (2e-4, 1e-4, 2.5e-5)
    gaps = [np.abs(mujoco_says(arm, q, level, torque, 0.3, step) - ours.q[0]).max() for step in steps]
    assert all(finer < coarser for coarser, finer in pairwise(gaps))
    assert gaps[-1] < 0.2 * gaps[0]
    assert gaps[-1] < 1e-3 * np.ptp(ours.q[0], axis=0).max()
