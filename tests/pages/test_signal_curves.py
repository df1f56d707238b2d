"""Claims about the curves of a report: what is left out lies between what is shown."""

from __future__ import annotations

import base64

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from viewer_cases import awkward_result

from asmc_pin.pages.interactive.signal_curves import WINDOWS, described, extremes, signals_of, window_edges


def unpacked(packed: dict) -> np.ndarray:
    return packed["scale"] * np.frombuffer(base64.b64decode(packed["data"]), dtype="<f2").astype(float)


@settings(deadline=None)
@given(st.integers(2, 3000), st.integers(0, 2**32 - 1))
def test_every_value_lies_between_the_two_of_its_window_and_both_are_values_of_it(ticks: int, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=ticks)
    edges = window_edges(ticks)
    pairs = extremes(values, edges).reshape(-1, 2)
    assert len(pairs) <= WINDOWS
    for (one, other), begin, end in zip(pairs, edges[:-1], edges[1:], strict=True):
        part = values[begin:end]
        assert {one, other} == {part.min(), part.max()}
        first = np.flatnonzero(part == one)[0]
        assert first <= np.flatnonzero(part == other)[0], "in the order in which they came"


def test_a_gap_stays_a_gap() -> None:
    values = np.concatenate([np.ones(100), np.full(100, np.nan)])
    shown = extremes(values, window_edges(200))
    assert np.isfinite(shown[: len(shown) // 2]).all()
    assert np.isnan(shown[len(shown) // 2 :]).all()


def test_half_precision_keeps_three_digits_over_six_decades() -> None:
    from asmc_pin.pages.interactive.signal_curves import _packed

    values = np.logspace(-6, 0, 600) * 37.0
    np.testing.assert_allclose(unpacked(_packed(values)), values, rtol=1e-3)


@pytest.mark.parametrize("key", ["error", "s", "torque", "friction_torque", "tde_error"])
def test_the_page_holds_the_extremes_of_what_was_run(key: str) -> None:
    result = awkward_result()
    data = described(result.dataset, result.monitors)
    told = next(item for item in data["signals"] if item["key"] == key)
    signal = next(item for item in signals_of(result.dataset, result.monitors) if item.key == key)
    values = signal.values[0, :, 1]
    curve = unpacked(told["curves"][0][1])
    assert np.nanmax(curve) == pytest.approx(np.nanmax(values), rel=1e-3)
    assert np.nanmin(curve) == pytest.approx(np.nanmin(values), rel=1e-3)
    assert data["every"] * WINDOWS >= result.dataset.sizes["time"] - 1
    assert len(data["points"]) == len(curve)
    assert told["words"][0][1][0] == pytest.approx(np.nanmax(np.abs(values)), rel=5e-3)
