"""Claims about the first words of a report: no winner without certainty, no permission beyond what was seen."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from asmc_pin.metrics import METRICS
from asmc_pin.pages.plain_words.first_screen import allowed, mbar_verdicts, winners
from asmc_pin.pages.plain_words.terms import ANCHORS, term_link, terms_html
from asmc_pin.pages.tables.pair_tables import figures_read, pair_table
from asmc_pin.results.ensemble_summary import paired


def summary(figures: dict[str, np.ndarray], status: str = "ok") -> pd.DataFrame:
    """Rows of a comparison in which every metric is the figure given, shape (trials, joints), by controller."""
    rows = []
    for label, values in figures.items():
        for trial, joints in enumerate(values):
            for joint, value in enumerate(joints):
                row = {"controller": label, "trial": trial, "joint": f"j{joint}", "status": "ok", "end_time": 1.0}
                rows.append(row | dict.fromkeys(METRICS, value))
    found = pd.DataFrame(rows)
    if status != "ok":
        found.loc[found.controller == "C", "status"] = status
        found.loc[found.controller == "C", list(METRICS)] = np.nan  # as after a divergence
    return found


RNG = np.random.default_rng(0)
NOISE = 0.01 * RNG.normal(size=(16, 2))


def test_who_is_ahead_in_every_trial_is_named_with_the_factor_to_the_next() -> None:
    found = dict(winners(summary({"A": 1.0 + NOISE, "B": 2.0 + NOISE, "C": 4.0 + NOISE})))
    said = found["Follows the motion best"]
    assert said.startswith("A: its RMS tracking error, as the geometric mean over the joints, is 0.5")
    assert "times that of B, the next" in said
    assert "Certain for this plant and these gains" in said


def test_what_does_not_differ_beyond_its_spread_is_called_certain_by_nobody() -> None:
    noise = {label: np.exp(0.3 * RNG.normal(size=(16, 2))) for label in "ABC"}
    for _, said in winners(summary(noise)):
        assert "Certain" not in said
        assert "not certain" in said or "No one is ahead" in said


def test_of_single_runs_the_order_is_told_and_its_sureness_is_not() -> None:
    found = dict(winners(summary({"A": np.array([[1.0, 1.0]]), "B": np.array([[4.0, 4.0]])})))
    assert found["Follows the motion best"].startswith(
        "A: its RMS tracking error, as the geometric mean over the joints, is 0.25"
    )
    assert "how sure that is, is not known" in found["Follows the motion best"]


def test_who_diverged_is_named_and_wins_nothing() -> None:
    found = dict(winners(summary({"A": 1.0 + NOISE, "B": 2.0 + NOISE, "C": 0.1 + NOISE}, status="diverged")))
    assert "C" in found["Did not last"]
    assert found["Follows the motion best"].startswith("A:")


def claims(**status: str) -> pd.DataFrame:
    return pd.DataFrame([{"controller": label, "claim": "lemma1", "status": each} for label, each in status.items()])


@pytest.mark.parametrize(
    ("rows", "begins", "names"),
    [
        (claims(A="held", B="held"), "Yes, for A and B", "not asked here"),
        (claims(A="broken", B="held"), "No, for A:", "As far as the run shows, for B"),
        (claims(A="broken"), "No, for A:", "promises nothing"),
        (claims(A="not tested after"), "Not known to its end, for A", "until the trial diverged"),
        (claims(A="held", B="not tested after"), "As far as the run shows, for A", "Not known to its end, for B"),
        (claims(A="not applicable"), "Not known", "no law here has an M̄"),
        (None, "Not known", ""),
    ],
)
def test_an_mbar_is_called_allowed_along_the_motion_alone(rows, begins: str, names: str) -> None:
    said = allowed(mbar_verdicts(rows))
    assert said.startswith(begins)
    assert names in said


def test_one_trial_that_diverged_takes_back_what_the_others_kept() -> None:
    rows = pd.concat([claims(A="held"), claims(A="not tested after"), claims(A="held")])
    assert "at every tick of this motion" not in allowed(mbar_verdicts(rows))


def test_the_condition_is_judged_in_the_first_trial_and_said_of_no_other() -> None:
    verdicts = mbar_verdicts(claims(A="held"))
    assert allowed(verdicts, trials=16).startswith("Yes, for A: at every tick of the first of 16 trials")
    assert "at every tick of this motion" in allowed(verdicts, trials=1)


def test_starts_that_anybody_could_tell_apart_are_not_called_alike() -> None:
    figures = summary({"A": 1.0 + NOISE, "B": 2.0 + NOISE})
    assert "nobody could tell apart" in figures_read(figures, 1e-6)
    assert "nobody could tell apart" not in figures_read(figures, 0.3)
    assert "starts with a standard deviation of 0.3 rad (m)" in figures_read(figures, 0.3)


def test_of_controllers_that_all_diverged_none_is_ahead() -> None:
    figures = summary({"A": 1.0 + NOISE, "B": 2.0 + NOISE})
    figures["status"] = "diverged"
    figures[list(METRICS)] = np.nan
    assert dict(winners(figures))["Follows the motion best"].startswith("No one: all diverged")


def test_trials_that_are_all_alike_are_one_run_and_make_nothing_certain() -> None:
    """Sixteen copies of a run, as without deviation of the starts, have an interval of no width."""
    figures = summary({"A": np.ones((16, 2)), "B": 2.0 * np.ones((16, 2))})
    said = dict(winners(figures))["Follows the motion best"]
    assert said.startswith("A: its RMS tracking error")
    assert "Certain" not in said
    assert said.endswith("Trials all alike: how sure that is, is not known.")
    assert paired(figures) == []
    assert pair_table(figures) is None
    assert "how sure a figure is, is not known" in figures_read(figures, 0.0)
    differs = figures.copy()
    differs.loc[3, "energy"] += 1e-12
    assert len(paired(differs)) == 3


def test_every_term_that_is_linked_has_its_meaning_in_the_glossary() -> None:
    page = terms_html()
    for anchor in ANCHORS:
        assert f'href="#term-{anchor}"' in term_link(anchor, "x")
        assert page.count(f'id="term-{anchor}"') == 1
    assert "**" not in page
    assert "](" not in page
