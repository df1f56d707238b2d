"""The sampled loop of laws other than PPC: their linear form, the map that follows from it, and where it is stable."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from law_oracles import rail, run
from law_settings import HELD

from asmc_pin.arms import load_arm
from asmc_pin.cli import main
from asmc_pin.controllers import CONTROLLERS, Adrc, Barrier, Bsmc, Dob, Implicit, Ism, Ivf, Pid, Ppc, Sta
from asmc_pin.controllers.linear_form import linear_form, linear_throughout
from asmc_pin.errors import ParameterError
from asmc_pin.sampled import SampledLoop, closed_loop, stability
from asmc_pin.sampled.error_prediction import drift_error
from asmc_pin.sampled.gain_warnings import gain_warnings
from asmc_pin.sampled.law_loops import law_loops
from asmc_pin.sampled.linear_map import inertia_ratios, modal_radius

GAINS = {"ks": 12.0, "beta": 9.0, "period": 1e-3}
KINDS = {
    **dict.fromkeys(("ppc", "dob", "ivf", "pid", "adrc"), "throughout"),
    **dict.fromkeys(("bsmc", "implicit", "barrier"), "in a band"),
    **dict.fromkeys(("plestan2010", "baek2016", "ism", "sta", "ntsm"), "nowhere"),
}


def law_for(name: str, **changes: Any) -> Any:
    return CONTROLLERS[name](**{"mbar": [0.6, 0.5], **GAINS, **HELD.get(name, {}), **changes})


@pytest.mark.parametrize("name", KINDS)
def test_a_law_is_found_to_be_linear_where_it_is(name: str) -> None:
    law = law_for(name)
    found = linear_form(law, 2)
    kind = "nowhere" if found is None else "throughout" if linear_throughout(law, 2) else "in a band"
    assert kind == KINDS[name]


def test_a_law_that_brakes_only_on_the_way_back_is_not_linear() -> None:
    """Each reading alone, doubled or turned round, says nothing of it: angle and velocity have to differ in sign."""

    class Returning(Ppc):
        def step(self, state: Any, sample: Any, setpoint: Any) -> Any:
            torque, _, state = self.pole_placement(state, sample, setpoint)
            back = sample.q * sample.v < 0.0
            return torque - np.where(
                back, 100.0 * np.sign(sample.v) * np.minimum(abs(sample.q), abs(sample.v)), 0.0
            ), state

    assert linear_form(law_for("ppc"), 2) is not None
    assert linear_form(Returning(mbar=[0.6, 0.5], **GAINS), 2) is None


TIMINGS: list[dict[str, Any]] = [
    {},
    {"acceleration": "position"},
    {"velocity": "difference"},
    {"filter_hz": 80.0},
    {"delay": 1.3},
    {"reading_delay": 0.5},
    {"velocity": "difference", "velocity_filter_hz": 100.0},
]


@pytest.mark.parametrize("timing", TIMINGS, ids=str)
def test_the_map_from_ppcs_own_step_is_that_written_out_for_ppc(timing: dict[str, Any]) -> None:
    rng = np.random.default_rng(0)
    a, stiffness = rng.standard_normal((2, 3, 3))
    mass, stiffness = a @ a.T + np.eye(3), stiffness + stiffness.T
    mbar, ks = [0.3, 0.2, 0.4], [3.0, 4.0, 5.0]
    written = SampledLoop(mbar, ks, 6.0, 1e-3, **timing)
    own = {key: value for key, value in timing.items() if key in ("acceleration", "filter_hz")}
    law = Ppc(mbar=mbar, ks=ks, beta=6.0, period=1e-3, pairing="mean" if written.averages_torque else "last", **own)
    found = SampledLoop(mbar, ks, 6.0, 1e-3, law=law, **timing)
    radii = [closed_loop(mass, loop, stiffness=stiffness).spectral_radius() for loop in (written, found)]
    assert radii[1] == pytest.approx(radii[0], rel=1e-12)


@pytest.mark.parametrize(
    "law",
    [
        Dob(mbar=0.9, cutoff_hz=40.0, **GAINS),
        Ivf(mbar=0.6, gain=60.0, **GAINS),
        Pid(kp=300.0, ki=900.0, kd=40.0, period=1e-3),
        Adrc(mbar=0.6, observer_hz=40.0, **GAINS),
        Implicit(mbar=0.6, gain=1e6, share=0.4, **GAINS),
    ],
    ids=lambda law: type(law).__name__,
)
def test_a_run_of_the_law_follows_its_map_tick_by_tick(law: Any) -> None:
    """From a start off the set point; what the law remembers at first is that of an arm that moves on unaccelerated."""
    start, ticks = (0.01, 0.05), 60
    trace = run(law, 1.3, ticks=ticks, load=np.zeros((ticks, 1)), kicks=0.0, start=start)
    loop = SampledLoop(law.mbar, law.ks, law.beta, 1e-3, law=law)
    system = closed_loop(np.array([[1.3]]), loop)
    # From the third tick on: before it the law knows that it has just begun.
    histories = np.array([-trace.e[2 : 2 + ticks // 2, 0], -trace.rate[2 : 2 + ticks // 2, 0]])
    order = system.matrix.shape[0]
    minimal = np.poly(np.linalg.eigvals(system.matrix))
    for signal in histories:
        residual = [minimal @ signal[k : k + order + 1][::-1] for k in range(len(signal) - order)]
        assert np.abs(residual).max() < 1e-9 * np.abs(signal).max() * np.abs(minimal).sum()


@pytest.mark.parametrize(
    ("law", "mass", "stable"),
    [
        (Dob(mbar=1.0, cutoff_hz=np.log(3.0) / 2e-3 / np.pi, ks=0.1, beta=0.1, period=1e-3), 0.34, True),
        (Dob(mbar=1.0, cutoff_hz=np.log(3.0) / 2e-3 / np.pi, ks=0.1, beta=0.1, period=1e-3), 0.33, False),
        (Implicit(mbar=1.5, gain=1e60, share=1.0, **GAINS), 1.0, False),
        (Implicit(mbar=1.5, gain=1e60, share=0.2, **GAINS), 1.0, True),
        (Pid(mbar=1.95, ks=20.0, beta=20.0, period=1e-3, acceleration="position"), 1.0, False),
        (Adrc(mbar=1.95, ks=20.0, beta=20.0, period=1e-3, observer_hz=np.inf), 1.0, True),
    ],
    ids=lambda value: type(value).__name__ if not isinstance(value, (bool, float)) else str(value),
)
def test_the_map_says_which_loops_grow_and_the_plant_agrees(law: Any, mass: float, stable: bool) -> None:
    loop = SampledLoop(law.mbar, law.ks, law.beta, 1e-3, law=law)
    assert bool(closed_loop(np.array([[mass]]), loop).spectral_radius() < 1.0) == stable
    trace = run(law, mass, ticks=240, load=np.zeros((240, 1)), kicks=0.0, start=(1e-9, 1e-9))
    size = np.abs(trace.a[:, 0])
    assert bool(size[-60:].max() < size[60:120].max()) == stable


def test_laws_that_only_switch_are_refused_with_what_can_be_done() -> None:
    for law in (Ism(mbar=0.6, gain=1.0, **GAINS), Sta(mbar=0.6, k1=1.0, k2=1.0, **GAINS)):
        with pytest.raises(ParameterError, match="not linear near its set point"):
            SampledLoop(law.mbar, law.ks, law.beta, 1e-3, law=law)


def test_a_dob_keeps_the_margin_of_its_own_estimate() -> None:
    """M̄ = 3M is far beyond PPC's 2M, and stable with c = 0.3: c·a = 0.9."""
    arm = rail(1.0)
    law = Dob(mbar=3.0, cutoff_hz=-np.log(0.7) / 2e-3 / np.pi, ks=6.0, beta=6.0, period=1e-3)
    assert not stability(arm, 3.0, 6.0, 6.0, 1e-3, limits=False, samples=8, box={"slide0": (-1.0, 1.0)}).stable
    found = stability(arm, 3.0, 6.0, 6.0, 1e-3, law=law, limits=False, samples=8, box={"slide0": (-1.0, 1.0)})
    assert found.stable
    assert "law dob (cutoff_hz = " in found.loop.words((True,))


def test_an_experiments_laws_have_their_own_loops_and_bands() -> None:
    arm = rail(1.0)
    laws = {
        "PPC": Ppc(mbar=0.6, **GAINS),
        "DOB": Dob(mbar=3.0, cutoff_hz=20.0, **GAINS),
        "Steep": Implicit(mbar=1.5, gain=40.0, share=1.0, **GAINS),
        "Twist": Sta(mbar=0.6, k1=1.0, k2=1.0, **GAINS),
        "Barrier": Barrier(mbar=0.6, width=0.02, limit=40.0, **GAINS),
    }
    found = law_loops(arm, laws)
    assert sorted(item.title for item in found) == ["DOB", "PPC, Twist, Barrier", "Steep"]
    said = gain_warnings(arm, laws, box={"slide0": (-1.0, 1.0)})
    assert len(said) == 1
    assert said[0].startswith("Steep: inside its band")
    assert said[0].endswith("lower its share λ")


def test_the_command_line_takes_a_law_with_its_parameters(capfd: pytest.CaptureFixture[str]) -> None:
    shared = ["stability", "two_link", "--mbar", "0.05,0.03", "--ks", "5", "--beta", "5", "--period", "0.001"]

    def asked(*more: str) -> tuple[Any, str, str]:
        with pytest.raises(SystemExit) as end:
            main([*shared, *more])
        return end.value.code, *capfd.readouterr()

    status, out, _ = asked("--law", "dob", "--set", "cutoff_hz=100", "--json")
    assert status == 0
    assert json.loads(out)["law"] == {"name": "dob", "cutoff_hz": 100.0}
    for wrong, message in (
        (["--law", "dop"], "did you mean 'dob'"),
        (["--law", "dob"], "needs cutoff_hz"),
        (["--law", "dob", "--set", "cutoff=3"], "has no parameter 'cutoff'"),
        (["--set", "cutoff_hz=3"], "without --law"),
        (["--law", "ism", "--set", "gain=1"], "it switches"),
        (["--law", "dob", "--set", "cutoff_hz=100", "--certify"], "asmc-pin verify two_link --mbar 0.0233"),
        (["--law", "adrc", "--set", "observer_hz=100", "--certify"], "not of that of adrc"),
        (["--law", "slotine_li"], "computes with a model of the arm"),
        (["--law", "ntsm", "--set", "stiffness=8", "--set", "gain=1", "--set", "boundary=0.1"], "exponent = 1"),
    ):
        status, out, said = asked(*wrong)
        assert (status, out) == (2, "")
        assert message in " ".join(said.split())


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("implicit", {"gain": 20.0, "share": 0.2}),
        ("bsmc", {"gain": 20.0, "boundary": 0.001}),
        ("barrier", {"width": 0.05, "limit": 20.0}),
        ("ivf", {"gain": 5.0}),
    ],
)
def test_an_unstable_loop_of_a_law_with_a_band_or_a_bound_has_a_remedy(name, settings):
    """The search for it makes gains and period extreme: a band becomes narrow, and `ivf` bears no period beyond 2/G."""
    law = CONTROLLERS[name](mbar=0.05, ks=8.0, beta=8.0, period=0.001, **settings)
    report = stability(load_arm("two_link"), 0.05, 8.0, 8.0, 0.001, law=law)
    assert not report.stable
    assert "remedy:" in "\n".join(report.lines())


@pytest.mark.parametrize(
    "law",
    [
        Dob(mbar=1.0, cutoff_hz=40.0, **GAINS),
        Implicit(mbar=1.0, gain=20.0, share=0.3, **GAINS),
        Bsmc(mbar=1.0, gain=2.0, boundary=0.1, **GAINS),
    ],
    ids=lambda law: type(law).__name__,
)
@pytest.mark.parametrize("delay", [0.0, 1.0])
def test_the_error_under_a_drifting_load_is_that_of_the_laws_own_map(law: Any, delay: float) -> None:
    """z_k = z₀ + k z₁ with z₁ = F z₁ + Bḣ L and z₀ = F z₀ − z₁: and joints that do not couple, however full M is."""
    a = np.random.default_rng(0).standard_normal((3, 3))
    mass = a @ a.T + np.eye(3)
    loop = SampledLoop([0.3, 0.2, 0.4], 12.0, 9.0, 1e-3, law=law, delay=delay)
    system = closed_loop(mass, loop)
    rest = np.eye(len(system.matrix)) - system.matrix
    steady = -np.linalg.solve(rest, -np.linalg.solve(rest, 1e-3 * system.load))[system.blocks["q"]]
    assert steady == pytest.approx(np.diag(drift_error(loop, np.ones(3))), rel=1e-6, abs=1e-12)
    assert loop.modal is law.separates
    if loop.modal:
        one_by_one = modal_radius(inertia_ratios(mass, loop.mbar), loop).max()
        assert one_by_one == pytest.approx(system.spectral_radius(), abs=1e-10)


def test_a_band_counts_in_the_loop_by_its_slope_also_under_gains_that_take_any_reading_out_of_it() -> None:
    """A search makes K_s so large that s of the smallest reading is beyond Φ, and yet the set point is in the band."""

    def matrix(law: Any) -> Any:
        return closed_loop(np.diag([2.0, 1.0]), SampledLoop([0.3, 0.2], 1e8, 9.0, 1e-3, law=law)).matrix

    narrow, wide = (matrix(Bsmc(mbar=1.0, gain=500.0 * width, boundary=width, **GAINS)) for width in (0.05, 1e6))
    np.testing.assert_allclose(narrow, wide, rtol=1e-9)
    assert np.abs(matrix(Ppc(mbar=1.0, **GAINS)) - wide).max() > 0.9 * np.abs(wide).max()


def test_a_law_of_ones_own_that_says_nothing_of_modes_is_not_taken_apart_into_them() -> None:
    """What it adds is no multiple of M̄, so that joints that M couples differ from what each mode alone would do."""

    class Damped(Ppc):
        def step(self, state: Any, sample: Any, setpoint: Any) -> Any:
            torque, _, state = self.pole_placement(state, sample, setpoint)
            return torque - 30.0 * sample.v, state

    mass = np.array([[2.0, 0.9], [0.9, 1.0]])
    loop = SampledLoop([0.3, 0.05], 12.0, 9.0, 1e-3, law=Damped(mbar=1.0, **GAINS))
    modes = [np.array([[1.0 / ratio]]) for ratio in inertia_ratios(mass, loop.mbar)]
    apart = max(closed_loop(mode, loop.mode).spectral_radius() for mode in modes)
    assert abs(apart - closed_loop(mass, loop).spectral_radius()) > 1e-3
    assert not loop.modal


def test_along_an_experiment_the_condition_of_a_low_passed_estimate_is_that_on_c_mbar(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "low.toml"
    file.write_text(
        """name = "low"
arm = "two_link"
period = 0.001
duration = 0.1
[reference]
kind = "multisine"
offset = [-1.2, 0.3]
amplitude = [0.4, 0.6]
frequency = [0.5, 0.7]
[defaults]
mbar = [0.08, 0.05]
ks = 8.0
beta = 8.0
[controllers.PPC]
law = "ppc"
[controllers.DOB]
law = "dob"
cutoff_hz = 50.0
"""
    )
    with pytest.raises(SystemExit) as end:
        main(["verify", "two_link", "--mbar", "0.08,0.05", "--along", str(file), "--json"])
    found = json.loads(capfd.readouterr().out)
    assert end.value.code == 1
    assert found["verdict"] == "violated"
    low = found["low_passed"]["DOB"]
    assert set(found["low_passed"]) == {"DOB"}
    assert low["weight"] == pytest.approx(1.0 - np.exp(-2.0 * np.pi * 50.0 * 1e-3))
    assert low["mbar"] == pytest.approx(low["weight"] * np.array([0.08, 0.05]))
    assert low["verdict"] == "unrefuted"
    assert low["lower"] < 1.0
