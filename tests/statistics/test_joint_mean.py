"""The one figure of several joints against scipy's geometric mean, and a joint whose error is exactly 0."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from asmc_pin.metrics import METRICS
from asmc_pin.metrics.metric_registry import LEAST
from asmc_pin.statistics.joint_mean import joint_logs, joint_mean
from asmc_pin.tuning.fair_score import figure_of

FIGURES = np.array([[0.02, 3.0, 5e-5], [1.0, 1e-5, 7.0]])


def test_it_is_scipys_geometric_mean_of_figures_that_matter():
    assert joint_mean(FIGURES, LEAST) == pytest.approx(stats.gmean(FIGURES, axis=1), rel=1e-13)
    assert np.exp(joint_logs(FIGURES, LEAST)) == pytest.approx(FIGURES, rel=1e-13)


@pytest.mark.parametrize("name", ["rms_error", "torque_variation", "ise"])
def test_a_joint_that_stays_exactly_where_it_should_does_not_hide_what_the_others_do(name):
    good, bad = ({name: np.array([0.0, x])} for x in (0.01, 0.02))
    better, worse = (figure_of(x, name, "ok") for x in (good, bad))
    assert 0.0 < better < worse
    assert worse / better == pytest.approx(np.sqrt(2.0)), "as if the still joint were not there but for the root"


def test_what_is_too_small_to_matter_is_equal_and_what_is_a_square_may_be_smaller():
    assert joint_mean([3e-7, 1.0], LEAST) == joint_mean([0.0, 1.0], LEAST)
    assert METRICS["ise"].least == METRICS["rms_error"].least ** 2


def test_a_failure_stays_infinite_and_what_is_undefined_stays_undefined():
    assert joint_mean([[0.0, np.inf], [np.nan, 1.0]], LEAST).tolist() == [np.inf, pytest.approx(np.nan, nan_ok=True)]
