"""What a run says of itself in lines and a table."""

from __future__ import annotations

import dataclasses

import numpy as np
from plant_cases import OpenLoop, Still, slider

from asmc_pin.engine import rollout
from asmc_pin.plant import Friction, Plant


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
