"""Whether what a check printed is true, judged by Pinocchio and samples: without the checker, without the prover."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin import load_arm
from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.condition import lemma1_norm, weighted_norm
from asmc_pin.condition.certificate.container import read
from asmc_pin.errors import NotPositiveDefinite
from asmc_pin.sampled import SampledLoop, spectral_radius
from asmc_pin.sampled.frozen_arms import gravity_stiffness

SAMPLES = 400

LARGEST = 1e9


def untruths(path: Path, said: Mapping[str, Any], folder: Path) -> list[str]:
    """Sentences of a valid ``check --json`` that the arm inside the file contradicts.

    Args:
        path: The certificate.
        said: What ``check --json`` printed.
        folder: Where the URDF inside may be written.

    Returns:
        One line for each; empty where nothing was found that is false.
    """
    urdf = folder / "inside.urdf"
    urdf.write_text(read(path).urdf, encoding="utf-8")
    # Beside an armature of 1e300 kg·m² all else is rounded away: true it may be, and no float can judge it.
    ends = [end for value in said["armature"] for end in (value if isinstance(value, list) else [value])]
    if max(ends) > LARGEST:
        return []
    arms = list(arms_of(urdf, said))
    if any(list(arm.joint_names) != said["joints"] for arm in arms):
        return ["the joints are others"]
    rng = np.random.default_rng(0)
    boxes = said.get("boxes") or [said["box"]]
    if "about" in said:
        judge = {"bounds": _untrue_bounds, "sampled loop": _untrue_loop}[said["about"]]
        return [line for arm, box in product(arms, boxes) for line in judge(said, arm, _configurations(said, box, rng))]
    norm = {"lemma1": lemma1_norm, "weighted": weighted_norm}[said["condition"]]
    mbar = np.array(said["mbar"])
    found = []
    largest, largest_scaled = 0.0, 0.0
    for arm, box in product(arms, boxes):
        mass = arm.mass_matrix(_configurations(said, box, rng))
        try:
            largest = max(largest, float(norm(mass, mbar).max()))
            if said["scale_proven"] > 0.0:
                largest_scaled = max(largest_scaled, float(norm(mass, said["scale_proven"] * mbar).max()))
        except NotPositiveDefinite:
            found.append("M is not positive definite")
    if said["scale_proven"] > 0.0 and largest_scaled >= 1.0:
        found.append(f"the norm at the scale that is proven is {largest_scaled}")
    if said["upper"] is not None and largest >= said["upper"]:
        found.append(f"the norm is {largest}, above the bound {said['upper']}")
    if said["verdict"] == "holds" and largest >= 1.0:
        found.append(f"it says holds, and the norm is {largest}")
    if said["upper"] is not None and said["lower"] >= said["upper"]:
        found.append("its own two bounds contradict each other")
    if said["verdict"] == "violated" and not (said["lower"] >= 1.0 or said["scale_refuted"] <= 1.0):
        found.append("it says violated, and shows no violation")
    return found


def _configurations(said: Mapping[str, Any], box: Mapping[str, Any], rng: np.random.Generator) -> Array:
    lower, upper = np.array([box[name] for name in said["joints"]]).T
    corners = rng.choice([0.0, 0.5, 1.0], size=(SAMPLES, lower.size))
    share = np.concatenate((rng.random((SAMPLES, lower.size)), corners))
    return np.asarray(lower + share * (upper - lower))


def _untrue_bounds(said: Mapping[str, Any], arm: Arm, q: Array) -> list[str]:
    """What eigenvalues and velocity forces at samples contradict."""
    scaling = np.array(said["scaling"])
    values = np.linalg.eigvalsh(arm.mass_matrix(q) * scaling * scaling[:, None])
    x = np.random.default_rng(1).normal(size=q.shape)
    x /= np.linalg.norm(x, axis=1)[:, None]
    forces = np.linalg.norm(scaling * (arm.bias(q, scaling * x) - arm.gravity(q)), axis=1).max()
    found = []
    if said["lower"][0] is not None and values.min() <= said["lower"][0]:
        found.append(f"an eigenvalue is {values.min()}, and {said['lower'][0]} is said to be below all")
    if said["upper"][0] is not None and values.max() >= said["upper"][0]:
        found.append(f"an eigenvalue is {values.max()}, and {said['upper'][0]} is said to be above all")
    if said["coriolis"][0] is not None and forces > said["coriolis"][0]:
        found.append(f"velocity forces are {forces}, above {said['coriolis'][0]}")
    ratio = said["condition_number"][0]
    if ratio is not None and (values[:, -1] / values[:, 0]).max() > ratio:
        found.append("a condition number is above its bound")
    return found


def _untrue_loop(said: Mapping[str, Any], arm: Arm, q: Array) -> list[str]:
    """What the loop's own linear map at samples contradicts."""
    loop = SampledLoop(np.array(said["mbar"]), said["ks"], said["beta"], said["period"])
    mass = arm.mass_matrix(q)
    radius = float(spectral_radius(mass, loop).max())
    # Gains may be so small that the map's slowest root cannot be told from 1 in floats.
    if said["verdict"] == "stable" and radius >= 1.0 + 1e-9:
        return [f"it says stable, and the spectral radius is {radius}"]
    if said["gravity"] is not None:
        stiffness = gravity_stiffness(arm, q) * said["gravity"] / np.linalg.norm(arm.gravity_vector)
        resting = float(spectral_radius(mass, loop, stiffness=stiffness).max())
        if resting >= 1.0 + 1e-9:
            return [f"it says stable at rest under gravity, and the spectral radius is {resting}"]
    low, high = said["stable_between"]
    if said["verdict"] == "unstable" and low < said["shown"][0] and said["shown"][1] < high:
        return ["it says unstable, and shows no instability"]
    return []


def arms_of(urdf: Path, said: Mapping[str, Any]) -> Any:
    """The arms that the hypotheses name: every lock, both ends of the payload, both ends of the armature."""
    names = list(said["locked"])
    angles = [value if isinstance(value, list) else [value] for value in said["locked"].values()]
    ends = [value if isinstance(value, list) else [value, value] for value in said["armature"]]
    payload = said["payload"]
    loads: list[Any] = [None]
    if payload is not None:
        masses = payload["mass"] if isinstance(payload["mass"], list) else [payload["mass"]]
        heaviest = payload.get("inertia", [0.0] * 6)
        shapes = [payload.get("inertia_lightest", heaviest), heaviest][-len(masses) :]
        loads = [
            {
                "mass": mass,
                "com": payload["com"],
                "link": payload["link"],
                "inertia": shape if mass > 0.0 else [0.0] * 6,
            }
            for mass, shape in zip(masses, shapes, strict=True)
        ]
    for chosen, load, end in product(product(*angles), loads, (0, 1)):
        lock = dict(zip(names, chosen, strict=True))
        yield load_arm(urdf, payload=load, lock=lock or None, armature=[pair[end] for pair in ends])
