"""What a comparison says of the theorems: the same verdicts in tables, files, pages and JSON, with their reasons."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pandas as pd
import pytest

from asmc_pin.engine import rollout
from asmc_pin.experiment import Experiment
from asmc_pin.monitors import BAEK, CAUSES, STATEMENTS, claim_rows, monitor
from asmc_pin.pages.theorem_figures import draw_theorems, theorem_figure
from asmc_pin.pages.theorem_tables import reasons, theorem_lines, theorem_table, theorems_latex, theorems_markdown
from asmc_pin.results.result_folder import load_result
from asmc_pin.study import Comparison, compare

EXPERIMENT: dict[str, Any] = {
    "name": "theorems",
    "arm": "two_link",
    "period": 0.002,
    "duration": 0.4,
    "ensemble": {"trials": 1},
    "plant": {"friction": {"coulomb": [2.0, 0.5]}, "effort_limit": [60.0, 15.0]},
    "reference": {"kind": "multisine", "offset": [-1.2, 0.3], "amplitude": [0.4, 0.6], "frequency": [0.5, 0.7]},
    "defaults": {"mbar": [0.04, 0.03], "ks": 8.0, "beta": 8.0},
    "controllers": {
        "PPC": {"law": "ppc"},
        "Proposed": {"law": "baek2016", "phi": 400.0, "alpha": 0.05, "epsilon": 0.01},
        "CT": {"law": "computed_torque"},
    },
}


@pytest.fixture(scope="module")
def comparison(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    return compare(Experiment.from_dict(EXPERIMENT), out=tmp_path_factory.mktemp("theorems") / "out")


def test_the_verdicts_are_those_of_the_monitors_on_the_same_run(comparison: Comparison) -> None:
    experiment = Experiment.from_dict(EXPERIMENT)
    plant, law = experiment.build_plant(), experiment.build_controllers()["Proposed"]
    run = rollout(plant, law, experiment.build_reference(), experiment.duration)
    expected = claim_rows({"Proposed": monitor(run, plant, law)})
    found = comparison.theorems.claims
    pd.testing.assert_frame_equal(found[found.controller == "Proposed"].reset_index(drop=True), expected)


def test_what_lies_on_disk_is_what_was_found(comparison: Comparison) -> None:
    result = load_result(comparison.out)
    assert result.claims is not None
    assert result.monitors is not None
    pd.testing.assert_frame_equal(result.claims, comparison.theorems.claims)
    assert np.array_equal(result.monitors.tde_error, comparison.theorems.dataset.tde_error, equal_nan=True)
    assert list(result.monitors.controller.to_numpy()) == list(result.dataset.controller.to_numpy())
    for name in ("monitors.nc", "claims.parquet"):
        (comparison.out / name).rename(comparison.out / f"{name}.away")
    try:
        older = load_result(comparison.out)  # a result made before there were monitors
        assert older.claims is None
        assert older.monitors is None
    finally:
        for name in ("monitors.nc", "claims.parquet"):
            (comparison.out / f"{name}.away").rename(comparison.out / name)


def test_json_has_each_claim_of_each_controller(comparison: Comparison) -> None:
    controllers = json.loads(json.dumps(comparison.to_json_dict(), allow_nan=False))["controllers"]
    for figures in controllers.values():
        assert set(figures["theorems"]) == set(STATEMENTS)
    proposed = controllers["Proposed"]["theorems"]
    assert proposed["lemma1"] == {
        "status": "held",
        "checked": 201,
        "broken": 0,
        "first_time": None,
        "worst_time": None,
        "amount": None,
        "unit": "1",
        "causes": {},
        "until": None,
        "reason": proposed["lemma1"]["reason"],
    }
    assert {item["status"] for item in controllers["CT"]["theorems"].values()} == {"not applicable"}
    assert "no M̄" in controllers["CT"]["theorems"]["eq16"]["reason"]


def test_tables_pages_and_notes_give_every_verdict_with_its_reason(comparison: Comparison) -> None:
    claims = comparison.theorems.claims
    table = theorem_table(claims)
    assert table.header == ["claim", "PPC", "Proposed", "CT (knows the model)"]
    assert [row[0].partition(":")[0] for row in table.rows] == [item.title for item in BAEK.values()]
    assert table.rows[3][1] == table.rows[3][3] == "not applicable"
    assert table.rows[3][2].split()[0] in ("held", "broken")
    summary = (comparison.out / "summary.md").read_text(encoding="utf-8")
    assert theorems_markdown(claims) in summary
    latex = (comparison.out / "summary.tex").read_text(encoding="utf-8")
    assert theorems_latex(claims, comparison.about.title) in latex
    assert latex.isascii()
    (row,) = [line for line in latex.splitlines() if "raggedright CT (knows the model)" in line]
    assert row.count("raggedright --}") == len(BAEK)
    page = (comparison.out / "report.html").read_text(encoding="utf-8")
    for _, lines in reasons(claims):
        for line in lines:
            assert line in summary
            assert line.replace("'", "&#x27;").replace("<", "&lt;") in page
    (line,) = theorem_lines(claims)  # of PPC and CT there is nothing to say in a line
    assert line.startswith("theorems on Proposed: ")
    assert line in comparison.notes
    assert all(item.title in line for item in BAEK.values())


def test_trials_are_summed_up_by_the_worst_of_them(comparison: Comparison) -> None:
    one = comparison.theorems.claims.query("controller == 'Proposed' and claim == 'eq21'").iloc[0].to_dict()
    held = {**one, "status": "held", "broken": 0, "checked": 100}
    none = dict.fromkeys(CAUSES, 0)
    broken = (
        held | none | {"trial": 1, "status": "broken", "broken": 50, "first_time": 0.25, "amount": 0.5, "drive": 50}
    )
    worse = {**broken, "trial": 2, "first_time": 0.5, "amount": 2.0, "saturation": 50, "drive": 0, "reason": "late"}
    rows = pd.DataFrame([held, broken, worse])
    cell = theorem_cell(rows)
    told = "broken by saturation and drive at 0.25 s, up to 2 rad/s over, in 100 of 300 ticks from t_ε on (33 %)"
    assert cell == f"{told}; 2 of 3 trials broken"
    rows.loc[2, "until"] = 0.6
    assert theorem_cell(rows) == f"{told}; 2 of 3 trials broken; 1 diverged"
    rows = pd.DataFrame([held, {**held, "trial": 1, "status": "not tested after", "until": 0.5}])
    assert theorem_cell(rows) == "held or not tested after 0.5 s, where it diverged; not broken before"


def theorem_cell(rows: pd.DataFrame) -> str:
    return theorem_table(rows).rows[list(STATEMENTS).index("eq21")][1]


def test_the_figure_shows_all_seven_and_only_where_there_is_something(comparison: Comparison, tmp_path: Any) -> None:
    dataset = comparison.theorems.dataset
    labels = [axis.get_ylabel() for axis in theorem_figure(dataset.isel(trial=0)).axes]
    for part in ("Lemma 1", "TDE error", "N_{k-1}", "bound dotted", "V$ of (12)", "dot{V}", "bound (21)"):
        assert sum(part in label for label in labels) == 1
    figure = theorem_figure(dataset.isel(trial=0))
    norm = figure.axes[0]
    lines = [line for line in norm.get_lines() if len(np.asarray(line.get_xdata())) > 2]
    assert len(lines) == 2  # PPC and the proposed law; computed torque has no M̄
    shown = np.asarray(lines[0].get_ydata(), dtype=float)
    assert shown == pytest.approx(dataset.lemma1_norm.to_numpy()[0, 0])
    size = np.linalg.norm(dataset.tde_error.to_numpy()[0, 0], axis=-1)
    ratio = np.asarray(figure.axes[2].get_lines()[0].get_ydata(), dtype=float)
    assert np.nanmax(ratio) == pytest.approx(np.nanmax(size[1:] / size[:-1]))
    lyapunov = figure.axes[labels.index(r"$V$ of (12) [rad$^2$/s$^2$]")]
    proposed = dataset.sel(controller="Proposed").isel(trial=0)
    curve, broken = lyapunov.get_lines()
    assert np.array_equal(np.asarray(curve.get_ydata(), dtype=float), proposed.lyapunov, equal_nan=True)
    marked = comparison.theorems.claims.query("controller == 'Proposed' and claim == 'eq16'").broken.item()
    assert len(np.asarray(broken.get_xdata())) == marked
    baseline = dataset.sel(controller=["CT (knows the model)"])
    assert draw_theorems(baseline, tmp_path) is None
    assert not list(tmp_path.iterdir())
    assert draw_theorems(dataset, tmp_path) == tmp_path / "theorems.png"


def test_arrays_of_a_law_without_mbar_are_not_defined(comparison: Comparison) -> None:
    one = comparison.theorems.dataset.sel(controller="CT (knows the model)")
    for name in ("tde_error", "lemma1_norm", "lyapunov", "s_bound", "gain_bound"):
        assert not np.isfinite(one[name]).any()


def test_the_figure_of_a_trial_without_gains_motion_or_error(comparison: Comparison, tmp_path: Any) -> None:
    still = comparison.theorems.dataset.copy(deep=True)
    still["tde_error"][:, :, 1:] = np.nan  # no ratio is defined
    still["lyapunov"][:, :, 1:] = np.nan  # diverged at once
    still["claimed"][:] = 0.0
    figure = theorem_figure(still.isel(trial=0))
    assert not np.isfinite(np.asarray(figure.axes[2].get_lines()[0].get_ydata(), dtype=float)).any()
    assert draw_theorems(still, tmp_path) == tmp_path / "theorems.png"
