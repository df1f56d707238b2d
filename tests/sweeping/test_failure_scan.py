"""Scans: where a controller fails along one axis."""

import math

import numpy as np
import pyarrow.parquet as pq
import pytest
from sweep_cases import tiny

from asmc_pin.engine import rollout
from asmc_pin.metrics import METRICS
from asmc_pin.sweeping import sweep
from asmc_pin.sweeping.block_rows import BlockRows
from asmc_pin.sweeping.failure_scan import scan_ends
from asmc_pin.sweeping.lockstep import TrialTables
from asmc_pin.sweeping.sweep_plan import sweep_plan
from asmc_pin.sweeping.trial_runs import TrialOutcome, TrialRuns

UNTIL = {"max_error": 0.03}
AXIS = {"plant.friction.coulomb": {"scan": [0.0, 40.0], "until": UNTIL}}


class Pretended:
    """Runs of which each controller fails from its own value on, or in a band."""

    def __init__(self, fails):
        self.fails, self.asked = fails, []

    def __call__(self, jobs, labels):
        self.asked += [job.tables["arm"]["payload"] for job in jobs]
        return {
            (i, label): TrialOutcome("a", (), "ppc", label, False, self._status(label, job), 1.0, {})
            for i, job in enumerate(jobs)
            for label in labels
        }

    def _status(self, label, job):
        return "diverged" if self.fails[label](job.tables["arm"]["payload"]) else "ok"


class Counted(TrialRuns):
    """Runs that count those of each controller."""

    def __call__(self, jobs, labels=None):
        for label in labels or ():
            COUNT[label] = COUNT.get(label, 0) + len(jobs)
        return super().__call__(jobs, labels)


COUNT: dict[str, int] = {}


def ends(fails, scan=(0.0, 8.0)):
    experiment = tiny({"arm.payload": {"scan": list(scan)}})
    axis = experiment.variation.scans[0]
    runs = Pretended(fails)
    found = scan_ends(runs, axis, [TrialTables(0, 0, experiment.variation.data)], list(fails))
    return {label: found[0, label] for label in fails}, runs


@pytest.mark.parametrize("scan", [(0.0, 8.0), (8.0, 0.0), (3.0, 11.0)])
def test_the_point_of_failure_is_found_between_a_value_that_passes_and_one_that_fails(scan):
    edge = scan[0] + 0.637 * (scan[1] - scan[0])
    way = abs(edge - scan[0])
    found, _ = ends({"A": lambda x: abs(x - scan[0]) >= way}, scan)
    assert abs(found["A"].reached - scan[0]) < way <= abs(found["A"].fails_at - scan[0])
    assert abs(found["A"].fails_at - found["A"].reached) == pytest.approx(8.0 / 512)


def test_each_controller_has_its_own_end_and_one_that_never_fails_reaches_the_scans():
    found, _ = ends({"A": lambda x: x > 2.2, "B": lambda x: False, "C": lambda x: True})
    assert found["A"].fails_at == pytest.approx(2.2, abs=8.0 / 512)
    assert (found["B"].reached, found["B"].passed, found["B"].fails_at) == (8.0, True, math.inf)
    assert (found["C"].reached, found["C"].passed, found["C"].fails_at) == (0.0, False, 0.0)


def test_the_first_failure_on_the_way_is_found_and_nothing_is_run_beyond_it():
    found, runs = ends({"A": lambda x: 2.9 < x < 4.5})
    assert found["A"].fails_at == pytest.approx(2.9, abs=8.0 / 512)
    assert max(runs.asked) == 3.0


def test_rows_of_a_scan_hold_the_last_figure_that_passed_and_the_runs_agree():
    experiment = tiny(AXIS, plant={"friction": {"coulomb": 0.0}})
    plan = sweep_plan(experiment, 1, 2, "key")
    rows = BlockRows(plan).table(range(2)).to_pandas()
    scan = rows[rows.scanned == "plant.friction.coulomb"]
    assert len(scan) == 4
    assert (rows[rows.point == 0].scanned.isna()).all()
    for label, here in scan.groupby("controller"):
        reached, fails_at = here["sweep.plant.friction.coulomb"].iloc[0], here.fails_at.iloc[0]
        assert 0.0 < reached < fails_at < 40.0
        for value, fails in ((reached, False), (fails_at, True)):
            one = experiment.replace(plant={"friction": {"coulomb": value}}, sweep=None)
            run = rollout(one.build_plant(), one.build_controllers()[label], one.build_reference(), one.duration)
            error = METRICS["max_error"](run)[0]
            assert (run.status != ("ok",) or (error > UNTIL["max_error"]).any()) == fails
            assert fails or np.array_equal(error, here.max_error)


def test_draws_that_are_all_alike_make_nobody_better(tmp_path):
    """Twenty copies of one trial are one trial: an interval of no width would be false certainty."""
    experiment = tiny(AXIS, plant={"friction": {"coulomb": 0.0}}, arm="two_link")
    found = sweep(experiment, 8, tmp_path / "s", workers=1)
    assert found.findings.alike
    assert found.to_json_dict()["comparisons"] == []
    assert pq.read_table(found.out / "comparisons.parquet").num_rows == 0
    assert "nothing in this experiment is random" in (found.out / "summary.md").read_text()


def test_a_scan_that_never_fails_says_up_to_where_and_one_that_sometimes_does_says_beyond(tmp_path):
    gentle = {"plant.friction.coulomb": {"scan": [0.0, 0.25], "until": {"max_error": 1.0}}}
    found = sweep(tiny(gentle, plant={"friction": {"coulomb": 0.0}}, arm="two_link"), 2, tmp_path / "s", workers=1)
    assert [line for line in found.lines() if line.endswith("BSMC no failure seen up to 0.25")]
    page = (found.out / "summary.md").read_text()
    assert "no failure seen up to 0.25" in page
    assert "∞ [∞" not in page + str(found)
    ends = found.findings.fails_at["plant.friction.coulomb"]
    ends["BSMC"][:] = [0.1, math.inf]
    assert any("BSMC first seen at" in line and "beyond 0.25]" in line for line in found.lines())


def test_a_key_of_one_controller_is_told_of_that_one_and_compared_with_nobody(tmp_path):
    axes = {"controllers.PPC.beta": {"scan": [5.0, 5000.0]}, "arm.payload": {"uniform": [0.0, 0.5]}}
    experiment = tiny(axes, controllers={"PPC": {"law": "ppc", "beta": 5.0}, "BSMC": {"law": "ppc"}})
    found = sweep(experiment, 6, tmp_path / "out", workers=1)
    assert list(found.findings.fails_at["controllers.PPC.beta"]) == ["PPC"]
    assert np.isfinite(found.findings.fails_at["controllers.PPC.beta"]["PPC"]).all()
    told = "\n".join(found.lines())
    assert "controllers.PPC.beta" in told
    assert "way to the first failure" not in told
    assert "BSMC no failure" not in told


@pytest.mark.parametrize("limit", [1.0, 1e-9])
def test_in_a_scan_of_anothers_key_a_controller_runs_once_and_its_rows_are_those_of_running_it_everywhere(
    limit, monkeypatch
):
    """With the limit at 1e-9 rad it fails at once, as it would wherever the key stood."""
    experiment = tiny(
        {"controllers.PPC.beta": {"scan": [5.0, 50.0], "until": {"max_error": limit}}},
        controllers={"PPC": {"law": "ppc", "beta": 5.0}, "BSMC": {"law": "bsmc", "gain": 5.0, "boundary": 0.05}},
    )
    plan = sweep_plan(experiment, 2, 4, "key")
    monkeypatch.setattr("asmc_pin.sweeping.block_rows.TrialRuns", Counted)
    COUNT.clear()
    once = BlockRows(plan).table(range(4)).to_pandas()
    assert COUNT["BSMC"] == 2, "two draws, each scanned once"
    assert COUNT["PPC"] == (2 if limit < 1.0 else 2 * 9)
    monkeypatch.setattr("asmc_pin.experiment.variation.axes.VariedKey.concerns", lambda *_: True)
    COUNT.clear()
    assert BlockRows(plan).table(range(4)).to_pandas().equals(once)
    assert COUNT["BSMC"] == COUNT["PPC"]
