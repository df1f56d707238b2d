"""Comparing laws: what is measured, what is written, and that it is the same every time."""

import copy
import hashlib
import json
import re
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from asmc_pin.engine import rollout
from asmc_pin.errors import ExperimentError, ResultError
from asmc_pin.experiment import Experiment, load_experiment
from asmc_pin.experiment.toml_text import write_toml
from asmc_pin.metrics import METRICS
from asmc_pin.results import result_folder
from asmc_pin.study import compare

DATA = {
    "name": "small",
    "arm": "two_link",
    "period": 0.002,
    "duration": 0.2,
    "ensemble": {"trials": 1},
    "plant": {"friction": {"coulomb": [2.0, 1.0]}, "effort_limit": [120.0, 60.0]},
    "reference": {"kind": "quintic", "start": [0.3, 0.2], "targets": [[0.35, 0.15]], "move": 0.2},
    "defaults": {"mbar": [0.05, 0.02], "ks": 8.0, "beta": 8.0},
    "controllers": {
        "PPC": {"law": "ppc"},
        "Proposed & tried": {"law": "baek2016", "phi": 400.0, "alpha": 0.1, "epsilon": 0.01},
    },
}
FILES = {
    "experiment.toml",
    "trajectories.nc",
    "summary.parquet",
    "summary.md",
    "summary.tex",
    "claims.parquet",
    "monitors.nc",
    "report.html",
    "provenance.json",
    *(
        f"figures/{name}.{kind}"
        for name in ("reference", "gains_and_s", "torques", "errors", "theorems")
        for kind in ("pdf", "png")
    ),
}


def experiment_with(**changes):
    return Experiment.from_dict({**copy.deepcopy(DATA), **changes})


def digests(folder):
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(Path(folder).rglob("*"))
        if path.is_file()
    }


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    out = tmp_path_factory.mktemp("compare") / "nested" / "small"
    told = []
    comparison = compare(experiment_with(), out=out, progress=lambda what, share: told.append((what, share)))
    return comparison, told


@pytest.fixture
def unillustrated(monkeypatch):
    """Without figures and report, which take most of the time and are not what is looked at."""
    monkeypatch.setattr(sys.modules["asmc_pin.study.comparison_files"], "draw_figures", lambda *_: [])
    monkeypatch.setattr("asmc_pin.pages.comparison_page.report_html", lambda *_: None)


def test_a_comparison_leaves_every_file_and_nothing_beside_it(done):
    comparison, _ = done
    assert set(digests(comparison.out)) == FILES
    assert [path.name for path in comparison.out.parent.iterdir()] == ["small"]


def test_the_same_experiment_gives_the_same_bytes_but_for_the_provenance(done, tmp_path):
    comparison, _ = done
    again = compare(experiment_with(), out=tmp_path / "again")
    first, second = digests(comparison.out), digests(again.out)
    assert {name for name in FILES if first[name] != second[name]} == {"provenance.json"}


def test_only_the_provenance_has_dates_and_versions(done):
    comparison, _ = done
    provenance = json.loads((comparison.out / "provenance.json").read_text())
    versions = {item for name, item in provenance["packages"].items() if item and name != "asmc-pin"}
    years = {provenance["started"][:4].encode(), provenance["started"][:10].replace("-", "").encode()}
    for name in ("trajectories.nc", "summary.md", "summary.tex", "experiment.toml"):
        content = (comparison.out / name).read_bytes()
        assert not [item for item in versions if item.encode() in content], name
        assert not [year for year in years if year in content], name
    for path in (comparison.out / "figures").iterdir():
        content = path.read_bytes()
        assert b"CreationDate" not in content
        assert b"atplotlib" not in content, path.name


def test_the_provenance_carries_hashes_versions_and_the_seed(done):
    comparison, _ = done
    provenance = json.loads((comparison.out / "provenance.json").read_text())
    assert provenance["arm"]["sha256"] == comparison.arm.sha256
    assert provenance["seed"] == 0
    assert {"asmc-pin", "pin", "numpy"} <= set(provenance["packages"])
    assert set(provenance["seconds"]) == set(DATA["controllers"])
    files = digests(comparison.out)
    del files["provenance.json"]
    assert provenance["files"] == files


def test_progress_goes_from_nothing_to_all_without_a_step_back(done):
    _, told = done
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    assert set(DATA["controllers"]) <= {what for what, _ in told}


def test_rows_are_one_for_each_controller_and_joint_and_recomputed_from_the_trajectories(done):
    comparison, _ = done
    rows, data = comparison.rows, comparison.dataset
    assert len(rows) == 4
    assert set(METRICS) <= set(rows.columns)
    error = (data.q_ref - data.q).sel(controller="PPC", joint="joint_2").squeeze("trial").to_numpy()
    row = rows[(rows.controller == "PPC") & (rows.joint == "joint_2")].iloc[0]
    assert row.rms_error == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
    assert row.law == "ppc"
    assert np.isnan(row.peak_gain)
    assert rows[rows.controller == "Proposed & tried"].peak_gain.gt(0.0).all()


def test_all_controllers_meet_the_same_plant_and_reference(done):
    comparison, _ = done
    data = comparison.dataset
    assert data.q.isel(time=0).std("controller").max() == 0.0
    assert data.torque.isel(time=0).notnull().all()
    alone = rollout_of(experiment_with(controllers={"Only": DATA["controllers"]["Proposed & tried"]}))
    assert np.array_equal(alone.q[0], data.q.sel(controller="Proposed & tried", trial=0).to_numpy())


def rollout_of(experiment):
    (law,) = experiment.build_controllers().values()
    return rollout(experiment.build_plant(), law, experiment.build_reference(), experiment.duration)


def test_the_json_is_what_the_design_promises(done):
    comparison, _ = done
    told = json.loads(json.dumps(comparison.to_json_dict(), allow_nan=False))
    assert told["arm"] == "two_link"
    assert told["out"] == str(comparison.out)
    assert told["error_units"] == ["deg", "deg"]
    assert list(told["controllers"]) == list(DATA["controllers"])
    ppc = told["controllers"]["PPC"]
    assert ppc["law"] == "ppc"
    assert ppc["status"] == "ok"
    assert {*METRICS} <= set(ppc)
    rows = comparison.rows[comparison.rows.controller == "PPC"]
    assert ppc["rms_error"] == pytest.approx(np.degrees(rows.rms_error))
    assert ppc["torque_rms"] == pytest.approx(rows.torque_rms)
    assert ppc["peak_gain"] == [None, None]


def test_lemma_1_is_told_along_the_reference(done):
    comparison, _ = done
    line = comparison.notes[0]
    norm = comparison.lemma1["PPC"]
    mass = comparison.arm.mass_matrix(comparison.dataset.q_ref.to_numpy())
    exact = np.linalg.norm(np.eye(2) - np.linalg.solve(mass, np.diag([0.05, 0.02])), 2, axis=(1, 2))
    assert (norm.lower, norm.upper) == pytest.approx((exact.min(), exact.max()))
    assert f"{norm.lower:.4f} … {norm.upper:.4f}, unrefuted" in line


def test_trouble_is_warned_of_before_the_run_where_it_can_be_and_written_down(tmp_path, unillustrated):
    defaults = {"mbar": [0.9, 0.2], "ks": 300.0, "beta": 300.0}
    experiment = experiment_with(
        defaults=defaults,
        duration=1.0,
        plant={"effort_limit": [5.0, 60.0]},
        controllers={"PPC": {"law": "ppc"}, "Shy": {"law": "ppc", "mbar": [0.05, 0.02], "ks": 1.0, "beta": 1.0}},
    )
    heard, order = [], []
    comparison = compare(
        experiment,
        out=tmp_path / "bad",
        warn=lambda line: (heard.append(line), order.append("warning")),
        progress=lambda what, _: order.append(what),
    )
    text = "\n".join(comparison.warnings)
    assert list(comparison.warnings) == heard
    assert "reference: joint 'joint_1': torque" in text
    assert "limit 5 N·m" in text
    assert f"Lemma 1 is violated along the reference on {comparison.about.title} by the M̄ of PPC: " in text
    assert "Shy" not in next(line for line in heard if "Lemma 1" in line)
    assert order.index("warning") < order.index("PPC")
    assert all(line in (comparison.out / "summary.md").read_text(encoding="utf-8") for line in heard)
    assert result_folder.load_result(comparison.out).dataset.attrs["warnings"].splitlines() == heard


def test_a_law_that_diverges_is_a_status_and_has_no_figures(tmp_path, unillustrated):
    experiment = experiment_with(
        duration=1.0,
        plant={"effort_limit": float("inf"), "friction": {}},
        controllers={"Wild": {"law": "ppc", "mbar": [5.0, 5.0], "ks": 300.0, "beta": 300.0}, "PPC": {"law": "ppc"}},
    )
    comparison = compare(experiment, out=tmp_path / "wild")
    told = json.loads(json.dumps(comparison.to_json_dict(), allow_nan=False))["controllers"]
    assert told["Wild"]["status"] == "diverged"
    assert 0.0 < told["Wild"]["end_time"] < 1.0
    assert told["Wild"]["rms_error"] == [None, None]
    assert told["PPC"]["status"] == "ok"
    assert all(x < 1.0 for x in told["PPC"]["rms_error"])
    assert any("Wild diverged at t = " in line for line in comparison.warnings)
    header, rows = comparison.overview().header, comparison.overview().rows
    assert header[-1] == "status"
    assert [row[-1].split()[0] for row in rows] == ["diverged", "ok"]
    assert "| Wild | – | – |" in (comparison.out / "summary.md").read_text(encoding="utf-8")


def test_a_result_that_is_there_is_left_alone_unless_forced(done):
    comparison, _ = done
    before = digests(comparison.out)
    with pytest.raises(ResultError, match=r"there is a result in .* already; force=True replaces it"):
        compare(experiment_with(), out=comparison.out)
    assert digests(comparison.out) == before


def test_what_is_no_result_is_never_replaced(tmp_path):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").write_text("years of work")
    (tmp_path / "file").write_text("a file")
    (tmp_path / "link").symlink_to(tmp_path / "thesis")
    for name in ("thesis", "file", "link"):
        with pytest.raises(ResultError, match="out="):
            compare(experiment_with(), out=tmp_path / name, force=True)
    assert (tmp_path / "thesis" / "chapter.tex").read_text() == "years of work"


@pytest.mark.parametrize("trouble", [KeyboardInterrupt, OSError("disk full")])
@pytest.mark.parametrize(
    "step", ["comparison_files.draw_figures", "comparison_files._write_provenance", "comparing._run"]
)
def test_whatever_breaks_off_nothing_half_written_stays_and_the_old_result_does(
    done, tmp_path, monkeypatch, unillustrated, trouble, step
):
    comparison, _ = done
    old = tmp_path / "old"
    old.mkdir()
    for name in ("experiment.toml", "provenance.json"):
        (old / name).write_bytes((comparison.out / name).read_bytes())
    before = digests(old)

    def fail(*_args, **_kwargs):
        raise trouble

    module, name = step.split(".")
    monkeypatch.setattr(sys.modules[f"asmc_pin.study.{module}"], name, fail)
    for out, force in ((tmp_path / "new", False), (old, True)):
        with pytest.raises((KeyboardInterrupt, OSError)):
            compare(experiment_with(), out=out, force=force)
    assert digests(old) == before
    assert [path.name for path in tmp_path.iterdir()] == ["old"]


def test_force_replaces_a_result_as_a_whole(done, tmp_path):
    out = tmp_path / "result"
    out.mkdir()
    for name in ("experiment.toml", "provenance.json", "stray.txt"):
        (out / name).write_text("old")
    again = compare(experiment_with(duration=0.02), out=out, force=True)
    assert set(digests(again.out)) == FILES
    assert [path.name for path in tmp_path.iterdir()] == ["result"]


LAW = """
import numpy as np
from dataclasses import dataclass

@dataclass(frozen=True)
class Spring:
    stiffness: float

    def init(self, sample):
        return 0

    def step(self, ticks, sample, setpoint):
        if self.stiffness < 0 and ticks == 3:
            raise ZeroDivisionError("no springs left")
        torque = self.stiffness * (setpoint.q - sample.q) - 2.0 * sample.v
        return (torque[:, :1] if self.stiffness == 0 else torque), ticks + 1
"""


def own_law(tmp_path, stiffness, text=LAW):
    data = copy.deepcopy(DATA) | {"duration": 0.02}
    data["controllers"] = {"PPC": {"law": "ppc"}, "Spring": {"law": "spring_law:Spring", "stiffness": stiffness}}
    (tmp_path / "spring_law.py").write_text(text)
    (tmp_path / "own.toml").write_text(write_toml(data))
    return load_experiment(tmp_path / "own.toml")


def test_a_law_of_ones_own_is_compared_like_any_other(tmp_path, unillustrated):
    comparison = compare(own_law(tmp_path, 800.0), out=tmp_path / "out")
    spring = comparison.to_json_dict()["controllers"]["Spring"]
    assert spring["law"] == "spring_law:Spring"
    assert spring["status"] == "ok"
    assert all(np.isfinite(spring["rms_error"]))
    assert spring["s_sign_changes"] == [None, None]
    again = load_experiment(tmp_path / "out" / "experiment.toml")
    assert set(again.build_controllers()) == {"PPC", "Spring"}


def test_an_exception_in_a_law_of_ones_own_names_the_law_and_the_line(tmp_path):
    line = LAW.splitlines().index('            raise ZeroDivisionError("no springs left")') + 1
    with pytest.raises(ExperimentError) as caught:
        compare(own_law(tmp_path, -1.0), out=tmp_path / "out")
    assert "controllers.Spring: the law 'spring_law:Spring' raised ZeroDivisionError: no springs left" in str(
        caught.value
    )
    assert re.search(rf"spring_law\.py, line {line}\)", str(caught.value))
    assert not (tmp_path / "out").exists()


def test_a_law_of_ones_own_that_returns_the_wrong_shape_is_told_so(tmp_path):
    with pytest.raises(
        ExperimentError, match=r"controllers\.Spring: .*Spring\.step returned a torque of shape \(1, 1\)"
    ):
        compare(own_law(tmp_path, 0.0), out=tmp_path / "out")


def test_the_summary_file_holds_the_rows(done):
    comparison, _ = done
    pd.testing.assert_frame_equal(
        pd.read_parquet(comparison.out / "summary.parquet"), comparison.rows, check_dtype=False
    )


def test_a_law_of_ones_own_that_ends_the_process_is_named_too(tmp_path):
    text = LAW.replace('ZeroDivisionError("no springs left")', "SystemExit(0)")
    with pytest.raises(ExperimentError, match="raised SystemExit: 0"):
        compare(own_law(tmp_path, -1.0, text), out=tmp_path / "out")
