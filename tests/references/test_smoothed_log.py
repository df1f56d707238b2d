"""A log as a reference: smoothed as its rounding asks for, and a broken torque limit traced to rows or motion."""

from __future__ import annotations

import gzip
from dataclasses import replace
from pathlib import Path

import needs
import numpy as np
import pytest

from asmc_pin import load_arm
from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.references import check_reference, reference_words
from asmc_pin.references.csv_path import CsvPath
from asmc_pin.references.smoothed_log import smallest_steps
from asmc_pin.results.provenance import provenance

COUNT = 2.0 * np.pi / 4096.0
ARM = load_arm("two_link")
LIMIT = np.array([60.0, 20.0])


def motion(t: Array) -> Array:
    return np.column_stack([0.5 + 0.4 * np.sin(2.0 * t), 0.3 * np.cos(3.0 * t)])


def acceleration(t: Array) -> Array:
    return np.column_stack([-1.6 * np.sin(2.0 * t), -2.7 * np.cos(3.0 * t)])


def logged(path: Path, *, step: float = 0.004, count: float = COUNT, mark: str = ",", jitter: float = 0.1) -> Path:
    """A log of 3 s as a robot writes it: rounded angles, irregular time stamps, every tenth row twice."""
    rng = np.random.default_rng(1)
    t = np.cumsum(step * rng.uniform(1.0 - jitter, 1.0 + jitter, round(3.0 / step)))
    rows = np.column_stack([t, count * np.round(motion(t) / count)])
    rows = np.repeat(rows, np.where(np.arange(len(rows)) % 10 == 0, 2, 1), axis=0)
    text = mark.join(["t", "q1", "q2"]) + "\n" + "\n".join(mark.join(f"{x:.10g}" for x in row) for row in rows) + "\n"
    data = text.encode()
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)
    return path


@pytest.mark.parametrize("name", ["a.csv", "a.csv.gz", "semicolons.csv"])
def test_a_rounded_log_gives_the_motion_back_with_its_accelerations(name: str, tmp_path: Path) -> None:
    path = logged(tmp_path / name, mark=";" if "semi" in name else ",")
    made = CsvPath(path=path, smoothing="quantisation")
    t = np.linspace(0.3, 2.6, 400)
    start = float(np.genfromtxt(path, delimiter=";" if "semi" in name else ",", skip_header=1)[0, 0])
    got = made.evaluate(t)
    assert np.abs(got.q - motion(t + start)).max() < COUNT
    assert np.abs(got.a - acceleration(t + start)).max() < 0.5
    residual = made.evaluate(made.times).q - made.points
    rms = np.sqrt(np.mean(residual**2, axis=0))
    assert (rms <= made.deviation * (1.0 + 1e-9)).all()
    assert (made.deviation < 2.0 * COUNT / np.sqrt(12.0)).all()
    # As nearly as the rows lie, and no nearer.
    assert (rms > 0.7 * COUNT / np.sqrt(12.0)).all()


def test_the_step_is_the_smallest_there_is_and_a_joint_that_hardly_moves_has_none() -> None:
    moving = COUNT * np.round(np.linspace(0.0, 1.0, 500) / COUNT)
    still = np.where(np.arange(500) < 200, 0.0, COUNT)
    np.testing.assert_allclose(smallest_steps(np.column_stack([moving, still])), [COUNT, 0.0], rtol=1e-9)


def test_what_was_done_is_told_in_words_and_in_the_provenance(tmp_path: Path) -> None:
    logged(tmp_path / "log.csv")
    data = {
        "name": "logged",
        "arm": "two_link",
        "period": 0.002,
        "duration": 1.0,
        "reference": {"kind": "csv", "path": "log.csv", "smoothing": "quantisation"},
        "defaults": {"mbar": 0.03, "ks": 5.0, "beta": 5.0},
        "controllers": {"PPC": {"law": "ppc"}},
    }
    experiment = Experiment.from_dict(data, folder=tmp_path)
    said = "\n".join(reference_words(experiment.build_reference()))
    for part in ("that repeat all values", "not regular", "RMS distance of Δ/√12", "Δ = (0.0015, 0.0015) rad"):
        assert part in said
    from datetime import UTC, datetime

    told = provenance(experiment, experiment.build_arm(), datetime.now(UTC), {}, tmp_path)["reference"]
    assert "\n".join(told) == said
    given = replace(experiment.build_reference(), resolution=0.01)
    assert "as given" in reference_words(given)[-1]
    assert given.deviation == pytest.approx(0.01 / np.sqrt(12.0))


def torque_words(reference: CsvPath) -> list[str]:
    told = check_reference(reference, ARM, 2.5, 0.002, effort_limit=LIMIT, coulomb=np.zeros(2), viscous=np.zeros(2))
    return [line for line in told if "torque beyond its limit" in line]


def test_torque_from_counts_is_called_that_and_the_key_mends_it(tmp_path: Path) -> None:
    rough = CsvPath(path=strictly(logged(tmp_path / "log.csv")))
    (told,) = torque_words(rough)
    assert "comes of the rows and not of the motion" in told
    assert told.endswith('give reference.smoothing = "quantisation"')
    assert torque_words(replace(rough, smoothing="quantisation")) == []


def strictly(path: Path) -> Path:
    """The same without the rows that a path does not take, those that repeat the last."""
    lines = path.read_text().splitlines()
    path.write_text("\n".join(dict.fromkeys(lines)) + "\n")
    return path


def test_torque_that_the_motion_asks_for_is_called_that_and_a_slower_one_mends_it(tmp_path: Path) -> None:
    fast = CsvPath(path=logged(tmp_path / "log.csv"), smoothing="quantisation", stretch=0.2)
    (told,) = (line for line in check_reference(fast, ARM, 0.5, 0.002, effort_limit=LIMIT) if "torque beyond" in line)
    assert "is what the motion asks for" in told
    assert "reference.stretch" in told
    assert torque_words(replace(fast, stretch=1.0)) == []


def test_noise_above_the_rounding_that_was_given_is_found_and_its_size_is_proposed(tmp_path: Path) -> None:
    fine = CsvPath(path=logged(tmp_path / "log.csv"), smoothing="quantisation", resolution=1e-7)
    (told,) = torque_words(fine)
    assert "comes of the rows" in told
    proposed = [float(x) for x in told.split("resolution = [")[1].rstrip("]").split(",")]
    assert torque_words(replace(fine, resolution=np.array(proposed))) == []


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"smoothing": "quantisation", "spline": "quintic"}, "spline"),
        ({"smoothing": "quantisation", "ends": "rest"}, "ends"),
        ({"resolution": 0.1}, "resolution"),
        ({"smoothing": "quantisation", "resolution": [0.1, 0.1, 0.1]}, "resolution"),
        ({"smoothing": "quantisation", "joints": ["wrist", "elbow"]}, "path"),
    ],
)
def test_keys_that_do_not_go_together_are_named(values: dict[str, object], named: str, tmp_path: Path) -> None:
    with pytest.raises(ParameterError) as caught:
        CsvPath(path=strictly(logged(tmp_path / "log.csv")), **values)
    assert caught.value.parameter == named


def test_joints_are_taken_by_their_names_in_the_order_asked_for(tmp_path: Path) -> None:
    path = logged(tmp_path / "log.csv")
    both = CsvPath(path=path, smoothing="quantisation")
    turned = CsvPath(path=path, smoothing="quantisation", joints=["q2", "q1"])
    np.testing.assert_array_equal(turned.points, both.points[:, ::-1])
    path.write_text(path.read_text().replace("t,q1,q2", "t,shoulder/position,elbow/position"))
    named = CsvPath(path=path, smoothing="quantisation", joints=["elbow", "shoulder"])
    np.testing.assert_array_equal(named.points, both.points[:, ::-1])
    assert named.joint_names == ("elbow", "shoulder")


def test_times_are_stretched_for_way_points_too(tmp_path: Path) -> None:
    path = strictly(logged(tmp_path / "log.csv"))
    plain, slow = CsvPath(path=path), CsvPath(path=path, stretch=2.0)
    np.testing.assert_allclose(slow.evaluate(np.array([2.0])).v, 0.5 * plain.evaluate(np.array([1.0])).v, rtol=1e-9)


@pytest.mark.long
def test_the_log_of_a_real_panda_is_a_reference_and_what_breaks_its_limits_is_named() -> None:
    """Its time stamps are off by up to milliseconds: what is white in it is smoothed, and more is proposed."""
    log = CsvPath(path=needs.real_log("panda_exciting.csv.gz"), smoothing="quantisation")
    assert log.nv == 7
    arm = load_arm("panda")
    (told,) = (line for line in check_reference(log, arm, 20.0) if "torque beyond" in line)
    assert "comes of the rows" in told
    proposed = np.array([float(x) for x in told.split("resolution = [")[1].rstrip("]").split(",")])
    assert not [line for line in check_reference(replace(log, resolution=proposed), arm, 20.0) if "torque" in line]


def test_a_bag_needs_the_joints_names(tmp_path: Path) -> None:
    path = tmp_path / "robot.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + bytes(20))
    with pytest.raises(ParameterError, match="which knows joints by their names") as caught:
        CsvPath(path=path, smoothing="quantisation")
    assert caught.value.parameter == "joints"
