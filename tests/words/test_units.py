"""A period in Hz, a delay in seconds, an angle in degrees are asked about, on the command line and in Python alike."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from arm_urdf import inertial, joint, link, robot, write
from short_experiment import SHORT

from asmc_pin import load_arm, load_experiment, rollout, verify
from asmc_pin.arms import Arm
from asmc_pin.cli import main
from asmc_pin.condition import Recording, design, read_recording
from asmc_pin.condition.certificate import certify
from asmc_pin.controllers import Ppc
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.plant import Drive, Plant, Sensor
from asmc_pin.references import Quintic
from asmc_pin.sampled import stability
from asmc_pin.sampled.gain_choice.gains import suggest_gains

Run = Callable[..., tuple[int, str, str]]
LOOP = ["stability", "ur5", "--mbar", "0.01", "--ks", "10", "--beta", "10"]
VERIFY = ["verify", "ur5", "--mbar", "0.01"]


@pytest.fixture
def asmc_pin(capfd: pytest.CaptureFixture[str]) -> Run:
    """Run the command line in this process: status, standard output, standard error."""

    def run(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            main(list(arguments))
        out, err = capfd.readouterr()
        assert isinstance(end.value.code, int)
        return end.value.code, out, err

    return run


@pytest.mark.parametrize(
    ("arguments", "asked", "answer"),
    [
        ([*LOOP, "--period", "1000"], "1000 s?", "1000 Hz is 0.001"),
        ([*LOOP, "--period", "1"], "1 s?", "1 ms is 0.001"),
        (["design", "two_link", "--gains", "--period", "4"], "4 s?", "4 ms is 0.004"),
        ([*LOOP, "--period", "0.001", "--delay", "0.002"], "0.002 periods", "0.002 s are 2 of them"),
        ([*LOOP, "--period", "0.001", "--delay", "2000"], "2000 periods", "2000 µs are 2 of them"),
        ([*VERIFY, "--box", "elbow_joint=-180:180"], "-180:180 rad?", "-3.14159:3.14159"),
        ([*VERIFY, "--certify", "--box", "elbow_joint=0:90"], "0:90 rad?", "0:1.5708"),
        (["design", "ur5", "--box", "elbow_joint=0:90"], "0:90 rad?", "0:1.5708"),
        ([*LOOP, "--period", "0.001", "--box", "elbow_joint=0:90"], "0:90 rad?", "0:1.5708"),
        ([*VERIFY, "--lock", "elbow_joint=90"], "90 rad?", "90° are 1.5708"),
        ([*VERIFY, "--lock", "elbow_joint=0,90"], "90 rad?", "90° are 1.5708"),
        (["verify", "two_link", "--mbar", "0.01", "--lock", "joint_2=90"], "90 rad?", "take whole turns away: 2.03541"),
        ([*VERIFY, "--along", "demo", "--tube", "5"], "5 rad to either side?", "5° are 0.0872665"),
        ([*VERIFY, "--gravity", "0,0,-1"], "(0, 0, -1) m/s²?", "(0, 0, -9.81)"),
        ([*VERIFY, "--gravity", "0,0,-9810"], "(0, 0, -9810) m/s²?", "(0, 0, -9.81)"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_a_figure_in_another_unit_is_asked_about_and_not_computed(
    asmc_pin: Run, arguments: list[str], asked: str, answer: str
) -> None:
    status, out, err = asmc_pin(*arguments)
    assert (status, out) == (2, "")
    (line,) = (line for line in err.splitlines() if "warning" not in line)
    assert line.startswith("asmc-pin: ")
    assert asked in line
    assert answer in line


@pytest.mark.parametrize(
    ("old", "new", "key", "answer"),
    [
        ("period = 0.001", "period = 1000", "period", "1000 Hz is 0.001"),
        ("period = 0.001", "period = 1.0", "period", "1 ms is 0.001"),
        ("[plant]", "[plant]\ndrive = { delay = 0.002 }", "plant.drive.delay", "0.002 s are 2 of them"),
        ("[plant]", "[plant]\nsensor = { delay = 0.0015 }", "plant.sensor.delay", "0.0015 s are 1.5 of them"),
        ("[plant]", "[plant]\nq0 = [90.0, 0.0]", "plant.q0", "180° are 3.14159"),
        ("offset = [0.3, 0.2]", "offset = [90.0, 45.0]", "reference", "joint 'joint_1' at 9"),
        # A start near zero, and then a swing of 90 "rad" in half a second.
        ("amplitude = [[0.2], [0.2]]", "amplitude = [[90.0], [90.0]]", "reference", "rad/s: degrees?"),
    ],
)
def test_an_experiment_in_another_unit_is_asked_about(
    asmc_pin: Run, tmp_path: Path, old: str, new: str, key: str, answer: str
) -> None:
    path = tmp_path / "other.toml"
    path.write_text(SHORT.replace(old, new), encoding="utf-8")
    status, out, err = asmc_pin("compare", str(path), "--out", str(tmp_path / "out"))
    assert (status, out) == (2, "")
    assert f": {key}: " in err
    assert answer in err

    def build() -> None:
        experiment = load_experiment(path)
        experiment.build_plant()
        experiment.build_reference()

    with pytest.raises(ExperimentError, match=re.escape(key)):
        build()


def test_a_cartesian_start_in_degrees_is_asked_about_before_it_is_solved() -> None:
    experiment = Experiment.from_dict(
        {
            "name": "line",
            "arm": "ur5",
            "period": 0.001,
            "duration": 1.0,
            "reference": {
                "kind": "cartesian",
                "start": [0.0, -90.0, 90.0, -90.0, -90.0, 0.0],
                "link": "tool0",
                "points": [[0.4, 0.1, 0.4]],
                "move": 1.0,
            },
            "controllers": {"PPC": {"law": "ppc", "mbar": 0.01, "ks": 5.0, "beta": 5.0}},
        }
    )
    with pytest.raises(ExperimentError, match=r"reference\.start: .*'shoulder_lift_joint' at -90 rad"):
        experiment.build_reference()


def test_python_asks_what_the_command_line_asks() -> None:
    arm = load_arm("two_link")
    law = Ppc(mbar=0.01, ks=5.0, beta=5.0, period=1e-3)
    still = Quintic(start=[0.0, 0.0], targets=[[0.1, 0.1]], times=[0.0], move=1.0)
    asked: list[tuple[str, Callable[[], object]]] = [
        ("period", lambda: stability(arm, 0.01, 10.0, 10.0, 1000.0)),
        ("period", lambda: suggest_gains(arm, 0.01, 1.0)),
        ("delay", lambda: stability(arm, 0.01, 10.0, 10.0, 1e-3, delay=0.002)),
        ("delay_margin", lambda: suggest_gains(arm, 0.01, 1e-3, delay_margin=0.001)),
        ("box", lambda: verify(arm, 0.01, box={"joint_2": (-180.0, 180.0)})),
        ("box", lambda: verify(arm, 0.01, box=(np.array([-180.0, 0.0]), np.array([180.0, 1.0])))),
        ("box", lambda: certify(arm, 0.01, box={"joint_2": (-180.0, 180.0)})),
        ("box", lambda: design(arm, box={"joint_2": (-180.0, 180.0)})),
        ("lock", lambda: load_arm("two_link", lock={"joint_2": 90.0})),
        ("gravity", lambda: load_arm("two_link", gravity=(0.0, 0.0, -1.0))),
        ("tube", lambda: verify(arm, 0.01, along=still, tube_width=5.0)),
        ("period", lambda: rollout(Plant(arm), Ppc(mbar=0.01, ks=5.0, beta=5.0, period=1.0), still, 2.0)),
        ("drive.delay", lambda: rollout(Plant(arm, drive=Drive(delay=0.002)), law, still, 0.1)),
        ("sensor.delay", lambda: rollout(Plant(arm, sensor=Sensor(delay=0.002)), law, still, 0.1)),
    ]
    for name, call in asked:
        with pytest.raises(ParameterError, match=r"\?") as caught:
            call()
        assert caught.value.parameter == name


def test_what_is_meant_is_computed() -> None:
    arm = load_arm("ur5")
    assert verify(arm, 0.01, box={"elbow_joint": (-2.0 * np.pi, 2.0 * np.pi)}, samples=64).verdict == "unrefuted"
    assert verify(arm, 0.01, lock={"elbow_joint": 4.0}, samples=64).verdict == "unrefuted"
    assert stability(arm, 0.01, 1.0, 1.0, 0.5, samples=16, limits=False).verdict == "unstable"
    for delay in (0.05, 0.5, 3.0):
        stability(load_arm("two_link"), 0.01, 10.0, 10.0, 1e-3, delay=delay, samples=16, limits=False)
    for gravity in ((0.0, 0.0, 0.0), (0.0, 0.0, -1.62), (0.0, 0.0, -24.8)):
        assert load_arm("ur5", gravity=gravity).gravity_vector.tolist() == list(gravity)


# --- logs ------------------------------------------------------------------------------------------------------------

TIME = np.linspace(0.0, 4.0, 401)


def swing(amplitude: float, joints: int = 6) -> np.ndarray:
    """A smooth motion, and the sines' own velocity."""
    rates = 0.5 + 0.1 * np.arange(joints)
    return np.stack((amplitude * np.sin(np.outer(TIME, rates)), amplitude * rates * np.cos(np.outer(TIME, rates))))


def save(folder: Path, q: np.ndarray, v: np.ndarray | None = None) -> Path:
    names = [f"q{i + 1}" for i in range(q.shape[1])]
    table = [TIME[:, None], q]
    if v is not None:
        names += [f"v{i + 1}" for i in range(q.shape[1])]
        table.append(v)
    path = folder / "log.csv"
    np.savetxt(path, np.hstack(table), delimiter=",", header=",".join(["t", *names]), comments="")
    return path


def test_a_log_in_degrees_is_asked_about(asmc_pin: Run, tmp_path: Path) -> None:
    q, v = swing(1.0)
    path = save(tmp_path, np.rad2deg(q), np.rad2deg(v))
    status, out, err = asmc_pin(*VERIFY, "--along", str(path))
    assert (status, out) == (2, "")
    assert "log.csv has joint 'shoulder_pan_joint' at" in err
    assert "degrees?" in err
    assert asmc_pin(*VERIFY, "--along", str(save(tmp_path, q, v)))[0] == 0


@pytest.mark.parametrize(
    ("angles", "velocities", "says"),
    [(180.0 / np.pi, 1.0, "angles in degrees"), (1.0, 180.0 / np.pi, "velocities in degrees per second")],
)
def test_angles_and_velocities_in_two_units_are_asked_about(angles: float, velocities: float, says: str) -> None:
    # Angles so small that they could be rad as well as degrees.
    q, v = swing(0.05)
    log = Recording("log", TIME, angles * q, velocities * v)
    with pytest.raises(ParameterError, match=f"57.3 times|0.0175 times.*{says}"):
        verify(load_arm("ur5"), 0.01, along=log)
    # Velocities through a filter, with noise on both, belong together all the same.
    rng = np.random.default_rng(0)
    noisy = Recording("log", TIME, q + 1e-5 * rng.normal(size=q.shape), 0.9 * v + 1e-3 * rng.normal(size=v.shape))
    assert verify(load_arm("ur5"), 0.01, along=noisy).scope == "motion"


def test_turns_that_a_joint_really_made_are_no_degrees(tmp_path: Path) -> None:
    endless = robot(
        *(link(name, inertial()) for name in ("base", "arm", "hand")),
        joint("first", "base", "arm", "continuous", axis="0 1 0", extra=""),
        joint("second", "arm", "hand", "continuous", axis="1 0 0", extra=""),
    )
    arm = load_arm(write(tmp_path, endless))
    ten = np.outer(TIME, [0.0, 20.0 * np.pi / 4.0])
    assert verify(arm, 0.001, along=Recording("ten turns", TIME, ten)).scope == "motion"
    # A reading that jumps from one end of a turn to the other is no speed.
    wrapped = (ten + np.pi) % (2.0 * np.pi) - np.pi
    assert verify(arm, 0.001, along=Recording("wrapped", TIME, wrapped)).scope == "motion"
    with pytest.raises(ParameterError, match=r"whole turns of 6.28319 may be taken away"):
        verify(arm, 0.001, along=Recording("started far away", TIME, ten + 20.0 * np.pi))
    with pytest.raises(ParameterError, match="rad/s: degrees"):
        verify(arm, 0.001, along=Recording("degrees", TIME, np.rad2deg(np.outer(TIME, [0.0, 1.0]))))


def test_a_fast_joint_says_so_in_its_urdf(tmp_path: Path) -> None:
    def arm(limit: str) -> Arm:
        spinner = joint("spin", "base", "arm", "continuous", axis="0 1 0", extra=limit)
        return load_arm(write(tmp_path, robot(link("base"), link("arm", inertial()), spinner)))

    fast = Recording("fast", TIME, np.outer(TIME, [50.0]))
    with pytest.raises(ParameterError, match="declares its velocity limit"):
        verify(arm(""), 0.001, along=fast)
    assert verify(arm('<limit effort="1" velocity="60"/>'), 0.001, along=fast).scope == "motion"


def test_slides_are_never_taken_for_angles(tmp_path: Path) -> None:
    rail = joint("rail", "base", "arm", "prismatic", extra='<limit lower="-1" upper="50" effort="1" velocity="1"/>')
    arm = load_arm(write(tmp_path, robot(link("base"), link("arm", inertial()), rail)))
    assert verify(arm, 0.1, box={"rail": (0.0, 45.0)}, samples=16).verdict == "unrefuted"
    log = Recording("log", TIME, 10.0 * TIME[:, None], np.full((401, 1), 10.0 / 57.3))
    assert verify(arm, 0.1, along=log).scope == "motion"
    assert read_recording(save(tmp_path, 10.0 * TIME[:, None]), arm).q[-1, 0] == pytest.approx(40.0)


def test_a_path_from_a_file_in_degrees_is_asked_about(tmp_path: Path) -> None:
    q, _ = swing(1.0, joints=2)
    save(tmp_path, np.rad2deg(q))
    data = {
        "name": "path",
        "arm": "rv4fd",
        "period": 0.001,
        "duration": 2.0,
        "reference": {"kind": "csv", "path": "log.csv"},
        "controllers": {"PPC": {"law": "ppc", "mbar": 0.01, "ks": 5.0, "beta": 5.0}},
    }
    with pytest.raises(ExperimentError, match=r"reference: .*degrees"):
        Experiment.from_dict(data, folder=tmp_path).build_reference()
    save(tmp_path, q)
    assert Experiment.from_dict(data, folder=tmp_path).build_reference().nv == 2
