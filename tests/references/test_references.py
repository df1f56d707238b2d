"""References: exact derivatives, smoothness, what they hold, and what the check before a run says."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from asmc_pin.arms import load_arm
from asmc_pin.controllers import Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.references import (
    REFERENCES,
    CsvPath,
    Fourier,
    Multisine,
    Quintic,
    Ramps,
    Reference,
    check_reference,
    required_torque,
)

QUINTIC = Quintic(start=[0.0, 1.0], targets=[[1.0, 0.5], [-0.5, 2.0]], times=[0.5, 2.0], move=[0.8, 1.1])
RAMPS = Ramps(points=[[0.0, 1.0], [1.0, -0.5], [1.0, -0.5], [0.2, 0.3]], times=[0.3, 1.0, 1.7, 3.0])
MULTISINE = Multisine(
    offset=[0.1, -0.3], amplitude=[[0.5, 0.2], [0.3, 0.1]], frequency=[0.2, 0.7], phase=[[0.0, 1.0], [0.4, -2.0]]
)
RISING = Multisine(offset=[0.1, -0.3], amplitude=[0.5, 0.3], frequency=[0.4, 1.1], phase=0.7, rise=1.3)
FOURIER = Fourier(
    offset=[0.1, 0.2], a=[[0.3, -0.1, 0.2], [0.1, 0.4, 0.0]], b=[[0.0, 0.2, 0.5], [-0.3, 0.1, 0.1]], base_hz=0.25
)
TABLE = np.column_stack([np.linspace(0.2, 3.0, 15), np.sin(np.linspace(0, 4, 15)), np.cos(np.linspace(0, 5, 15))])


def write_csv(path: Path, table: np.ndarray, header: str = "t,q1,q2") -> Path:
    path.write_text("\n".join([header, *(",".join(repr(float(x)) for x in row) for row in table)]) + "\n")
    return path


EXAMPLES: dict[str, Callable[[Path], Reference]] = {
    "quintic": lambda path: QUINTIC,
    "ramps": lambda path: RAMPS,
    "multisine": lambda path: MULTISINE,
    "rising": lambda path: RISING,
    "fourier": lambda path: FOURIER,
    "rising fourier": lambda path: Fourier(offset=FOURIER.offset, a=FOURIER.a, b=FOURIER.b, base_hz=0.25, rise=0.9),
    "csv": lambda path: CsvPath(path=path),
    "csv at rest": lambda path: CsvPath(path=path, ends="rest"),
    "csv quintic": lambda path: CsvPath(path=path, spline="quintic"),
    "csv quintic at rest": lambda path: CsvPath(path=path, spline="quintic", ends="rest"),
}
"""One or more of every kind; what is made of them is asked of all."""


def example(kind: str, folder: Path) -> Reference:
    return EXAMPLES[kind](write_csv(folder / "path.csv", TABLE))


def test_there_is_an_example_of_every_registered_kind(tmp_path: Path) -> None:
    kinds = {type(example(kind, tmp_path)) for kind in EXAMPLES}
    assert {cls for cls in REFERENCES.values() if not hasattr(cls, "on")} == kinds


# Where a derivative that the kind does not promise to be smooth has a corner; there no difference quotient is exact.
CORNERS = {
    "quintic": [0.5, 1.3, 2.0, 3.1],
    "ramps": [0.3, 1.0, 1.7, 3.0],
    "rising": [1.3],
    "rising fourier": [0.9],
} | {kind: list(TABLE[:, 0]) for kind in EXAMPLES if "csv" in kind}


def derivative(reference: Reference, t: np.ndarray, field: str, h: float = 1e-4) -> np.ndarray:
    """Five-point difference quotient: its error is h⁴ times the fifth derivative of the field."""
    at = [getattr(reference.evaluate(t + i * h), field) for i in (-2, -1, 1, 2)]
    return (at[0] - 8.0 * at[1] + 8.0 * at[2] - at[3]) / (12.0 * h)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_velocity_and_acceleration_are_the_derivatives(kind: str, tmp_path: Path) -> None:
    reference = example(kind, tmp_path)
    t = np.random.default_rng(1).uniform(0.01, 3.4, 400)
    t = t[[all(abs(x - c) > 1e-3 for c in CORNERS.get(kind, [])) for x in t]]
    motion = reference.evaluate(t)
    np.testing.assert_allclose(derivative(reference, t, "q"), motion.v, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(derivative(reference, t, "v"), motion.a, rtol=0.0, atol=1e-8)
    assert np.abs(motion.v).max() > 0.1
    assert np.abs(motion.a).max() > 0.1


@pytest.mark.parametrize("kind", EXAMPLES)
def test_position_is_continuous_and_so_is_what_the_kind_promises(kind: str, tmp_path: Path) -> None:
    reference = example(kind, tmp_path)
    knots = np.array(CORNERS.get(kind, [1.0]))
    before, after = reference.evaluate(knots - 1e-9), reference.evaluate(knots + 1e-9)
    np.testing.assert_allclose(before.q, after.q, rtol=0.0, atol=1e-7)
    inner = slice(1, -1) if kind in ("csv", "csv quintic") else slice(None)  # with free ends it stops in motion
    np.testing.assert_allclose(before.v[inner], after.v[inner], rtol=0.0, atol=1e-6)
    if kind == "ramps":
        # π²/2 · step / time² of the ramp: the first moves joint 1 by 1 rad in 0.7 s
        jump = after.a[0, 0] - before.a[0, 0]
        assert jump == pytest.approx(0.5 * math.pi**2 / 0.7**2, rel=1e-6)
    else:
        inner = slice(1, -1) if kind in ("csv", "csv at rest", "csv quintic") else slice(None)
        np.testing.assert_allclose(before.a[inner], after.a[inner], rtol=0.0, atol=1e-5)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_outside_its_time_it_rests_at_the_nearest_end(kind: str, tmp_path: Path) -> None:
    reference = example(kind, tmp_path)
    first = 0.2 if "csv" in kind else 0.0
    early = reference.evaluate(np.array([-3.0, -1e-6]))
    np.testing.assert_array_equal(early.q, np.repeat(reference.evaluate(np.array([first])).q, 2, axis=0))
    late = early
    if math.isfinite(reference.duration):
        late = reference.evaluate(reference.duration + np.array([1e-6, 5.0]))
        np.testing.assert_array_equal(
            late.q, np.repeat(reference.evaluate(np.array([reference.duration])).q, 2, axis=0)
        )
    for motion in (early, late):
        assert not motion.v.any()
        assert not motion.a.any()


@pytest.mark.parametrize("kind", EXAMPLES)
def test_each_time_is_evaluated_by_itself(kind: str, tmp_path: Path) -> None:
    reference = example(kind, tmp_path)
    t = np.linspace(0.0, 3.5, 36)
    together = reference.evaluate(t)
    for k in (0, 7, 35):
        alone = reference.evaluate(t[k : k + 1])
        for field in ("q", "v", "a"):
            assert getattr(together, field).shape == (36, 2)
            np.testing.assert_array_equal(getattr(together, field)[k : k + 1], getattr(alone, field))


def test_quintic_reaches_its_targets_and_rests_between_the_moves() -> None:
    t = np.array([0.0, 0.5, 1.3, 1.6, 2.0, 3.1, 9.0])
    motion = QUINTIC.evaluate(t)
    expected = [[0.0, 1.0], [0.0, 1.0], [1.0, 0.5], [1.0, 0.5], [1.0, 0.5], [-0.5, 2.0], [-0.5, 2.0]]
    np.testing.assert_allclose(motion.q, expected, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(motion.v, 0.0, atol=1e-12)
    np.testing.assert_allclose(motion.a, 0.0, atol=1e-12)
    # Half-way: the mean of the ends, at 15/8 of the mean speed (1 rad in 0.8 s), unaccelerated.
    middle = QUINTIC.evaluate(np.array([0.9]))
    assert middle.q[0, 0] == pytest.approx(0.5)
    assert middle.v[0, 0] == pytest.approx(15.0 / 8.0 / 0.8)
    assert middle.a[0, 0] == pytest.approx(0.0, abs=1e-12)
    assert QUINTIC.duration == pytest.approx(3.1)


def test_a_single_quintic_move_needs_no_times() -> None:
    single = Quintic(start=[0.0, 0.0], targets=[1.0, 2.0], move=0.5)
    np.testing.assert_allclose(single.evaluate(np.array([0.5, 1.0])).q, [[1.0, 2.0]] * 2)
    assert (single.nv, single.duration) == (2, 0.5)


def test_ramps_pass_their_way_points_at_rest() -> None:
    motion = RAMPS.evaluate(RAMPS.times)
    np.testing.assert_allclose(motion.q, RAMPS.points, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(motion.v, 0.0, atol=1e-12)
    # half-way of a ramp of 1 rad in 0.7 s: π/2 times the mean speed
    assert RAMPS.evaluate(np.array([0.65])).v[0, 0] == pytest.approx(math.pi / 2.0 / 0.7)


def test_multisine_is_its_sum_of_sines() -> None:
    t = np.array([0.37])
    q = MULTISINE.evaluate(t).q[0]
    two_pi_t = 2.0 * math.pi * 0.37
    assert q[0] == pytest.approx(0.1 + 0.5 * math.sin(0.2 * two_pi_t) + 0.2 * math.sin(0.7 * two_pi_t + 1.0), rel=1e-14)
    assert q[1] == pytest.approx(
        -0.3 + 0.3 * math.sin(0.2 * two_pi_t + 0.4) + 0.1 * math.sin(0.7 * two_pi_t - 2.0), rel=1e-14
    )


def test_a_rising_multisine_starts_at_the_offset_at_rest_and_becomes_the_plain_one() -> None:
    start = RISING.evaluate(np.array([0.0]))
    assert start.q.tolist() == [[0.1, -0.3]]
    assert not start.v.any()
    assert not start.a.any()
    plain = Multisine(offset=[0.1, -0.3], amplitude=[0.5, 0.3], frequency=[0.4, 1.1], phase=0.7)
    t = np.linspace(1.3, 5.0, 40)
    for field in ("q", "v", "a"):
        np.testing.assert_array_equal(getattr(RISING.evaluate(t), field), getattr(plain.evaluate(t), field))


def test_fourier_coefficients_are_those_of_the_velocity_and_it_repeats() -> None:
    t = np.array([0.9])
    angle = 2.0 * math.pi * 0.25 * 0.9 * np.arange(1, 4)
    np.testing.assert_allclose(
        FOURIER.evaluate(t).v[0], FOURIER.a @ np.cos(angle) + FOURIER.b @ np.sin(angle), rtol=1e-12
    )
    np.testing.assert_allclose(FOURIER.evaluate(t + 4.0).q, FOURIER.evaluate(t).q, rtol=0.0, atol=1e-12)
    mean = FOURIER.evaluate(np.arange(400) * 0.01).q.mean(axis=0)
    np.testing.assert_allclose(mean, FOURIER.offset, rtol=0.0, atol=1e-12)


@settings(max_examples=25, deadline=None)
@given(
    coefficients=st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4),
    knots=st.lists(st.floats(0.05, 1.0), min_size=6, max_size=12),
)
@pytest.mark.parametrize("spline", ["cubic", "quintic"])
def test_csv_spline_reproduces_a_cubic_exactly(
    spline: str, coefficients: list[float], knots: list[float], tmp_path_factory: pytest.TempPathFactory
) -> None:
    curve = np.polynomial.Polynomial(coefficients)
    times = np.cumsum(knots)
    path = write_csv(
        tmp_path_factory.mktemp("cubic") / "p.csv", np.column_stack([times, curve(times), -curve(times)]), "t,q1,q2"
    )
    reference = CsvPath(path=path, spline=spline)
    t = np.linspace(times[0], times[-1], 50)
    motion = reference.evaluate(t)
    for field, exact in (("q", curve), ("v", curve.deriv()), ("a", curve.deriv(2))):
        scale = 1.0 + np.abs(exact(t)).max()
        np.testing.assert_allclose(getattr(motion, field)[:, 0] / scale, exact(t) / scale, rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(getattr(motion, field)[:, 1], -getattr(motion, field)[:, 0], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("spline", ["cubic", "quintic"])
@pytest.mark.parametrize("ends", ["free", "rest"])
def test_csv_path_goes_through_every_row(spline: str, ends: str, tmp_path: Path) -> None:
    reference = CsvPath(path=write_csv(tmp_path / "p.csv", TABLE), spline=spline, ends=ends)
    motion = reference.evaluate(TABLE[:, 0])
    np.testing.assert_allclose(motion.q, TABLE[:, 1:], rtol=0.0, atol=1e-12)
    if ends == "rest":
        np.testing.assert_allclose(motion.v[[0, -1]], 0.0, atol=1e-10)
    if (spline, ends) == ("quintic", "rest"):
        np.testing.assert_allclose(motion.a[[0, -1]], 0.0, atol=1e-8)


def test_csv_reads_what_spreadsheets_write(tmp_path: Path) -> None:
    path = tmp_path / "p.csv"
    path.write_bytes(b"\xef\xbb\xbf time , shoulder,elbow\r\n0,0,1\r\n 1 , 1e0,-1\r\n\r\n2,0.5,0\r\n3,0,0\r\n,,\r\n")
    reference = CsvPath(path=path, joints=["elbow", "shoulder"])
    assert reference.joint_names == ("elbow", "shoulder")
    np.testing.assert_allclose(reference.evaluate(np.array([1.0])).q, [[-1.0, 1.0]], atol=1e-12)


CSV_ERRORS = [
    ("", r"is empty; expected a header t,q1,…,qn"),
    ("0,1\n1,2\n", r"line 1: the header is '0,1'; expected t,q1,…,qn"),
    ("t;q1\n0;1\n", r"line 1: has ';' between its values"),
    ("t,q2,q1\n0,1,2\n", r"line 1: the columns are 't,q2,q1'; put them in the order q1,…,qn"),
    ("t,a,a\n0,1,2\n", r"line 1: a column has no name, or two have the same"),
    ("t,q1\n0,0\n1,x\n", r"line 3: 'x' is not a number"),
    ("t,q1\n0,0\n\n1,nan\n", r"line 4: 'nan' is not finite; remove the row or fill the gap"),
    ("t,q1\n0,0\n1,inf\n", r"line 3: 'inf' is not finite"),
    ("t,q1\n0,0\n1,1,1\n", r"line 3: 3 value\(s\), but the header names 2 columns"),
    ("t,q1\n0,0\n1,\n", r"line 3: '' is not a number"),
    ("t,q1\n0,0\n1,1\n1,2\n", r"line 4: time 1 s follows 1 s; it must increase"),
    ("t,q1\n0,0\n2,1\n\n1,2\n", r"line 5: time 1 s follows 2 s; it must increase"),
    ("t,q1\n0,0\n1,1\n2,2\n", r"has 3 row\(s\); a spline of degree 3 needs at least 4"),
    ("t,q1\n", r"has 0 row\(s\)"),
]


@pytest.mark.parametrize(("text", "message"), CSV_ERRORS)
def test_malformed_csv_is_refused_with_its_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(ParameterError, match=message) as caught:
        CsvPath(path=path)
    assert "bad.csv" in str(caught.value)


def test_a_csv_that_is_not_there_or_not_text_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"none.csv: cannot be read \(No such file"):
        CsvPath(path=tmp_path / "none.csv")
    (tmp_path / "binary.csv").write_bytes(b"t,q1\n\xff\xfe\n")
    with pytest.raises(ParameterError, match=r"binary.csv: cannot be read, it is not UTF-8 text"):
        CsvPath(path=tmp_path / "binary.csv")
    with pytest.raises(ParameterError, match=r"has no column wrist; it has q1, q2"):
        CsvPath(path=write_csv(tmp_path / "p.csv", TABLE), joints=["q1", "wrist"])


WRONG = [
    ("quintic", {"start": [0.0], "targets": [[1.0, 2.0]], "move": 1.0}, r"a target has 2 values but start has 1"),
    ("quintic", {"start": [0.0], "targets": [[1.0], [2.0]], "times": [0.0], "move": 1.0}, r"times: has 1 values for 2"),
    (
        "quintic",
        {"start": [0.0], "targets": [[1.0], [2.0]], "times": [0.0, 0.5], "move": 1.0},
        r"times: move 2 starts at 0.5 s but move 1 lasts until 1 s; start it later or shorten move",
    ),
    ("quintic", {"start": [0.0], "targets": [[1.0]], "move": 0.0}, r"move: got 0.0; it must be above 0 s"),
    ("quintic", {"start": 0.0, "targets": [[1.0]], "move": 1.0}, r"start: got an array of shape \(\); expected a list"),
    ("quintic", {"start": [0.0, 1.0], "targets": [[1.0], [1.0, 2.0]], "move": 1.0}, r"targets: got .*expected a list"),
    ("ramps", {"points": [[0.0], [1.0]], "times": [1.0, 1.0]}, r"times: 1 s comes after 1 s; they must increase"),
    ("ramps", {"points": [[0.0], [1.0]], "times": [0.0]}, r"times: has 1 values for 2 way-points"),
    ("ramps", {"points": [[0.0]], "times": [0.0]}, r"points: has 1 way-point; give at least two"),
    ("ramps", {"points": [[0.0], [math.nan]], "times": [0.0, 1.0]}, r"points: entry 2, 1 is nan"),
    ("multisine", {"offset": [0.0, 0.0], "amplitude": [1.0], "frequency": 1.0}, r"amplitude: has the shape \(1,\)"),
    (
        "multisine",
        {"offset": [0.0, 0.0], "amplitude": [[1.0, 1.0]] * 2, "frequency": [1.0, 1.0, 1.0]},
        r"frequency: has the shape \(3,\); expected \(2, 2\): offset has 2 joints, amplitude 2 term",
    ),
    ("multisine", {"offset": [0.0], "amplitude": [1.0], "frequency": -1.0}, r"frequency: got -1.0"),
    ("multisine", {"offset": [0.0], "amplitude": [1.0], "frequency": 1.0, "rise": -1.0}, r"rise: got -1.0"),
    ("fourier", {"offset": [0.0], "a": [[1.0]], "b": [[1.0, 1.0]], "base_hz": 1.0}, r"b: has the shape \(1, 2\) but a"),
    ("fourier", {"offset": [0.0] * 2, "a": [[1.0]], "b": [[1.0]], "base_hz": 1.0}, r"a: has the shape \(1, 1\)"),
    ("fourier", {"offset": [0.0], "a": [[1.0]], "b": [[1.0]], "base_hz": 0.0}, r"base_hz: got 0.0"),
]


@pytest.mark.parametrize(("kind", "parameters", "message"), WRONG)
def test_wrong_parameters_are_refused_by_name(kind: str, parameters: dict[str, object], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        REFERENCES[kind](**parameters)


@pytest.mark.parametrize("times", [np.zeros((2, 2)), np.array([0.0, np.nan]), np.array(1.0)])
def test_times_must_be_a_finite_vector(times: np.ndarray) -> None:
    with pytest.raises(ParameterError, match="expected finite ones of shape"):
        QUINTIC.evaluate(times)


# The check before a run ----------------------------------------------------------------------------------------------


def slider(**changes: object) -> SimpleNamespace:
    """Two uncoupled joints, of 2 kg·m² under a constant 3 N·m, and of 1 kg without load; no limit unless given."""
    free = np.array([np.inf, np.inf])
    arm = {
        "name": "slider",
        "nv": 2,
        "joint_names": ("hinge", "rail"),
        "joint_kinds": ("revolute", "prismatic"),
        "lower": -free,
        "upper": free,
        "velocity_limit": free,
        "effort_limit": free,
        "friction": np.array([0.5, 0.0]),
        "damping": np.array([0.0, 4.0]),
        "mass_matrix": lambda q: np.broadcast_to(np.diag([2.0, 1.0]), (*q.shape, 2)),
        "bias": lambda q, v: np.broadcast_to([3.0, 0.0], q.shape),
    }
    return SimpleNamespace(**(arm | changes))


SINE = Multisine(offset=[0.0, 0.0], amplitude=[1.0, 0.5], frequency=0.25)  # v to π/2, a to (π/2)², period 4 s


def test_a_motion_within_all_limits_passes_without_a_word() -> None:
    assert check_reference(SINE, slider(upper=np.array([1.0, 0.5]), lower=np.array([-1.0, -0.5])), 4.0) == []


def test_required_torque_is_inertia_bias_and_friction() -> None:
    t = np.array([0.5])  # sin = cos = √½
    motion = SINE.evaluate(t)
    w, half = math.pi / 2.0, math.sqrt(0.5)
    assert required_torque(slider(), motion)[0] == pytest.approx(
        [-2.0 * w**2 * half + 3.0 + 0.5, -0.5 * w**2 * half + 4.0 * 0.5 * w * half]
    )
    other = required_torque(slider(), motion, coulomb=np.array([1.0, 2.0]), viscous=np.zeros(2))[0]
    assert other == pytest.approx([-2.0 * w**2 * half + 4.0, -0.5 * w**2 * half + 2.0])


def test_exceeded_limits_are_told_with_joint_value_limit_and_time() -> None:
    infinite = np.inf
    arm = slider(
        upper=np.array([0.9, infinite]),
        lower=np.array([-infinite, -0.4]),
        velocity_limit=np.array([infinite, 0.7]),
        effort_limit=np.array([6.0, infinite]),
    )
    assert check_reference(SINE, arm, 4.0) == [
        "joint 'hinge': position 1 rad at t = 1.000 s, limit 0.9 rad (exceeded during 14 % of the run)",
        # M a + 3 + 0.5 sgn(v) is largest just after the turn at t = 3 s, 2 (π/2)² + 3.5 = 8.435. Above 6 from
        # acos(3.5/4.935)/(π/2) = 0.498 s before to acos(2.5/4.935)/(π/2) = 0.662 s after: 29 % of 4 s.
        "joint 'hinge': torque 8.435 N·m at t = 3.001 s, limit 6 N·m (exceeded during 29 % of the run)",
        "joint 'rail': position -0.5 m at t = 3.000 s, limit -0.4 m (exceeded during 20 % of the run)",
        "joint 'rail': velocity 0.7854 m/s at t = 0.000 s, limit 0.7 m/s (exceeded during 30 % of the run)",
    ]


def test_limits_of_the_run_go_before_those_of_the_arm() -> None:
    arm = slider(effort_limit=np.array([1.0, 1.0]))
    assert check_reference(SINE, arm, 4.0, effort_limit=np.array([20.0, 20.0])) == []
    told = check_reference(SINE, slider(), 4.0, effort_limit=np.array([7.0, 20.0]), coulomb=np.zeros(2))
    assert len(told) == 1
    assert told[0].startswith("joint 'hinge': torque 7.935 N·m at t = 3.000 s, limit 7 N·m")


def test_only_the_part_that_is_run_is_checked() -> None:
    arm = slider(lower=np.array([-0.5, -np.inf]))
    assert check_reference(SINE, arm, 2.0) == []
    assert len(check_reference(SINE, arm, 4.0)) == 1


def test_a_path_that_stops_in_motion_is_told(tmp_path: Path) -> None:
    table = np.column_stack([np.arange(5.0), np.arange(5.0), np.zeros(5)])
    path = write_csv(tmp_path / "p.csv", table)
    told = check_reference(CsvPath(path=path), slider(), 5.0, period=0.01)
    assert told == [
        "joint 'hinge': the reference ends at t = 4.000 s while it moves at 1 rad/s and is held from there on; "
        "let it end at rest or shorten the run"
    ]
    assert check_reference(CsvPath(path=path), slider(), 4.0, period=0.01) == []
    assert check_reference(CsvPath(path=path, ends="rest"), slider(), 5.0, period=0.01) == []


def test_columns_named_unlike_the_joints_are_told(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "p.csv", TABLE, "t,rail,hinge")
    (told,) = check_reference(CsvPath(path=path), slider(), 3.0)
    assert "columns are rail, hinge but the joints of slider are hinge, rail" in told
    assert check_reference(CsvPath(path=path, joints=["hinge", "rail"]), slider(), 3.0) == []


def test_a_reference_for_another_number_of_joints_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"is for 2 joint\(s\) but two has 3: a, b, c"):
        check_reference(SINE, slider(name="two", nv=3, joint_names=("a", "b", "c")), 1.0)


def test_required_torque_of_a_real_arm_undoes_its_forward_dynamics() -> None:
    arm = load_arm("ur5", payload=1.5)
    rng = np.random.default_rng(3)
    q, v, a = rng.standard_normal((3, 20, 6))
    friction = arm.friction * np.sign(v) + arm.damping * v
    torque = required_torque(arm, Setpoint(q, v, a))
    np.testing.assert_allclose(arm.forward_dynamics(q, v, torque - friction), a, rtol=0.0, atol=1e-9)


def test_a_real_arm_is_told_apart_from_what_it_cannot_follow() -> None:
    arm = load_arm("ur5")
    offset = [0.0, -1.0, 1.0, 0.0, 0.0, 0.0]
    slow = Multisine(offset=offset, amplitude=[0.2] * 6, frequency=0.2, rise=1.0)
    assert check_reference(slow, arm, 5.0) == []
    fast = Multisine(offset=offset, amplitude=[0.6] * 6, frequency=2.0, rise=1.0)
    told = check_reference(fast, arm, 5.0)
    assert any("velocity" in line and f"limit {arm.velocity_limit[0]:.4g} rad/s" in line for line in told)
    assert any("torque" in line and f"limit {arm.effort_limit[1]:.4g} N·m" in line for line in told)
