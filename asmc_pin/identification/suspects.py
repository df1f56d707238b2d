"""What most often makes a log contradict a URDF: signs, order and units of columns, and the direction of gravity.

Each suspicion is a small change of the log or of the arm. It is tested as such: with the change, and with friction,
armature and offset fitted joint by joint, how much of the logged torque does the model leave? The score is the mean
over the joints of log(RMS left / RMS logged); what lowers it most is named, and the search goes on from there. The
payload is the first of the suspects: what a body on the last link explains as well is not named, but estimated.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from asmc_pin._typing import Array, IntArray
from asmc_pin.arms import Arm
from asmc_pin.identification.filtered_motion import FilteredMotion
from asmc_pin.identification.suspicion import Suspicion
from asmc_pin.identification.velocity_suspects import suspect_velocities
from asmc_pin.logs.joint_log import JointLog
from asmc_pin.words.text import quoted

_GAIN = 0.05  # of the score, for a suspicion to be named
_TIE = 0.01
_MOST_ROWS = 500
_HEAVIEST = 10.0  # payload over the mass of the whole arm
_LIGHTEST = 1.5  # what is taken away over the mass of the last body
_ROUNDS = 4
_FACTORS = {1e-3: "N·mm", 1e3: "kN·m", 1e-2: "N·cm"}


@dataclass(frozen=True, eq=False)
class View:
    """A log and an arm as a suspicion has them; arrays of shape (R, nv).

    Attributes:
        arm: The arm.
        q: rad.
        v: rad/s.
        a: rad/s².
        torque: N·m.
    """

    arm: Arm
    q: Array
    v: Array
    a: Array
    torque: Array

    def model(self) -> Array:
        """The torque that the URDF says, (R, nv), N·m."""
        inertial = np.einsum("tij,tj->ti", self.arm.mass_matrix(self.q), self.a)
        return np.asarray(inertial + self.arm.bias(self.q, self.v))


class _Change(NamedTuple):
    text: str
    view: View
    model: Array
    options: tuple[str, ...] = ()


def view_of(arm: Arm, motion: FilteredMotion) -> View:
    """Some hundred rows of a log."""
    rows = motion.rows[:: max(1, len(motion.rows) // _MOST_ROWS)]
    return View(arm, motion.q[rows], motion.v[rows], motion.a[rows], motion.torque(motion.time[rows]))


def suspect(arm: Arm, motion: FilteredMotion, log: JointLog) -> list[Suspicion]:
    """Test every suspicion.

    Args:
        arm: As its URDF says.
        motion: The log, filtered.
        log: As it was read.

    Returns:
        What was confirmed, the gravest first; empty where the log agrees with the URDF as far as these go.
    """
    found = [*suspect_velocities(motion, log)]
    here = view_of(arm, motion)
    model = here.model()
    score = _score(here, model)
    for _ in range(_ROUNDS):
        tried = [(_score(change.view, change.model), change) for change in _changes(here, model)]
        least, best = min(tried, key=lambda item: item[0])
        # What may be carried is not known yet: a change counts where it is worth naming beside a payload too.
        pairs = ((here, model), (best.view, best.model))
        laden = [_score(view, torque + _carried(view, torque)) for view, torque in pairs]
        if least > score - _GAIN or laden[1] > laden[0] - _GAIN:
            break
        ties = [change.text for other, change in tried if other < least + _TIE and change is not best]
        also = f"; just as well: {'; or '.join(ties[:2])}" if ties else ""
        found.append(Suspicion(f"{best.text}{also}", least, score, () if ties else best.options))
        score, here, model = least, best.view, best.model
    return found


def _score(view: View, model: Array) -> float:
    left = []
    for j in range(view.arm.nv):
        columns = np.column_stack(
            [np.sign(view.v[:, j]), view.v[:, j], view.a[:, j], np.ones(len(model)), -np.ones(len(model))]
        )
        size = np.maximum(np.linalg.norm(columns, axis=0), 1e-12)
        _, rest = nnls(columns / size, view.torque[:, j] - model[:, j])
        logged = float(np.linalg.norm(view.torque[:, j] - view.torque[:, j].mean()))
        left.append(float(np.log(max(float(rest), 1e-9 * logged, 1e-12) / max(logged, 1e-12))))
    return float(np.mean(left))


def _changes(view: View, model: Array) -> Iterator[_Change]:
    nv, names = view.arm.nv, [quoted(name) for name in view.arm.joint_names]

    def moved(text: str, torque: Array, *options: str, **motion: Array) -> _Change:
        other = View(view.arm, motion["q"], motion["v"], motion["a"], torque)
        return _Change(text, other, other.model(), options)

    def scaled(text: str, factors: Array) -> _Change:
        given = ",".join(f"{factor:g}" for factor in factors)
        return _Change(text, replace(view, torque=view.torque * factors), model, ("--motor-constant", given))

    for j in range(nv):
        sign = np.where(np.arange(nv) == j, -1.0, 1.0)
        flipped = {"q": view.q * sign, "v": view.v * sign, "a": view.a * sign}
        yield scaled(f"the torque of joint {names[j]} has the opposite sign", sign)
        yield moved(f"the angle of joint {names[j]} has the opposite sign", view.torque, **flipped)
        yield moved(f"angle and torque of joint {names[j]} have the opposite sign", view.torque * sign, **flipped)
    yield scaled("all torques have the opposite sign", np.array([-1.0]))
    orders = [
        (f"joints {names[i]} and {names[j]} are swapped", _swapped(nv, i, j)) for i in range(nv) for j in range(i)
    ]
    if nv > 2:
        orders.append(("the joints stand in reverse order, tip first", np.arange(nv, dtype=np.int64)[::-1]))
    for text, order in orders:
        rows = {"q": view.q[:, order], "v": view.v[:, order], "a": view.a[:, order]}
        yield _Change(
            f"the torques of {text}" if text[0] == "j" else text + " (torques)",
            replace(view, torque=view.torque[:, order]),
            model,
        )
        yield moved(f"the angles of {text}" if text[0] == "j" else text + " (angles)", view.torque, **rows)
        yield moved(text, view.torque[:, order], **rows)
    for factor, unit in _FACTORS.items():
        yield scaled(f"the torques are in {unit}, not N·m", np.array([factor]))
    turning = np.array([kind == "revolute" for kind in view.arm.joint_kinds])
    for factor, text, options in (
        (np.deg2rad(1.0), "the angles are in degrees, not rad", ("--degrees",)),
        (2.0 * np.pi, "the angles are in turns", ()),
    ):
        scale = np.where(turning, factor, 1.0)
        yield moved(text, view.torque, *options, q=view.q * scale, v=view.v * scale, a=view.a * scale)
    yield _along_gravity(view, model)


def _swapped(nv: int, i: int, j: int) -> IntArray:
    order = np.arange(nv, dtype=np.int64)
    order[[i, j]] = order[[j, i]]
    return order


def _along_gravity(view: View, model: Array) -> _Change:
    """The direction of gravity that explains the torques best, of the magnitude that the arm is loaded with."""
    axes = (view.arm.replace(gravity=9.81 * axis) for axis in np.eye(3))
    unit = np.stack([arm.gravity(view.q) / 9.81 for arm in axes], axis=-1)
    old = view.arm.gravity_vector
    rest = view.torque - (model - unit @ old)
    found = _beside_friction(view, unit, rest)
    size, fitted = float(np.linalg.norm(old)) or 9.81, float(np.linalg.norm(found))
    new = found * size / fitted if fitted > 0.0 else old
    angle = np.rad2deg(np.arccos(np.clip(new @ old / (size * float(np.linalg.norm(old)) or 1.0), -1.0, 1.0)))
    told = ", ".join(f"{x:.2f}" for x in new)
    if angle < 3.0:
        new = old  # nothing to be named
    text = f"gravity points along ({told}) m/s² in the base frame, {angle:.0f}° from what was assumed; give gravity so"
    arm = view.arm.replace(gravity=new)
    return _Change(text, replace(view, arm=arm), model + unit @ (new - old), ("--gravity", told.replace(" ", "")))


def _carried(view: View, model: Array) -> Array:
    """Torque, (R, nv), of the payload on the last link that explains best what the URDF leaves, beside friction.

    None, where that is heavier than anything the arm could carry, or takes away far more than the last body: torques in
    N·mm are no payload of tonnes, and those in kN·m no arm without mass.
    """
    links = view.arm.regressor(view.q, view.v, view.v, view.a)
    bodies = view.arm.inertial_parameters.size - view.arm.nv
    last = links[..., bodies - 10 : bodies]
    body = _beside_friction(view, last, view.torque - model)
    masses = view.arm.inertial_parameters[:bodies:10]
    possible = -_LIGHTEST * masses[-1] < body[0] < _HEAVIEST * masses.sum()
    return np.asarray(last @ body) if possible else np.zeros_like(model)


def _beside_friction(view: View, terms: Array, left: Array) -> Array:
    """What multiplies the terms, (R, nv, n), in least squares for a torque that is left, (R, nv); shape (n,).

    Friction, armature and offset of each joint are fitted beside them; the joints by their own size.
    """
    nv, rows = view.arm.nv, len(left)
    columns, target = [], []
    for j in range(nv):
        weight = 1.0 / max(float(np.std(view.torque[:, j])), 1e-9)
        own = np.zeros((rows, 4 * nv))
        own[:, 4 * j : 4 * j + 4] = np.column_stack([np.sign(view.v[:, j]), view.v[:, j], view.a[:, j], np.ones(rows)])
        columns.append(weight * np.hstack([terms[:, j], own]))
        target.append(weight * left[:, j])
    return np.asarray(np.linalg.lstsq(np.vstack(columns), np.concatenate(target), rcond=None)[0][: terms.shape[-1]])
