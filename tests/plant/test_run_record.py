"""What a run says of itself in lines and a table."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
from plant_cases import OpenLoop, Still, slider

from asmc_pin.engine import rollout
from asmc_pin.plant import Friction, Plant
from asmc_pin.plant.joint_reach import all_reached, no_reach, outside_limits


def test_a_run_tells_how_many_trials_diverged_and_counts_the_others_figures(tmp_path):
    plant = Plant(slider(tmp_path, 2.0), friction=Friction(), start="relaxed")
    run = rollout(plant, OpenLoop(lambda t: 3.0, 1e-3), Still(np.zeros(1)), 0.02, batch=2)
    assert run.lines()[0] == "2 trials of 0.02 s in periods of 0.001 s"
    _, rows = run.table()
    assert rows[0][2] == "3"
    torque = run.torque * np.array([1.0, 100.0])[:, None, None]
    ended = np.array([run.time[-1], 0.0123])
    broken = dataclasses.replace(run, status=("ok", "diverged"), end_time=ended, torque=torque)
    assert broken.lines()[0].endswith("; 1 diverged, first at t = 0.0123 s")
    assert broken.table()[1][0][2] == "3"
    lost = dataclasses.replace(broken, status=("diverged", "diverged"))
    assert "2 diverged" in lost.lines()[0]
    assert "3" not in lost.table()[1][0][2]


def test_where_nobody_says_otherwise_no_torque_acted_before_and_each_is_reported_a_tick_later(tmp_path):
    plant = Plant(slider(tmp_path, 2.0), friction=Friction(), start="relaxed")
    run = rollout(plant, OpenLoop(lambda t: 1.0 + t, 1e-3), Still(np.zeros(1)), 0.01, batch=2)
    bare = dataclasses.replace(run, held_torque=None, torque_measured=None)
    assert bare.held_torque.tolist() == [[0.0], [0.0]]
    np.testing.assert_array_equal(bare.torque_measured[:, 0], 0.0)
    np.testing.assert_array_equal(bare.torque_measured[:, 1:], run.torque[:, :-1])
    assert run.torque.min() > 0.5
    begun = dataclasses.replace(bare, torque=run.torque[:, :1], held_torque=None, torque_measured=None)
    assert begun.torque_measured.tolist() == begun.held_torque[:, None].tolist() == [[[0.0]], [[0.0]]]


def test_one_trial_is_one_and_the_largest_of_logged_ticks_is_called_so(tmp_path):
    plant = Plant(slider(tmp_path, 2.0), friction=Friction(), start="relaxed")
    every, some = (
        rollout(plant, OpenLoop(lambda t: 1.0, 1e-3), Still(np.zeros(1)), 0.02, log_every=n) for n in (1, 10)
    )
    assert every.lines()[0] == "1 trial of 0.02 s in periods of 0.001 s"
    assert every.table()[0] == ["joint", "largest |e| rad (m)", "largest |τ| N·m (N)"]
    assert some.lines()[0] == "1 trial up to 0.02 s in periods of 0.001 s, one tick in 10 logged"
    assert some.table()[0] == ["joint", "largest logged |e| rad (m)", "largest logged |τ| N·m (N)"]


def reach_of(arm, q):
    """What is noted of trials of one arm, (batch, T, nv); those with NaN run no more."""
    plant = SimpleNamespace(arm=SimpleNamespace(nv=2), arms=(arm,))
    reach = no_reach(plant, len(q))
    for k in range(q.shape[1]):
        all_reached(reach, np.ascontiguousarray(q[:, k]), k, np.isfinite(q[:, k]).all(axis=1))
    return reach


def test_a_joint_that_leaves_its_limits_is_named_with_the_first_time_and_the_farthest_it_came():
    arm = SimpleNamespace(lower=np.array([-1.0, 2.0]), upper=np.array([0.5, 4.0]))
    q = np.array([[[0.3, 3.0], [0.4, 3.9], [0.6, 3.0], [0.9, 2.5], [np.nan, np.nan]]])
    (found,) = outside_limits(("a", "b"), 0.1, reach_of(arm, q))
    assert (found.joint, found.trial, found.time) == ("a", 0, 0.1 * 2)
    np.testing.assert_allclose(found.excess, 0.4)
    (found,) = outside_limits(("a", "b"), 0.1, reach_of(arm, q - [0.5, 1.4]))
    assert (found.joint, found.time) == ("b", 0.0)
    np.testing.assert_allclose(found.excess, -0.9)
    within = np.clip(q, arm.lower - 0.9e-9, arm.upper + 0.9e-9)
    assert outside_limits(("a", "b"), 0.1, reach_of(arm, within)) == ()
