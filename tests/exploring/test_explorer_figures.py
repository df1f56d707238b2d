"""What the explorer's page computes, against Pinocchio and against what Python says of the same configurations."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arm_urdf import write
from browser import Page, shared_browser
from coupled_urdf import gripper
from viewer_cases import bent_arm

from asmc_pin import SampledLoop, lemma1_norm, load_arm, weighted_norm
from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.condition.domain.joint_box import resolve_box
from asmc_pin.condition.search.what_would_help import joint_to_blame
from asmc_pin.exploring.explored_arm import links_json
from asmc_pin.exploring.explorer_page import script
from asmc_pin.sampled import spectral_radius

SCRIPTS = ("mass_matrix.js", "small_matrices.js", "condition_at.js")
COUNT = 5

ARMS: dict[str, Callable[[Path], Arm]] = {
    "two_link": lambda _: load_arm("two_link"),
    "so101": lambda _: load_arm("so101"),
    "ur5 with payload and rotors": lambda _: load_arm(
        "ur5", payload={"mass": 2.5, "com": [0.01, 0.02, 0.1]}, armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05]
    ),
    "panda with a locked joint": lambda _: load_arm("panda", lock={"panda_joint4": -1.2}),
    "one that slides": lambda folder: load_arm(bent_arm(folder)),
    "one with joints that mimic others": lambda folder: load_arm(write(folder, gripper())),
}


@pytest.fixture(scope="module")
def page() -> Iterator[Page]:
    with shared_browser().page() as page:
        for name in SCRIPTS:
            page.run(f"{script(name)}; null")
        yield page


@pytest.fixture(scope="module", params=ARMS)
def arm(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Arm:
    return ARMS[request.param](tmp_path_factory.mktemp("arm"))


def configurations(arm: Arm) -> Array:
    box = resolve_box(arm)
    return np.random.default_rng(3).uniform(box.lower, box.upper, (COUNT, arm.nv))


def masses(page: Page, arm: Arm, q: Array) -> Array:
    links = json.dumps(links_json(arm.tree))
    found = page.run(
        f"(() => {{ const mass = new AsmcMass.MassMatrix({links});"
        f" return {json.dumps(q.tolist())}.map((q) => Array.from(mass.at(q))); }})()"
    )
    return np.array(found).reshape(len(q), arm.nv, arm.nv)


def at(page: Page, condition: str, mass: Array, mbar: Array) -> list[dict[str, Any]]:
    """What the page says of each mass matrix."""
    given = json.dumps(mass.reshape(len(mass), -1).tolist())
    return page.run(
        f"{given}.map((m) => {{ const mbar = Float64Array.from({json.dumps(mbar.tolist())}),"
        f" M = Float64Array.from(m), n = mbar.length, here = AsmcCondition.at('{condition}', M, mbar, n);"
        f" return {{ ...here, slopes: Array.from(here.slopes), direction: Array.from(here.direction),"
        f" alone: AsmcCondition.norm('{condition}', M, mbar, n) }}; }})"
    )


def test_the_inertia_in_the_browser_is_pinocchios_to_twelve_digits(page: Page, arm: Arm) -> None:
    q = configurations(arm)
    expected = arm.mass_matrix(q)
    assert np.abs(masses(page, arm, q) - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("condition", ["lemma1", "weighted"])
@pytest.mark.parametrize("share", [0.3, 3.0])  # satisfied at most configurations, and violated
def test_norm_direction_joint_to_blame_and_eigenvalues_are_pythons(
    page: Page, arm: Arm, condition: str, share: float
) -> None:
    q = configurations(arm)
    mass = arm.mass_matrix(q)
    # Uneven, so that no two eigenvalues are one.
    mbar = share * np.diagonal(mass, axis1=1, axis2=2).min(axis=0) * np.linspace(0.8, 1.3, arm.nv)
    norm = {"lemma1": lemma1_norm, "weighted": weighted_norm}[condition]
    expected = norm(mass, mbar)
    for M, value, here in zip(mass, expected, at(page, condition, mass, mbar), strict=True):
        assert here["norm"] == pytest.approx(value, rel=1e-9)
        assert here["alone"] == pytest.approx(value, rel=1e-9)
        np.testing.assert_allclose(here["inertias"], np.linalg.eigvalsh(M), rtol=1e-9)
        left = np.eye(len(mbar)) - np.linalg.solve(M, np.diag(mbar))
        np.testing.assert_allclose(here["ratios"], np.sort(1.0 - np.linalg.eigvals(left).real), rtol=1e-7)
        direction = np.array(here["direction"])
        assert np.linalg.norm(direction) == pytest.approx(1.0)
        grown = np.linalg.norm(left @ direction)
        if condition == "lemma1":
            assert grown == pytest.approx(value, rel=1e-9)
        else:
            np.testing.assert_allclose(left @ direction, (left @ direction @ direction) * direction, atol=1e-7 * value)
            assert grown == pytest.approx(value, rel=1e-7)
        joint, side = joint_to_blame(condition, M, mbar)
        slopes = np.array(here["slopes"])
        assert np.abs(slopes[joint]) == pytest.approx(np.abs(slopes).max(), rel=1e-6)
        assert (slopes[joint] > 0.0) == (side == "large")
        if here["breaks"] > 0.0:
            assert norm(M, here["breaks"] * mbar) == pytest.approx(1.0, abs=1e-7)
            assert norm(M, 0.999 * here["breaks"] * mbar) < 1.0


LOOPS = [(ks, beta, period) for ks in (0.5, 20.0, 150.0) for beta in (5.0, 60.0) for period in (0.001, 0.01)]


def test_stable_gains_at_a_configuration_are_those_of_the_sampled_loop(page: Page) -> None:
    arm = load_arm("ur5")
    mass = arm.mass_matrix(configurations(arm)[:2])
    mbar = 0.4 * np.diagonal(mass, axis1=1, axis2=2).min(axis=0)
    ends = 0
    for M, here in zip(mass, at(page, "weighted", mass, mbar), strict=True):
        for ks, beta, period in LOOPS:
            said = page.run(
                f"(() => {{ const l = AsmcCondition.loop({json.dumps(here['ratios'])},"
                f" {json.dumps({'ks': ks, 'beta': beta, 'period': period})});"
                " for (const k of ['beta', 'ks']) if (l[k] === Infinity) l[k] = 1e99; return l;"
                " })()"
            )

            def radius(*gains: float, M: Array = M) -> float:
                return float(spectral_radius(M, SampledLoop(mbar, *gains)))

            assert said["radius"] == pytest.approx(radius(ks, beta, period), abs=1e-7)
            for name, gains in (
                ("beta", lambda x, ks=ks, L=period: (ks, x, L)),
                ("ks", lambda x, b=beta, L=period: (x, b, L)),
                ("together", lambda x, ks=ks, b=beta, L=period: (x * ks, x * b, L)),
            ):
                if 0.0 < said[name] < 1e6:
                    ends += 1
                    assert radius(*gains(0.999 * said[name])) < 1.0 < radius(*gains(1.001 * said[name]))
                elif said[name] == 0.0:
                    assert radius(*gains(1e-3)) >= 1.0
                else:
                    assert radius(*gains(1e4)) < 1.0
    assert ends > 20, "ends were looked at"
