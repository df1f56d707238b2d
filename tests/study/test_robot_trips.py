"""`plant.limits`: an arm held against what its robot takes, in a comparison and in an export."""

import sys

import numpy as np
import pytest

from asmc_pin.arms.robot_limits import ROBOT_LIMITS
from asmc_pin.codegen import export, exporting
from asmc_pin.errors import ExperimentError
from asmc_pin.experiment import Experiment
from asmc_pin.study import compare

DATA = {
    "name": "tripping",
    "arm": "so101",
    "period": 0.002,
    "duration": 0.1,
    "ensemble": {"trials": 2},
    "plant": {"limits": "so101", "effort_limit": 10.0},
    "reference": {"kind": "quintic", "start": [0.0] * 5, "targets": [[0.002] * 5], "move": 0.1},
    "defaults": {"mbar": [0.03, 0.03, 0.03, 0.03, 0.028], "ks": 5.0, "beta": 5.0},
    "controllers": {"Calm": {"law": "ppc"}, "Torn": {"law": "bsmc", "gain": 150.0, "boundary": 1e-5}},
}


def experiment_with(**plant):
    arm = {"source": "so101", "armature": "published"}
    return Experiment.from_dict({**DATA, "arm": arm, "plant": {**DATA["plant"], **plant}})


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys.modules["asmc_pin.study.comparison_files"], "draw_figures", lambda *_: [])
        patch.setattr("asmc_pin.pages.comparison_page.report_html", lambda *_: None)
        return compare(experiment_with(), out=tmp_path_factory.mktemp("trips") / "out")


def test_who_would_have_stopped_the_robot_is_warned_of_with_joint_value_limit_time_and_source(done):
    (line,) = (line for line in done.warnings if "tripped" in line)
    trip, limit = done.trips["Torn"], ROBOT_LIMITS["so101"].torque
    assert line.startswith(f"Torn: so101 would have tripped at t = {trip.time:.3f} s: joint '")
    assert f"torque {trip.value:.4g} N·m beyond {limit.values[0]:g} N·m (source: {limit.source})" in line
    assert "in 2 of 2 trials" in line
    assert trip.value > trip.limit == limit.values[0]
    run = done.dataset.sel(controller="Torn", trial=trip.trial) if trip.trial == 0 else None
    if run is not None:
        k = int(np.flatnonzero(np.isclose(run.time, trip.time))[0])
        assert abs(run.torque.to_numpy()[k, trip.joint]) == pytest.approx(trip.value)


def test_the_figure_stands_in_table_summary_note_and_json_and_never_is_null(done):
    assert done.overview().header[-1] == "trips at [s]"
    assert done.overview().rows[0][-1] == "–"
    (note,) = (line for line in done.notes if line.startswith("limits of SO-101"))
    assert "torque (torque rate and velocity not published, not judged): Calm kept them in every trial" in note
    assert "Torn would have tripped so101 in at least one trial" in note
    told = done.to_json_dict()
    assert told["limits"] == "so101"
    assert told["controllers"]["Calm"]["trip"] is None
    assert told["controllers"]["Calm"]["trip_time"] == [None] * 5
    assert told["controllers"]["Torn"]["trip"]["quantity"] == "torque"
    assert min(x for x in told["controllers"]["Torn"]["trip_time"] if x is not None) == done.trips["Torn"].time
    text = (done.out / "summary.md").read_text(encoding="utf-8")
    assert "would have tripped" in text
    assert "Would have tripped at" in text


def test_an_export_is_kept_within_the_robots_limits_says_whose_and_warns_of_the_motion(tmp_path, monkeypatch):
    monkeypatch.setattr(exporting, "find_compiler", lambda: None)
    done = export(experiment_with(), "Torn", tmp_path / "x", torque_rate=np.inf)
    torque = ROBOT_LIMITS["so101"].torque
    source = (tmp_path / "x" / "tripping_torn.c").read_text(encoding="utf-8")
    assert source.count(repr(torque.values[0])) >= 5
    header = (tmp_path / "x" / "tripping_torn.h").read_text(encoding="utf-8")
    assert torque.source in header
    assert "torque rate: not published" in header
    (line,) = (line for line in done.lines() if line.startswith("warning"))
    assert "so101 would have tripped at t = " in line
    assert done.to_json_dict()["trip"] in line
    assert export(experiment_with(), "Calm", tmp_path / "y").trip is None


def test_a_published_rate_feeds_the_count_of_ticks_and_the_export_and_is_tightened_never_loosened():
    panda = {**DATA, "arm": "panda", "plant": {"limits": "panda"}}
    panda["reference"] = {**DATA["reference"], "start": [0.0] * 7, "targets": [[0.0] * 7]}
    panda["defaults"] = {"mbar": 0.1, "ks": 5.0, "beta": 5.0}
    for asked, rate in ((None, 1000.0), (700.0, 700.0), (9000.0, 1000.0)):
        metrics = {} if asked is None else {"metrics": {"torque_rate_limit": asked}}
        settings = Experiment.from_dict({**panda, **metrics}).metric_settings()
        assert (settings.torque_rate_limit == rate).all()
        assert (settings.trips.torque_rate == rate).all()


@pytest.mark.parametrize(
    ("limits", "words"),
    [("pandda", "did you mean 'panda'"), (7, "must be a robot"), ("panda", "has 7 joints that turn, but so101 has 5")],
)
def test_an_unknown_robot_and_one_with_other_joints_are_refused_in_one_message_with_a_way_out(limits, words):
    with pytest.raises(ExperimentError, match=r"plant\.limits") as caught:
        experiment_with(limits=limits).build_plant()
    assert words in str(caught.value)
    assert limits != "panda" or "name one with as many (so100, so101, so100_12v, so101_12v)" in str(caught.value)
