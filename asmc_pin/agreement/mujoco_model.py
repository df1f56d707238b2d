"""The arm as MuJoCo understands it, from the same URDF text.

MuJoCo is an extra (``pip install 'asmc-pin[agree]'``) and is imported on first use.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType
from typing import Any

import numpy as np
from lxml import etree

from asmc_pin._typing import Array
from asmc_pin.agreement.folded_bodies import fold_impossible
from asmc_pin.arms import Arm
from asmc_pin.arms.urdf.urdf_document import read_again
from asmc_pin.errors import MissingDependencyError, NotComparableError

# What MuJoCo is given where a link has no mass or no rotational inertia, which it refuses: kg, kg·m².
LEAST_INERTIA = 1e-14
# The arms accept inertias that break the triangle inequality by a rounding of their exporter (1e-9 of the largest
# moment). MuJoCo judges it exactly, after a diagonalisation of its own.
_ROUNDING = 1e-14
# Before every link's name: "world" is MuJoCo's own, and the payload's body has to differ from every link.
_LINK = "link "


def import_mujoco() -> ModuleType:
    """MuJoCo.

    Raises:
        MissingDependencyError: it is not installed.
    """
    try:
        import mujoco
    except ImportError:
        raise MissingDependencyError("mujoco", "agree", "an independent engine to compare the arm with") from None
    module: ModuleType = mujoco
    return module


@contextmanager
def unheard_warnings() -> Iterator[None]:
    """Keep MuJoCo from printing its warnings, and from writing them into a file in the user's folder."""
    mujoco = import_mujoco()
    usual = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(usual)


class Twin:
    """The arm in MuJoCo: same links, gravity, armature, payload and locks; no friction, no limits, no contacts.

    Joints that mimic others are free in MuJoCo, whose own coupling is a soft constraint. Its terms are projected here:
    Sᵀ M S and Sᵀ (C q̇ + g), with S from the URDF's numbers.

    Args:
        arm: The arm.

    Attributes:
        arm: The arm.
        engine: ``"MuJoCo x.y.z"``.
        notes: What MuJoCo had to be given otherwise than the URDF has it.

    Raises:
        MissingDependencyError: MuJoCo is not installed.
        NotComparableError: MuJoCo refuses this URDF.
    """

    def __init__(self, arm: Arm) -> None:
        self._mujoco = import_mujoco()
        self.arm = arm
        self.engine = f"MuJoCo {self._mujoco.__version__}"
        try:
            self._model, notes = self._compile(least=0.0)
        except ValueError:
            # Only then: a speck of inertia on every massless link is not nothing to a small arm.
            try:
                self._model, notes = self._compile(least=LEAST_INERTIA)
            except ValueError as error:
                reason = " ".join(str(error).split())
                raise NotComparableError(arm.source, f"{self.engine} refuses {arm.name}: {reason}") from None
            notes.append(
                f"links without a mass or rotational inertia get {LEAST_INERTIA:g} (kg, kg·m²) in {self.engine}"
            )
        names = list(arm.model.names)[1:]
        if self._model.nv != len(names):
            raise NotComparableError(
                arm.source, f"{self.engine} gives {arm.name} {self._model.nv} joints, not {len(names)}"
            )
        self._data = self._mujoco.MjData(self._model)
        joints = [self._model.joint(name) for name in names]
        self._follow, self._from = _followed(arm, names)
        self._q = np.array([joint.qposadr[0] for joint in joints])
        self._v = np.array([joint.dofadr[0] for joint in joints])
        self.notes = tuple(notes)

    def _compile(self, least: float) -> tuple[Any, list[str]]:
        """MuJoCo's model, no mass and no moment of inertia below `least`, and the notes on it."""
        spec = self._mujoco.MjSpec.from_string(dynamics_only(self.arm.urdf_text))
        spec.option.gravity = self.arm.gravity_vector
        spec.option.integrator = self._mujoco.mjtIntegrator.mjINT_RK4
        spec.compiler.boundmass = spec.compiler.boundinertia = least
        self._lock(spec)
        fold_impossible(spec)
        notes = _round_inertias(spec)
        self._load(spec)
        for name, armature in zip(list(self.arm.model.names)[1:], self.arm.model.armature, strict=True):
            spec.joint(name).armature = armature
        return spec.compile(), notes

    def mass_and_bias(self, q: Array, v: Array) -> tuple[Array, Array]:
        """M(q) with armature and C(q, q̇)q̇ + g(q), at q and v of shape (nv,); shapes (nv, nv) and (nv,)."""
        mujoco, model, data = self._mujoco, self._model, self._data
        self._set(q, v)
        mujoco.mj_forward(model, data)
        mass = np.empty((model.nv, model.nv))
        for i, unit in enumerate(np.eye(model.nv)):
            mujoco.mj_mulM(model, data, mass[i], unit)
        mass, follow = mass[np.ix_(self._v, self._v)], self._follow
        return follow.T @ mass @ follow, np.array(data.qfrc_bias[self._v]) @ follow

    def run(self, q: Array, v: Array, torque: Array, step: float) -> tuple[Array, Array]:
        """Integrate with MuJoCo's Runge-Kutta scheme of fourth order, the torque held over each step.

        Where joints mimic others, MuJoCo's projected terms are integrated by the same scheme.

        Args:
            q: Start, shape (nv,), rad.
            v: Start, shape (nv,), rad/s.
            torque: Shape (steps, nv), N·m.
            step: s.

        Returns:
            q and v after each step, each of shape (steps, nv).
        """
        if self.arm.mimics:
            return self._run_projected(q, v, torque, step)
        model, data = self._model, self._data
        model.opt.timestep = step
        self._mujoco.mj_resetData(model, data)
        self._set(q, v)
        path, speed = np.empty_like(torque), np.empty_like(torque)
        for k, applied in enumerate(torque):
            data.qfrc_applied[self._v] = applied
            self._mujoco.mj_step(model, data)
            path[k], speed[k] = data.qpos[self._q], data.qvel[self._v]
        return path, speed

    def _run_projected(self, q: Array, v: Array, torque: Array, step: float) -> tuple[Array, Array]:
        path, speed = np.empty_like(torque), np.empty_like(torque)
        for k, applied in enumerate(torque):
            slopes_q, slopes_v, q_at, v_at = np.zeros_like(q), np.zeros_like(v), q, v
            for weight, span in ((1.0, 0.5 * step), (2.0, 0.5 * step), (2.0, step), (1.0, 0.0)):
                mass, bias = self.mass_and_bias(q_at, v_at)
                slope = np.linalg.solve(mass, applied - bias)
                slopes_q, slopes_v = slopes_q + weight * v_at, slopes_v + weight * slope
                q_at, v_at = q + span * v_at, v + span * slope
            q, v = q + (step / 6.0) * slopes_q, v + (step / 6.0) * slopes_v
            path[k], speed[k] = q, v
        return path, speed

    def _set(self, q: Array, v: Array) -> None:
        self._data.qpos[self._q] = self._follow @ q + self._from
        self._data.qvel[self._v] = self._follow @ v

    def _lock(self, spec: Any) -> None:
        """Turn locked joints into rigid connections, by moving the child body to where the joint holds it."""
        for name, value in self.arm.locked.items():
            joint = spec.joint(name)
            body = joint.parent
            axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
            if joint.type == self._mujoco.mjtJoint.mjJNT_SLIDE:
                shift = np.empty(3)
                self._mujoco.mju_rotVecQuat(shift, axis * value, body.quat)
                body.pos = body.pos + shift
            else:
                turn, turned = np.empty(4), np.empty(4)
                self._mujoco.mju_axisAngle2Quat(turn, axis, value)
                self._mujoco.mju_mulQuat(turned, body.quat, turn)
                body.quat = turned
            spec.delete(joint)

    def _load(self, spec: Any) -> None:
        """Fasten the payload, a body without joint, to its link."""
        payload = self.arm.payload
        if payload is None or payload.mass == 0.0:
            return
        xx, xy, xz, yy, yz, zz = payload.inertia
        inertia = [xx, yy, zz, xy, xz, yz]
        body = spec.body(f"{_LINK}{payload.link}").add_body(name="payload", mass=payload.mass, ipos=list(payload.com))
        body.explicitinertial = True
        if any(inertia):
            body.fullinertia = inertia
        else:
            body.inertia = [LEAST_INERTIA] * 3


def dynamics_only(urdf: str) -> str:
    """The URDF without what does not bear on M, C and g, so that nothing looks for meshes: inertials and joints only.

    Numbers stay as they are written. Limits, friction, damping and mimics go too: the comparison is of free arms. Links
    get a prefix before their names.
    """
    root = read_again(urdf)
    for element in root.iter():
        if isinstance(element.tag, str) and element.tag.startswith("{"):
            element.tag = etree.QName(element).localname
    keep = {"link": {"inertial"}, "joint": {"parent", "child", "origin", "axis"}}
    for part in list(root):
        if part.tag not in keep:
            root.remove(part)
            continue
        for element in list(part):
            if element.tag not in keep[part.tag]:
                part.remove(element)
        for named in (part, *part) if part.tag == "link" else part:
            for key in ("name", "link"):
                if named.get(key) is not None:
                    named.set(key, _LINK + named.get(key))
        if part.get("type") == "fixed":  # files write the axis "0 0 0" there, which is no direction
            for axis in part.findall("axis"):
                part.remove(axis)
    text: str = etree.tostring(root, encoding="unicode")
    return text


def _followed(arm: Arm, names: Sequence[str]) -> tuple[Array, Array]:
    """S (n, nv) and the offsets (n,) of the joints by these names: the arm's own reading of the URDF is not used."""
    numbers = {name: i for i, name in enumerate(arm.joint_names)}
    written: dict[str | None, Any] = {}
    for joint in read_again(arm.urdf_text).iter():
        if isinstance(joint.tag, str) and etree.QName(joint).localname == "joint":
            for mimic in joint:
                if isinstance(mimic.tag, str) and etree.QName(mimic).localname == "mimic":
                    written.setdefault(joint.get("name"), mimic.attrib)  # of several the first counts
    matrix, offset = np.zeros((len(names), arm.nv)), np.zeros(len(names))
    for k, name in enumerate(names):
        ratio = 1.0
        while name not in numbers:
            follows = written[name]
            offset[k] += ratio * float(follows.get("offset", "0"))
            ratio *= float(follows.get("multiplier", "1"))
            name = follows["joint"]
        matrix[k, numbers[name]] = ratio
    return matrix, offset


def _round_inertias(spec: Any) -> list[str]:
    """Bring inertias that miss the triangle inequality by a rounding within it, by their largest moment alone."""
    notes = []
    for body in spec.bodies:
        full = np.array(body.fullinertia)
        if not np.all(np.isfinite(full)):
            continue
        xx, yy, zz, xy, xz, yz = full
        moments, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
        moments[0] = max(moments[0], 0.0)
        most = (moments[0] + moments[1]) * (1.0 - _ROUNDING)
        if moments[2] <= most:
            continue
        if moments[2] <= LEAST_INERTIA:
            continue
        name, share = body.name.removeprefix(_LINK), (moments[2] - most) / moments[2]
        notes.append(f"link '{name}': its largest moment lowered by {share:.1e} of it")
        moments[2] = most
        full = (axes * moments) @ axes.T
        body.fullinertia = [full[0, 0], full[1, 1], full[2, 2], full[0, 1], full[0, 2], full[1, 2]]
    return notes
