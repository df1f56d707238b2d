"""The exported C, called from Python: in the plant of every comparison, and in a loop that is not ours."""

from __future__ import annotations

import numpy as np
import pytest
from export_cases import KINDS, experiment_of, exported

import asmc_pin
from asmc_pin.agreement.mujoco_model import Twin
from asmc_pin.controllers import Sample, Setpoint

LONG = pytest.mark.long


@pytest.mark.parametrize("kind", ["ppc", "baek2016", "sta"])
def test_the_c_in_our_plant_is_the_law_in_our_plant_to_the_last_bit(kind, tmp_path):
    exported(tmp_path / "x", KINDS[kind], torque_rate=np.inf)
    loaded = asmc_pin.load_exported(tmp_path / "x")
    experiment = experiment_of(KINDS[kind])
    plant, reference = experiment.build_plant(), experiment.build_reference()
    starts = np.array([[0.3, 0.2], [0.31, 0.19]])
    runs = [
        asmc_pin.rollout(plant, law, reference, 0.25, batch=2, q0=starts)
        for law in (experiment.build_controllers()["It"], loaded)
    ]
    assert runs[0].status == ("ok", "ok")
    np.testing.assert_array_equal(runs[0].torque, runs[1].torque)
    np.testing.assert_array_equal(runs[0].q, runs[1].q)


def in_mujoco(experiment, command):
    """Angles and torques of the experiment's motion in MuJoCo, frictionless; `command` is asked at every tick."""
    twin, period = Twin(experiment.build_arm()), experiment.period
    _, wanted = experiment.setpoints()
    limit = experiment.build_plant().effort_limit
    q, v = wanted.q[0], wanted.v[0]
    tau = twin.arm.gravity(q)
    path, torques = [], []
    for k in range(len(wanted.q)):
        path.append(q)
        asked = command(q, v, tau, wanted.q[k], wanted.v[k], wanted.a[k])
        tau = np.clip(asked, -limit, limit)
        torques.append(tau)
        steps = twin.run(q, v, np.array([tau, tau]), 0.5 * period)
        q, v = steps[0][-1], steps[1][-1]
    return np.array(path), np.array(torques)


def asked_of(law):
    """A law of ours as a callable of one arm."""
    kept = []

    def command(q, v, tau, q_ref, v_ref, a_ref):
        sample = Sample(*(np.array([x]) for x in (q, v, tau)))
        state = kept.pop() if kept else law.init(sample)
        torque, state = law.step(state, sample, Setpoint(*(np.array([x]) for x in (q_ref, v_ref, a_ref))))
        kept.append(state)
        return torque[0]

    return command


@pytest.mark.parametrize("label", ["Proposed", *(pytest.param(x, marks=LONG) for x in ("PPC", "BSMC", "Existing"))])
def test_in_mujoco_along_the_demo_it_agrees_with_compare_to_the_difference_of_the_plants(label, tmp_path):
    """The C and the law of `compare` do the same in MuJoCo; what is left is what the two engines differ by."""
    demo = asmc_pin.load_experiment("demo")
    experiment = demo.replace(plant={"integrator": "rk4", "substeps": 2, "friction": {"coulomb": 0.0}})
    asmc_pin.export(experiment, label, tmp_path / "x", torque_rate=np.inf)
    law = experiment.build_controllers()[label]
    theirs, torque = in_mujoco(experiment, asmc_pin.load_exported(tmp_path / "x"))
    ours_there, ours_torque = in_mujoco(experiment, asked_of(law))
    np.testing.assert_array_equal(theirs, ours_there)
    np.testing.assert_array_equal(torque, ours_torque)
    last = (len(theirs) - 1) * experiment.period
    run = asmc_pin.rollout(experiment.build_plant(), law, experiment.build_reference(), last)
    assert np.abs(run.q[0] - run.q[0, 0]).max() > 0.01  # it moves
    assert last == demo.duration
    assert np.abs(theirs - run.q[0]).max() < 1e-9


def test_a_single_precision_law_is_called_in_single_precision(tmp_path):
    exported(tmp_path / "x", KINDS["ppc"], real="float")
    law = asmc_pin.load_exported(tmp_path / "x")
    assert (law.real, law.nv, law.period) == ("float", 2, 0.001)
    rest = np.zeros(2)
    torque = law(rest, rest, [1.0, 2.0], rest, rest, rest)
    np.testing.assert_array_equal(torque, [1.0, 2.0])
    assert law.status == "ok"
    np.testing.assert_array_equal(law(rest, rest * np.nan, [1.0, 2.0], rest, rest, rest), [1.0, 2.0])
    assert law.status == "bad input"
    law(rest, rest, rest, rest, rest, rest, dt=0.5)
    assert law.status == "bad time"


def test_a_folder_without_an_export_and_wrong_sizes_are_said(tmp_path):
    with pytest.raises(asmc_pin.ResultError, match="holds no export"):
        asmc_pin.load_exported(tmp_path)
    exported(tmp_path / "x", KINDS["ppc"])
    law = asmc_pin.load_exported(tmp_path / "x")
    with pytest.raises(asmc_pin.ParameterError, match="2 numbers"):
        law.restart(np.zeros(3), np.zeros(3), np.zeros(3))
