"""The page that says how slow a loop may run: its curves are those of the map, and it shows what it says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from asmc_pin.arms import load_arm
from asmc_pin.errors import ParameterError
from asmc_pin.pages.stability_page import write_stability_page
from asmc_pin.sampled import SampledLoop, drift_error, stability
from asmc_pin.sampled.frozen_arms import frozen_arms
from asmc_pin.sampled.loop_curves import LoopCurve, loop_curves
from asmc_pin.sampled.noise.noise_response import noise_rms
from asmc_pin.sampled.noise.sensor_model import loop_sensor
from asmc_pin.sampled.workspace_worst import workspace_of


def test_curves_end_where_the_loop_does_and_pass_through_the_loop_itself() -> None:
    arm = load_arm("two_link")
    sensor = loop_sensor(2, encoder_bits=18)
    loop = SampledLoop([0.02, 0.02], 12.0, 12.0, 0.001, **sensor.timing)
    report = stability(arm, loop.mbar, loop.ks, 12.0, loop.period, sensor=sensor, samples=256)
    spaces = [workspace_of(arm, samples=64, gravity=gravity) for gravity in (False, True)]
    drift = np.array([3.0, 1.0])
    found = loop_curves(spaces, loop, drift, sensor, [report.worst_q, report.rest_q])
    curves: dict[str, LoopCurve] = {curve.name: curve for curve in found.curves}
    assert list(curves) == ["period", "filter_hz", "delay"]
    period = curves["period"]
    here = int(np.flatnonzero(np.isclose(period.values, loop.period))[0])
    assert period.stable[here]
    assert period.radius[here] == pytest.approx(max(report.spectral_radius, report.rest_radius), abs=1e-6)
    np.testing.assert_allclose(period.drift_error[here], drift_error(loop, drift))
    assert report.limits is not None
    assert not period.stable[period.values > report.limits.period].any()
    assert period.torque_rms is not None
    looked_at = np.concatenate([spaces[1].at(np.array([report.worst_q, report.rest_q])), spaces[1].points[:12]])
    mass, stiffness = spaces[1].frozen(looked_at)
    for name, value in (("period", loop.period / 4.0), ("delay", 1.0)):
        at = int(np.abs(curves[name].values - value).argmin())
        other = replace(loop, **{name: float(curves[name].values[at])})
        torque, _ = noise_rms(mass, other, sensor, stiffness=stiffness)
        np.testing.assert_allclose(curves[name].torque_rms[at], torque.max(axis=0))
    for curve in found.curves:
        assert np.isnan(curve.drift_error[~curve.stable]).all()


def test_over_a_range_of_payloads_the_curve_at_the_loop_itself_is_what_was_found_worst() -> None:
    arms = frozen_arms(load_arm("two_link"), payload=(0.0, 3.0))
    loop = SampledLoop([0.01, 0.01], 10.0, 10.0, 0.001)
    report = stability(load_arm("two_link"), loop.mbar, loop.ks, 10.0, loop.period, payload=(0.0, 3.0), samples=256)
    assert report.rest.where["worst_payload"]["mass"] == 3.0
    spaces = [workspace_of(arms, samples=64, gravity=gravity) for gravity in (False, True)]
    found = loop_curves(spaces, loop, np.ones(2), None, [report.worst_q, report.rest_q])
    period = found.curves[0]
    here = int(np.flatnonzero(np.isclose(period.values, loop.period))[0])
    assert period.radius[here] == pytest.approx(report.rest_radius, abs=1e-6)


def test_the_page_holds_verdict_ranges_and_a_figure_for_each_of_period_filter_and_delay(tmp_path: Path) -> None:
    arm, sensor = load_arm("two_link"), loop_sensor(2, encoder_bits=18)
    report = stability(arm, 0.02, 12.0, 12.0, 0.001, sensor=sensor, samples=64, limits=False)
    page = tmp_path / "slow.html"
    write_stability_page(report, frozen_arms(arm), page, sensor=sensor)
    text = page.read_text(encoding="utf-8")
    assert text.count("<img ") == 3
    assert "one count of the encoder is worth" in text
    assert "A search refutes stability; it does not prove it." in text
    assert "http" not in text.split("<body", 1)[1].split("base64", 1)[0]
    write_stability_page(report, frozen_arms(arm), tmp_path / "slow.md")
    assert {path.name for path in tmp_path.glob("slow_*.png")} == {
        "slow_period.png", "slow_filter_hz.png", "slow_delay.png",
    }  # fmt: skip
    with pytest.raises(ParameterError, match=r"neither \.html nor \.md"):
        write_stability_page(report, frozen_arms(arm), tmp_path / "slow.txt")
