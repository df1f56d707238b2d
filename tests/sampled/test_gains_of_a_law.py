"""Gains for `dob` and `implicit`: their margins, the condition on cM̄, and what they are worth against PPC's."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from asmc_pin.arms import Arm, load_arm
from asmc_pin.cli import main
from asmc_pin.errors import ParameterError
from asmc_pin.sampled import stability
from asmc_pin.sampled.error_prediction import drift_error
from asmc_pin.sampled.gain_choice.gain_design import GainDesign
from asmc_pin.sampled.gain_choice.gains import suggest_gains
from asmc_pin.sampled.noise.sensor_model import loop_sensor

MBAR = [0.5, 0.2]
NOISY: dict[str, Any] = {"velocity_noise": 2e-3}


@pytest.fixture(scope="module")
def two_link() -> Arm:
    return load_arm("two_link")


def designed(arm: Arm, law: str | None, **more: Any) -> GainDesign:
    sensor = loop_sensor(arm.nv, **NOISY)
    return suggest_gains(arm, MBAR, 1e-3, sensor=sensor, law=law, samples=128, **more)


@pytest.mark.parametrize(("law", "settings"), [("dob", {"cutoff_hz": 60.0}), ("implicit", {"share": 0.1})])
def test_gains_of_a_law_keep_the_margins_and_no_more_noise_than_ppc(
    two_link: Arm, law: str, settings: dict[str, float]
) -> None:
    plain, found = designed(two_link, None), designed(two_link, law, settings=settings)
    assert found.met
    assert found.bought is not None
    assert plain.report is not None
    assert found.report is not None
    assert plain.report.noise is not None
    assert found.report.noise is not None
    assert (found.report.noise.torque_rms <= plain.report.noise.torque_rms).all()
    assert found.bought.noise == pytest.approx(found.report.noise.torque_rms / plain.report.noise.torque_rms)
    # Of the loop itself, what was said of it: stable, with the margin, and its error against PPC's.
    loop = found.loop
    again = stability(two_link, loop.mbar, loop.ks, float(loop.beta[0]), 1e-3, law=loop.law, samples=256, limits=False)
    assert again.stable
    ratio = drift_error(loop, np.ones(2)) / drift_error(plain.loop, np.ones(2))
    assert ratio == pytest.approx(found.bought.drift, rel=1e-12)
    assert f"{found.bought.drift:.3g} times" in "\n".join(found.lines())
    # The condition is one on cM̄, which is M̄ at most.
    assert (float(loop.law.estimate_weight) * loop.mbar <= np.array(MBAR) * (1.0 + 1e-12)).all()


def test_other_laws_have_no_choice_of_gains(two_link: Arm) -> None:
    with pytest.raises(ParameterError, match="these have: dob, implicit"):
        designed(two_link, "ivf")


@pytest.mark.long
def test_the_command_designs_for_a_law_and_says_what_it_buys(capfd: pytest.CaptureFixture[str]) -> None:
    def asked(*more: str) -> tuple[Any, str, str]:
        with pytest.raises(SystemExit) as end:
            main(["design", "two_link", *more])
        return end.value.code, *capfd.readouterr()

    status, out, _ = asked("--gains", "--period", "0.001", "--law", "implicit", "--set", "share=0.1", "--json")
    found = json.loads(out)["gains"]
    assert status == 0
    assert found["law"]["share"] == 0.1
    assert found["pid"] is None
    assert set(found["bought"]) == {"drift_ratio", "reversal_ratio", "noise_ratio"}
    for wrong in (["--law", "dob"], ["--set", "share=0.1"]):
        status, out, said = asked(*wrong)
        assert (status, out) == (2, "")
        assert "add --gains and --period" in said
