"""Claims about what `compare` judges: every arm that a run has, phase by phase and at both ends of its scatter."""

from __future__ import annotations

import copy
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from paths import CASES

from asmc_pin.arms import load_arm
from asmc_pin.condition import lemma1_norm
from asmc_pin.controllers import Ppc
from asmc_pin.experiment import Experiment, load_experiment
from asmc_pin.plant import PayloadChange, Plant, Spread, moving_arms
from asmc_pin.sampled import stability
from asmc_pin.sampled.gain_warnings import gain_warnings
from asmc_pin.study import Comparison, compare
from asmc_pin.words.remedy_texts import MBAR_REMEDY

SET_DOWN = CASES / "experiments" / "payload_set_down.toml"
FAR_TOO_LARGE = CASES / "experiments" / "mbar_far_too_large.toml"


@contextmanager
def without_pages() -> Iterator[None]:
    """Without figures and report, which take most of the time and are not what is looked at."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys.modules["asmc_pin.study.comparison_files"], "draw_figures", lambda *_: [])
        patch.setattr("asmc_pin.pages.comparison_page.report_html", lambda *_: None)
        yield


@pytest.fixture(scope="module")
def set_down(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    with without_pages():
        return compare(load_experiment(SET_DOWN), out=tmp_path_factory.mktemp("phases") / "out")


@pytest.fixture(scope="module")
def diverged(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    return compare(load_experiment(FAR_TOO_LARGE), out=tmp_path_factory.mktemp("far") / "out")


# A payload that is set down


def test_lemma_1_is_judged_with_what_is_carried_at_the_time(set_down: Comparison) -> None:
    found = set_down.lemma1["PPC"]
    time, setpoint = set_down.experiment.setpoints()
    loaded = set_down.arm
    mbar = np.array(set_down.experiment.defaults["mbar"])
    before, after = found.parts
    for part, arm, ticks in (
        (before, loaded, time < 0.5 - 1e-9),
        (after, loaded.replace(payload=None), time > 0.5 - 1e-9),
    ):
        norm = lemma1_norm(arm.mass_matrix(setpoint.q[ticks]), mbar)
        assert (part.lower, part.upper) == pytest.approx((norm.min(), norm.max()))
        assert part.worst_time == time[ticks][norm.argmax()]
    assert (before.verdict, after.verdict, found.verdict) == ("unrefuted", "violated", "violated")
    assert 5.0 < after.lower < after.upper < 6.2
    assert found.worst is after


def test_the_verdict_names_the_phase_that_is_worst_with_its_payload(set_down: Comparison) -> None:
    (warning,) = (line for line in set_down.warnings if line.startswith("Lemma 1"))
    assert warning.startswith(
        "Lemma 1 is violated along the reference on plain (from 0.5 s on, carrying nothing) by the M̄ of PPC"
    )
    assert "in 1 of 2 phases" in warning
    (note,) = (line for line in set_down.notes if line.startswith("Lemma 1"))
    assert "is violated (sampled at the control ticks); worst on plain (from 0.5 s on, carrying nothing)" in note
    assert "On plain with payload 10 kg (until 0.5 s): ‖I − M⁻¹M̄‖₂ = 0.9766 … 0.9848, unrefuted" in note
    assert "On plain (from 0.5 s on, carrying nothing): ‖I − M⁻¹M̄‖₂ = 5.4495 … 6.1159, violated" in note
    assert "titles name the arm of t = 0; it carries from 0.5 s on 0 kg" in set_down.notes
    told = json.loads(json.dumps(set_down.to_json_dict(), allow_nan=False))["controllers"]["PPC"]
    assert told["lemma1_verdict"] == "violated"
    assert told["lemma1_hypotheses"]["payload"] is None
    assert told["lemma1_along_reference"] == [set_down.lemma1["PPC"].lower, set_down.lemma1["PPC"].upper]
    first, second = told["lemma1_parts"]
    assert (first["span"], second["span"]) == ([0.0, 0.5], [0.5, None])
    assert (first["hypotheses"]["payload"]["mass"], second["hypotheses"]["payload"]) == (10.0, None)


def test_the_sampled_loop_is_judged_in_the_phase_in_which_it_is_unstable(set_down: Comparison) -> None:
    (warning,) = (line for line in set_down.warnings if "sampled loop" in line)
    assert "unstable from 0.5 s on, carrying nothing, at q = (" in warning
    mbar = set_down.experiment.defaults["mbar"]
    assert stability(set_down.arm, mbar, 10.0, 10.0, 0.001, limits=False).verdict == "stable"
    assert stability(set_down.arm.replace(payload=None), mbar, 10.0, 10.0, 0.001, limits=False).verdict == "unstable"


def test_a_change_after_the_end_of_the_run_is_no_phase_of_it() -> None:
    plant = Plant(load_arm("two_link"), payload_changes=[PayloadChange(time=0.5, payload=1.0)])
    assert [item.ticks for item in moving_arms(plant, 0.001, 0.5)] == [slice(0, None)]
    assert [item.ticks for item in moving_arms(plant, 0.001, 0.501)] == [slice(0, 500), slice(500, None)]


def test_a_trial_of_a_sweep_that_is_run_again_is_judged_with_the_links_that_were_drawn_for_it() -> None:
    plant = Plant(load_arm("two_link"), spread=Spread(mass=0.1), first_trial=7)
    drawn, *_ = moving_arms(plant, 0.001, 0.2)
    q = np.array([0.3, -0.4])
    assert drawn.links == "links as drawn for trial 7"
    assert np.array_equal(drawn.arm.mass_matrix(q), plant.for_trials([0]).arms[0].mass_matrix(q))
    other, *_ = moving_arms(Plant(load_arm("two_link"), spread=Spread(mass=0.1)), 0.001, 0.2)
    assert not np.allclose(drawn.arm.mass_matrix(q), other.arm.mass_matrix(q), rtol=1e-3)


def test_of_two_changes_in_one_tick_the_later_one_counts() -> None:
    arm = load_arm("two_link")
    changes = [PayloadChange(time=0.1002, payload=2.0), PayloadChange(time=0.1, payload=1.0)]
    first, second = moving_arms(Plant(arm, payload_changes=changes), 0.001, 0.2)
    assert first.arm.payload is None
    assert second.arm.payload is not None
    assert second.arm.payload.mass == 2.0
    late = moving_arms(Plant(arm, payload_changes=[PayloadChange(time=0.0, payload=1.0)]), 0.001, 0.2)
    assert [item.arm.payload.mass for item in late if item.arm.payload] == [1.0]


# Links that scatter


def scattered(**spread: float) -> Experiment:
    data: dict[str, Any] = {
        "name": "scattered",
        "arm": "two_link",
        "period": 0.001,
        "duration": 0.2,
        "seed": 3,
        "plant": {"effort_limit": float("inf"), "spread": spread},
        "reference": {"kind": "quintic", "start": [0.3, 0.2], "targets": [[0.35, 0.15]], "move": 0.2},
        "defaults": {"mbar": [0.04, 0.04], "ks": 8.0, "beta": 8.0},
        "controllers": {"PPC": {"law": "ppc"}},
    }
    return Experiment.from_dict(copy.deepcopy(data))


def test_both_ends_of_the_scatter_and_the_arm_that_runs_are_judged(tmp_path: Path) -> None:
    experiment = scattered(mass=0.5)
    with without_pages():
        comparison = compare(experiment, out=tmp_path / "out")
    drawn, light, heavy = comparison.lemma1["PPC"].parts
    _, setpoint = experiment.setpoints()
    mass = experiment.build_arm().mass_matrix(setpoint.q)
    # All links lighter by one factor: M(q) is that much smaller, whatever q is.
    for part, factor in ((light, np.exp(-1.0)), (heavy, np.exp(1.0))):
        norm = lemma1_norm(factor * mass, np.array([0.04, 0.04]))
        assert (part.lower, part.upper) == pytest.approx((norm.min(), norm.max()), rel=1e-9)
    assert (light.verdict, heavy.verdict) == ("violated", "unrefuted")
    (warning,) = (line for line in comparison.warnings if line.startswith("Lemma 1"))
    assert "two_link (all links 2 standard deviations lighter)" in warning
    claim = comparison.theorems.of_first_trial("PPC")["lemma1"]
    norm = comparison.theorems.dataset.lemma1_norm.to_numpy()[0, 0]
    assert drawn.upper == pytest.approx(norm.max(), rel=1e-3)
    assert claim["status"] == ("held" if norm.max() < 1.0 else "broken")


def test_the_ends_of_the_scatter_are_bodies_and_leave_the_payload_alone() -> None:
    arm = load_arm("ur5").replace(payload=2.0)
    light, heavy = Spread(mass=0.2, com=0.01, inertia=0.1).ends(arm)
    q = np.random.default_rng(0).uniform(-3.0, 3.0, (50, arm.nv))
    least = [np.linalg.eigvalsh(item.mass_matrix(q))[:, 0] for item in (light, arm, heavy)]
    assert np.all(least[0] > 0.0)
    traces = [np.trace(item.mass_matrix(q), axis1=1, axis2=2) for item in (light, arm, heavy)]
    assert np.all(traces[0] < traces[1])
    assert np.all(traces[1] < traces[2])
    assert light.payload == heavy.payload == arm.payload
    near = Spread(com=10.0).ends(arm)[0]
    assert all(np.linalg.norm(link.lever) < 1e-12 for link in near.replace(payload=None).model.inertias[1:])


def test_only_the_friction_that_the_scatter_leaves_is_counted_on() -> None:
    assert Spread(friction=0.3).least_friction == pytest.approx(np.exp(-0.6))
    assert Spread(mass=0.3).least_friction == 1.0


# A run that is cut short, and one remedy for one trouble


def test_no_theorem_is_held_over_a_run_that_diverged(diverged: Comparison) -> None:
    claims = diverged.theorems.claims
    assert (diverged.rows.status == "diverged").all()
    assert set(claims.status) <= {"broken", "not tested after", "not applicable"}
    cut = claims[claims.status != "not applicable"]
    ends = diverged.rows.groupby("controller").end_time.first()
    assert (cut.until == cut.controller.map(ends)).all()
    assert set(ends) == {0.016}
    text = (diverged.out / "summary.md").read_text(encoding="utf-8")
    page = (diverged.out / "report.html").read_text(encoding="utf-8")
    section = page.split('id="theorems"')[1].split('id="conditions"')[0]
    assert 'class="held"' not in section
    assert "<b>held</b>" not in section
    for written in (text, section):
        assert "not tested after 0.016 s" in written or "<b>not tested</b> after 0.016 s" in written
    told = json.loads(json.dumps(diverged.to_json_dict(), allow_nan=False))["controllers"]["Proposed"]["theorems"]
    assert (told["eq21"]["status"], told["eq21"]["until"]) == ("not tested after", 0.016)


def test_compare_advises_what_stability_finds_and_nothing_else(diverged: Comparison) -> None:
    experiment = diverged.experiment
    report = stability(experiment.build_arm(), [9.0, 5.0], 10.0, 10.0, 0.001)
    assert MBAR_REMEDY in report.remedy
    assert f"remedy: {report.remedy}" in report.lines()
    assert report.to_json_dict()["remedy"] == report.remedy
    (lemma,) = (line for line in diverged.warnings if "Lemma 1" in line)
    (loop,) = (line for line in diverged.warnings if "sampled loop" in line)
    assert lemma.endswith(f"; {MBAR_REMEDY}")
    assert loop.endswith(f"; {report.remedy}")
    assert MBAR_REMEDY in diverged.theorems.of_first_trial("PPC")["lemma1"]["reason"]


@pytest.mark.parametrize(("gain", "way"), [(30.0, "lower"), (1.0, "raise")])
def test_what_is_advised_is_stable_and_the_same_before_a_run(gain: float, way: str) -> None:
    arm = load_arm("two_link")
    report = stability(arm, 0.01, gain, gain, 0.001)
    (warning,) = gain_warnings(arm, {"PPC": Ppc(mbar=0.01, ks=gain, beta=gain, period=0.001)})
    assert warning.endswith(report.remedy)
    assert report.remedy.startswith(f"{way} β and K_s: stable where searched from ")
    ends = [float(word) for word in report.remedy.split("from ")[1].split(" times")[0].split(" to ")]
    for factor in (1.001 * ends[0], 0.999 * ends[1]):
        assert stability(arm, 0.01, factor * gain, factor * gain, 0.001, limits=False).verdict == "stable"
    for factor in (0.98 * ends[0], 1.02 * ends[1]):
        assert stability(arm, 0.01, factor * gain, factor * gain, 0.001, limits=False).verdict == "unstable"
    assert stability(arm, 0.01, 15.0, 15.0, 0.001).remedy == ""
