"""Margins and largest gains: against closed forms, simulation, and one way of computing them by another."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from asmc_pin._typing import Array
from asmc_pin.arms import Arm, load_arm
from asmc_pin.errors import ArmError, ParameterError
from asmc_pin.pages.stability_figures import (
    gain_region_figure,
    period_region_figure,
    save_figures,
    workspace_figure,
)
from asmc_pin.sampled import SampledLoop, closed_loop, spectral_radius, stability
from asmc_pin.sampled.frozen_arms import gravity_stiffness
from asmc_pin.sampled.workspace_worst import workspace_of

UR5_MBAR = 0.5 * np.array([0.1483264, 0.1674553, 0.1504278, 0.0810652, 0.0933441, 0.0171369])
JOINT = """<robot name="turntable"><link name="base"/><link name="table"><inertial>
<mass value="2"/><inertia ixx="0.8" iyy="0.8" izz="0.8" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="{kind}"><parent link="base"/><child link="table"/><axis xyz="0 0 1"/></joint></robot>"""
INERTIA = 0.8


@pytest.fixture(scope="module")
def two_link() -> Arm:
    return load_arm("two_link")


@pytest.fixture(scope="module")
def turntable(tmp_path_factory: pytest.TempPathFactory) -> Arm:
    path: Path = tmp_path_factory.mktemp("arm") / "turntable.urdf"
    path.write_text(JOINT.format(kind="continuous"))
    return load_arm(path)


def two_link_ratios(mbar: float) -> tuple[float, float]:
    """Extreme eigenvalues of M⁻¹M̄ by the paper's closed form of M, over a full turn of joint 2."""
    c = np.cos(np.linspace(-math.pi, math.pi, 4001))
    m11, m12 = 0.65 + 0.2 * c, 0.05 + 0.1 * c
    mass = np.stack([np.stack([m11, m12], -1), np.stack([m12, np.full_like(c, 0.05)], -1)], -2)
    values = np.linalg.eigvalsh(mass)
    return mbar / float(values.max()), mbar / float(values.min())


def test_limits_of_the_inertia_alone_are_those_of_the_closed_form(two_link: Arm) -> None:
    # docs/stability.md: stable where βk_s L (1/a − 1/2) < β + k_s and (β + k_s) L < 4/a − 2 for the extreme a.
    beta, ks, period, mbar = 8.0, 12.0, 0.001, 0.02
    report = stability(two_link.replace(gravity=(0.0, 0.0, 0.0)), mbar, ks, beta, period)
    low, high = two_link_ratios(mbar)
    assert report.ratios == pytest.approx((low, high), rel=1e-5)
    slow, fast = period * (1.0 / low - 0.5), (4.0 / high - 2.0) / period
    limits = report.limits
    assert limits is not None
    assert limits.gain_scale == pytest.approx((beta + ks) / (beta * ks * slow), rel=1e-4)
    assert limits.period == pytest.approx(period * (beta + ks) / (beta * ks * slow), rel=1e-4)
    expected_beta = ks / (ks * slow - 1.0) if ks * slow > 1.0 else fast - ks
    assert limits.beta_scale == pytest.approx(expected_beta / beta, rel=1e-4)
    expected_ks = beta / (beta * slow - 1.0) if beta * slow > 1.0 else fast - beta
    assert limits.ks_scale == pytest.approx(expected_ks / ks, rel=1e-4)
    lowest = 1.0 / (low * (0.5 + (beta + ks) / (beta * ks * period)))
    highest = 4.0 / ((beta + ks) * period + 2.0) / high
    assert limits.gain_margin == pytest.approx((lowest, highest), rel=1e-4)


def late_over_early(loop: SampledLoop, inertia: float) -> float:
    """Growth of a simulated run of (7) on one joint of constant inertia, plain Python, exact between ticks."""
    mbar, period, whole = float(loop.mbar[0]), loop.period, math.floor(loop.delay)
    fraction, kd, kp = loop.delay - whole, float(loop.kd[0]), float(loop.kp[0])
    q, v, before, reported, held = 1.0, 0.0, 0.0, 0.0, [0.0] * (whole + 2)
    sizes = []
    for k in range(6000):
        estimate = (v - before) / period if k else 0.0
        held = [reported - mbar * estimate - mbar * (kd * v + kp * q), *held[:-1]]
        before = v
        for span, torque in ((fraction * period, held[whole + 1]), ((1.0 - fraction) * period, held[whole])):
            q += span * v + 0.5 * span**2 * torque / inertia
            v += span * torque / inertia
        reported = fraction * held[whole + 1] + (1.0 - fraction) * held[whole]
        sizes.append(kp * q * q + v * v)
    return sum(sizes[4000:]) / sum(sizes[2000:4000])


@pytest.mark.parametrize("delay", [0.0, 0.4])
def test_margins_are_where_simulated_runs_begin_to_grow(turntable: Arm, delay: float) -> None:
    report = stability(turntable, 0.3 * INERTIA, 30.0, 40.0, 0.002, delay=delay)
    limits, loop = report.limits, report.loop
    assert limits is not None
    for share, grows in ((0.98, False), (1.02, True)):
        later = SampledLoop(loop.mbar, loop.ks, loop.beta, loop.period, delay=delay + share * limits.delay_margin)
        assert (late_over_early(later, INERTIA) > 1.0) == grows
        # A drive that gives more torque than it reports is an arm of less inertia.
        assert (late_over_early(loop, INERTIA / (share * limits.gain_margin[1])) > 1.0) == grows
        assert (late_over_early(loop, INERTIA / (limits.gain_margin[0] / share)) > 1.0) == grows
        assert (late_over_early(loop.scaled(period=share * limits.period / loop.period), INERTIA) > 1.0) == grows


@pytest.mark.parametrize("timing", [{}, {"acceleration": "position", "filter_hz": 80.0, "delay": 0.7}], ids=str)
def test_configurations_give_the_limits_of_the_modes(two_link: Arm, timing: dict) -> None:
    weightless = two_link.replace(gravity=(0.0, 0.0, 0.0))
    modes = stability(weightless, 0.02, 9.0, 9.0, 0.001, **timing)
    # K_s a hair off a multiple of the identity: the full map is needed, its limits are the same.
    full = stability(weightless, 0.02, [9.0, 9.0 * (1.0 + 1e-9)], 9.0, 0.001, **timing)
    assert not full.loop.modal
    assert full.spectral_radius == pytest.approx(modes.spectral_radius, abs=1e-7)
    assert modes.limits is not None
    assert full.limits is not None
    for name in ("gain_scale", "beta_scale", "ks_scale", "period", "gain_margin", "delay_margin"):
        assert getattr(full.limits, name) == pytest.approx(getattr(modes.limits, name), rel=1e-3), name


def test_worst_configuration_has_that_radius_and_four_times_the_samples_have_none_worse() -> None:
    arm = load_arm("ur5")
    report = stability(arm, UR5_MBAR, [10, 11, 12, 13, 14, 15.0], 10.0, 0.001, limits=False)
    at_worst = closed_loop(arm.mass_matrix(report.worst_q), report.loop).spectral_radius()
    assert float(at_worst) == pytest.approx(report.spectral_radius, abs=1e-9)
    many = workspace_of(arm, samples=8192, seed=7)
    # What decides is how slow the slowest decay is: 1 − ρ.
    assert 1.0 - report.spectral_radius <= (1.0 - float(many.radii(report.loop).max())) * 1.0001


def test_only_the_product_of_gains_and_period_counts() -> None:
    mass = np.array([[0.9, 0.2], [0.2, 0.4]])
    one = SampledLoop([0.2, 0.1], [30.0, 20.0], 25.0, 0.002, filter_hz=40.0, delay=0.5)
    other = SampledLoop([0.2, 0.1], [60.0, 40.0], 50.0, 0.001, filter_hz=80.0, delay=0.5)
    assert float(spectral_radius(mass, one)) == pytest.approx(float(spectral_radius(mass, other)), abs=1e-9)


def test_printed_gains_are_unstable_through_gravity_only(two_link: Arm) -> None:
    report = stability(two_link, 0.01, 1.0, 1.0, 0.001)
    assert report.spectral_radius < 1.0 < report.rest_radius
    assert report.verdict == "unstable"
    assert report.rest_q == pytest.approx([0.5 * math.pi, 0.0], abs=0.01)  # stretched out, straight up
    assert any("unstable through gravity" in line for line in report.lines())
    assert report.remedy.startswith("raise β and K_s: stable where searched from ")
    low, high = map(float, re.findall(r"from (\S+) to (\S+) times", report.remedy)[0])
    for scale in (low, high):
        assert stability(two_link, 0.01, scale, scale, 0.001, samples=256, limits=False).stable
    weightless = stability(two_link.replace(gravity=(0.0, 0.0, 0.0)), 0.01, 1.0, 1.0, 0.001, limits=False)
    assert weightless.verdict == "stable"


def test_an_unstable_loop_has_no_margins_and_strict_json(two_link: Arm) -> None:
    report = stability(two_link, 0.01, 30.0, 30.0, 0.001)
    assert report.spectral_radius == pytest.approx(1.0014, abs=5e-5)  # the paper's M̄ and L
    plain = json.loads(json.dumps(report.to_json_dict(), allow_nan=False))
    assert plain["verdict"] == "unstable"
    assert plain["gain_margin"] == [None, None]
    assert plain["delay_margin_periods"] is None
    # By inertia alone it would be 0.76435; upright the arm falls sooner.
    upright = np.array([0.5 * math.pi, 0.0])
    ends = [
        float(closed_loop(two_link.mass_matrix(upright), report.loop.scaled(ks=x, beta=x),
                          stiffness=gravity_stiffness(two_link, upright)).spectral_radius())
        for x in plain["gain_scale_max"] * np.array([0.9999, 1.0001])
    ]  # fmt: skip
    assert ends[0] < 1.0 < ends[1]
    assert plain["remedy"].startswith("lower β and K_s: stable where searched from 0.")
    assert plain["beta_max"] < 30.0
    assert plain["period_max"] < 0.001


def test_no_gains_are_stable_where_mbar_exceeds_twice_the_inertia(two_link: Arm) -> None:
    limits = stability(two_link, 0.06, 1.0, 1.0, 0.001).limits  # M̄ ≺ 2M ends at 0.0456
    assert limits is not None
    assert limits.gain_scale == limits.beta_scale == limits.ks_scale == limits.period == 0.0


def test_stability_over_ranges_is_the_worst_of_the_arms_within(two_link: Arm) -> None:
    ranged = stability(two_link, 0.02, 6.0, 20.0, 0.001, payload=(0.0, 2.0), armature=(0.0, 0.05))
    assert ranged.limits is not None
    assert ranged.to_json_dict()["payload"]["mass"] == [0.0, 2.0]
    for payload in (0.0, 1.0, 2.0):
        for armature in (0.0, 0.05):
            one = stability(two_link.replace(payload=payload, armature=armature), 0.02, 6.0, 20.0, 0.001)
            assert one.limits is not None
            assert one.spectral_radius <= ranged.spectral_radius * (1.0 + 1e-9)
            assert one.rest_radius <= ranged.rest_radius * (1.0 + 1e-9)
            assert one.limits.gain_margin[0] <= ranged.limits.gain_margin[0] * (1.0 + 1e-3)
            assert one.limits.gain_margin[1] >= ranged.limits.gain_margin[1] * (1.0 - 1e-3)
            assert one.limits.delay_margin >= ranged.limits.delay_margin * (1.0 - 1e-3)


def test_a_search_says_that_it_is_one(two_link: Arm) -> None:
    report = stability(two_link, 0.02, 6.0, 20.0, 0.001, samples=256, limits=False)
    assert "stable where searched" in report.lines()[0]
    assert "it proves nothing" in report.lines()[0]
    assert report.to_json_dict()["kind"] == "searched"


def test_a_delay_margin_without_an_end_is_called_what_it_is(tmp_path: Path) -> None:
    path = tmp_path / "turntable.urdf"
    path.write_text(JOINT.format(kind="continuous"))
    report = stability(load_arm(path), 0.1 * INERTIA, 0.1, 0.1, 0.001)
    assert "extra delay more than 64 periods (where the search ends)" in report.lines()[-1]
    plain = report.to_json_dict()
    assert (plain["delay_margin_periods"], plain["delay_searched_periods"]) == (None, 64.0)


def test_viscous_friction_that_is_counted_on_slows_divergence(two_link: Arm) -> None:
    without = stability(two_link, 0.01, 30.0, 30.0, 0.001, limits=False)
    with_it = stability(two_link, 0.01, 30.0, 30.0, 0.001, viscous=[8.0, 4.0], limits=False)
    assert with_it.spectral_radius < without.spectral_radius


@pytest.mark.parametrize(
    ("change", "parameter"),
    [
        ({"samples": 0}, "samples"),
        ({"samples": 2.5}, "samples"),
        ({"viscous": -1.0}, "viscous"),
        ({"viscous": [1.0, 2.0, 3.0]}, "viscous"),
        ({"box": {"elbow": (0.0, 1.0)}}, "box"),
        ({"box": {"joint_1": (1.0, 0.0)}}, "box"),
        ({"delay": -1.0}, "delay"),
    ],
)
def test_bad_options_are_refused_by_name(two_link: Arm, change: dict, parameter: str) -> None:
    with pytest.raises(ParameterError) as caught:
        stability(two_link, 0.01, 1.0, 1.0, 0.001, **change)
    assert caught.value.parameter == parameter


def test_mbar_of_another_arm_is_refused(two_link: Arm) -> None:
    with pytest.raises(ParameterError, match=r"mbar: .* expected a number or 2 of them"):
        stability(two_link, [0.1, 0.2, 0.3], 1.0, 1.0, 0.001)


def test_an_endless_slide_needs_a_box(tmp_path: Path) -> None:
    path = tmp_path / "slide.urdf"
    limit = '<limit effort="10" velocity="1" lower="0" upper="0"/>'
    path.write_text(JOINT.format(kind="prismatic").replace('xyz="0 0 1"/>', f'xyz="0 0 1"/>{limit}'))
    arm = load_arm(path)
    with pytest.raises(ArmError, match="--box turn=lo:hi"):
        stability(arm, 0.5, 1.0, 1.0, 0.001)
    assert stability(arm, 0.5, 1.0, 1.0, 0.001, box={"turn": (0.0, 0.5)}, limits=False).verdict == "stable"


def test_figures_are_written_for_screen_and_print_without_a_date(two_link: Arm, tmp_path: Path) -> None:
    files = save_figures(two_link, SampledLoop([0.01, 0.01], 10.0, 10.0, 0.001), tmp_path / "new")
    assert sorted(path.name for path in files) == sorted(path.name for path in (tmp_path / "new").iterdir())
    assert [path.suffix for path in files] == [".png", ".pdf"] * 2
    assert not any(b"CreationDate" in path.read_bytes() for path in files)


def test_figures_show_the_boundary_and_the_loop_in_question(two_link: Arm) -> None:
    loop = SampledLoop([0.01, 0.01], 10.0, 10.0, 0.001)
    for figure in (gain_region_figure(two_link, loop, span=5.0), period_region_figure(two_link, loop, span=5.0)):
        axes = figure.axes[0]
        labels = [text.get_text() for text in axes.get_legend().get_texts()]
        assert "ρ = 1" in labels
        assert len(labels) == 2
        assert axes.get_xlabel()
        assert axes.get_ylabel()
    # At 22/22 gravity makes the loop unstable around the upright arm only: an island in the map.
    map_of = workspace_figure(two_link, SampledLoop([0.01, 0.01], 22.0, 22.0, 0.001), (0, 1), np.zeros(2), gravity=True)
    island: Array = map_of.axes[0].collections[1].get_paths()[0].vertices  # type: ignore[assignment]
    assert island.mean(axis=0) == pytest.approx([0.5 * math.pi, 0.0], abs=0.1)
    with pytest.raises(ParameterError, match="joints: "):
        workspace_figure(two_link, loop, (1, 1), np.zeros(2))


def test_a_range_of_gains_between_two_values_of_the_grid_is_not_denied(two_link: Arm) -> None:
    """β = k_s = 6.4 1/s are stable here, and the search steps over them: it may say what it found, no more."""
    loop = {"mbar": 0.016485, "period": 0.002, "acceleration": "position"}
    assert stability(two_link, ks=6.43, beta=6.43, limits=False, **loop).stable  # type: ignore[arg-type]
    report = stability(two_link, ks=30.0, beta=30.0, **loop)  # type: ignore[arg-type]
    assert not report.stable
    assert "were found stable" in report.remedy
    assert "are stable with this M̄" not in report.remedy


def test_limits_and_margins_say_that_they_were_searched_also_below_a_proof(two_link: Arm) -> None:
    """ "What is proven stands below" the verdict, and so do they."""
    lines = stability(two_link, 0.02, 5.0, 5.0, 0.001).lines()
    told = [line for line in lines if "may" in line or "margins" in line]
    assert len(told) == 3
    assert all("where searched" in line for line in told)
