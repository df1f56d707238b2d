"""What `identify` found: how right the URDF is, estimates, and how far they can be trusted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.arms import Arm
from asmc_pin.identification.estimates import Estimate, correlation_time, estimates, unit_of
from asmc_pin.identification.excitation import Confusion
from asmc_pin.identification.suspicion import Suspicion
from asmc_pin.identification.torque_model import TorqueModel
from asmc_pin.identification.weighted_fit import Fit
from asmc_pin.identification.words_of_fit import dotted, given_up, on_the_bound, on_the_last_joint, rms_of, without_each
from asmc_pin.logs.joint_log import JointLog
from asmc_pin.words.shown import Cells, Shown, figure
from asmc_pin.words.text import printable, quoted

_LEFTOVER = 3.0  # times the filter's own correlation time
_LARGE = 0.3


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Shown):
    """What a log says of an arm.

    Attributes:
        arm: The arm, as it was loaded.
        log: The log.
        model: The terms of the torque at the rows that were looked at.
        suspicions: What contradicts the URDF; with any, nothing was estimated.
        parameters: Estimates with intervals, by name; empty where the log contradicts the URDF.
        fit: What they come of; None likewise.
        held_out: Rows that were not fitted, shape (R, nv).
        condition: Condition number of the regressor, columns at unit length.
        confusions: Parameters that were given up.
        residual: Logged − model torque of all that was estimated, shape (R, nv), N·m; of the URDF where nothing was.
        stages: RMS over the fitted rows of what is left of each joint's torque, by how much of the model is there;
            each (nv,), N·m.
        residual_held_out: RMS over the rows held out, shape (nv,), N·m; None where nothing was estimated.
        whiteness: Correlation time of each joint's residual over that of white noise through the same filter, (nv,).
    """

    arm: Arm
    log: JointLog
    model: TorqueModel
    suspicions: tuple[Suspicion, ...]
    parameters: Mapping[str, Estimate]
    fit: Fit | None
    held_out: BoolArray
    condition: float
    confusions: tuple[Confusion, ...]
    residual: Array
    stages: Mapping[str, Array]
    residual_held_out: Array | None
    whiteness: Array | None

    @property
    def explained(self) -> Array:
        """Share of each joint's logged torque, as RMS about its mean, that the model has on rows held out, (nv,)."""
        assert self.residual_held_out is not None
        return np.asarray(1.0 - self.residual_held_out / np.maximum(self.stages["logged"], 1e-12))

    def headline(self) -> str:
        """Whether the URDF stands."""
        if self.suspicions:
            return f"{self.arm.name}: the log contradicts the URDF: {self.suspicions[0].text}"
        worst = int(np.argmin(self.explained))
        return (
            f"{self.arm.name}: with what is estimated the model leaves {1 - self.explained.max():.1%} to "
            f"{1 - self.explained[worst]:.1%} of the logged torque on the part held out, most at "
            f"{quoted(self.arm.joint_names[worst])}"
        )

    def lines(self) -> list[str]:
        """What was read, and what it says."""
        said = [self.headline(), *self.log.found, *self.model.motion.told]
        said += [f"suspicion confirmed: {each.text}" for each in self.suspicions]
        if self.suspicions:
            said.append("nothing is estimated before that is mended in the log's options or in the URDF")
        else:
            said.append(
                "signs, order and units of the joints and the direction of gravity were tested, beside what may be "
                "carried: nothing to name"
            )
            said += self._words_by_joint()
        return said

    def table(self) -> Cells:
        """RMS of the torque of each joint, and what is left of it as more of the model is there."""
        header = ["joint (RMS, N·m)", *self.stages, *(["held out", "× white"] if self.fit is not None else [])]
        rows = []
        for j, name in enumerate(self.arm.joint_names):
            cells = [figure(float(stage[j]), ".3g") for stage in self.stages.values()]
            if self.residual_held_out is not None and self.whiteness is not None:
                cells += [figure(float(self.residual_held_out[j]), ".3g"), figure(float(self.whiteness[j]), ".2g")]
            rows.append([printable(name), *cells])
        return header, rows

    def remarks(self) -> list[str]:
        """Estimates, and how far they go."""
        if self.fit is None:
            return []
        said = ["estimates, with intervals of 95 %:"]
        said += [
            f"  {name} = {each.value:.4g} [{each.low:.4g}, {each.high:.4g}] {unit_of(name)}".rstrip()
            for name, each in self.parameters.items()
        ]
        said.append(f"condition number of the regressor, columns at unit length: {self.condition:.3g}")
        said += [given_up(each) for each in self.confusions]
        if self.fit.impossible is not None:
            said.append(on_the_bound(self.fit))
        left = [
            f"{printable(name)} × {value:.2g}"
            for name, value in zip(
                self.arm.joint_names, self.whiteness if self.whiteness is not None else (), strict=True
            )
            if value > _LEFTOVER
        ]
        if left:
            said.append(
                f"residuals are correlated for longer than noise would be ({', '.join(left)}): something is left that "
                "the model does not have. Intervals are as wide as that correlation asks, but no interval knows what "
                "is not in the model"
            )
        return said

    def table_of_estimates(self) -> Cells:
        """Estimates and their intervals."""
        rows = [
            [printable(name), f"{each.low:.4g}", f"{each.value:.4g}", f"{each.high:.4g}", unit_of(name)]
            for name, each in self.parameters.items()
        ]
        return ["parameter", "low", "value", "high", "unit"], rows

    def to_json_dict(self) -> dict[str, Any]:
        """The content of ``identify --json``; undefined figures are None."""
        return {
            "arm": self.arm.name,
            "log": self.log.name,
            "joints": list(self.arm.joint_names),
            "rows": len(self.log.time),
            "found": [*self.log.found, *self.model.motion.told],
            "suspicions": [each.text for each in self.suspicions],
            "parameters": {name: each.as_dict() for name, each in self.parameters.items()},
            "left": {name: stage.tolist() for name, stage in self.stages.items()},
            "residual_train": None if self.fit is None else self.fit.sigma.tolist(),
            "residual_held_out": None if self.residual_held_out is None else self.residual_held_out.tolist(),
            "whiteness": None if self.whiteness is None else self.whiteness.tolist(),
            "on_bound": self.fit is not None and self.fit.impossible is not None,
            "condition_number": self.condition if np.isfinite(self.condition) else None,
            "given_up": [{"name": dotted(each.name), "for": [*map(dotted, each.others)]} for each in self.confusions],
        }

    def _words_by_joint(self) -> list[str]:
        """How right the URDF is, joint by joint, and what is on the last link that should not be, or is not."""
        assert self.fit is not None
        said = []
        logged, urdf, rest = (self.stages[key] for key in ("logged", "URDF", "+ all"))
        without = without_each(self.fit)
        for j, name in enumerate(self.arm.joint_names):
            share = urdf[j] / max(logged[j], 1e-12)
            right = "right" if share < 0.1 else "nearly right" if share < _LARGE else "not enough"
            causes = sorted(without, key=lambda group: -without[group][j])
            told = [
                f"{group} (without it {without[group][j]:.3g})" for group in causes if without[group][j] > 1.5 * rest[j]
            ]
            said.append(
                f"{printable(name)}: the URDF alone is {right}, it leaves {urdf[j]:.3g} of {logged[j]:.3g} N·m; with "
                f"all estimates {rest[j]:.3g} stay"
                + (f"; what explains it: {', '.join(told[:3])}" if told else "; no single estimate explains much")
            )
        mass = self.parameters.get("payload.mass")
        if mass is not None and mass.high < 0.0:
            links = ", ".join(f"{quoted(link)} {kg:.3g} kg" for link, kg in on_the_last_joint(self.arm).items())
            said.append(
                f"what the last joint carries weighs {-mass.value:.3g} kg less than the URDF says ([{-mass.high:.3g}, "
                f"{-mass.low:.3g}]); there are {links}: was one of them not mounted, or lighter?"
            )
        elif mass is not None and mass.low > 0.0:
            said.append(
                f"what the last joint carries weighs {mass.value:.3g} kg more than the URDF says ([{mass.low:.3g}, "
                f"{mass.high:.3g}]): a payload, or a tool that the URDF has not"
            )
        return said


def contradicted(arm: Arm, log: JointLog, model: TorqueModel, suspicions: Sequence[Suspicion]) -> Identification:
    """The log contradicts the URDF."""
    residual, _ = model.residual(model.start())
    stages = {
        "logged": rms_of(_centred(model.logged(0.0), model.usable), model.usable),
        "URDF": rms_of(residual, model.usable),
    }
    none = np.zeros_like(model.usable)
    return Identification(arm, log, model, tuple(suspicions), {}, None, none, np.nan, (), residual, stages, None, None)


def identified(
    arm: Arm, log: JointLog, fit: Fit, held_out: BoolArray, condition: float, confusions: Sequence[Confusion]
) -> Identification:
    """Estimates were made."""
    model, residual = fit.model, fit.residual()
    stages = _stages(fit)
    of_white = _of_the_filter(model)
    whiteness = correlation_time(residual, fit.rows) / of_white
    return Identification(
        arm,
        log,
        model,
        (),
        estimates(fit),
        fit,
        held_out,
        condition,
        tuple(confusions),
        residual,
        stages,
        rms_of(residual, held_out),
        whiteness,
    )


def _centred(values: Array, rows: BoolArray) -> Array:
    return np.asarray(values - np.nanmean(np.where(rows, values, np.nan), axis=0))


def _stages(fit: Fit) -> dict[str, Array]:
    """RMS left by the URDF alone, with friction and offset of each joint, and with all."""
    model, rows = fit.model, fit.rows
    residual, jacobian = model.residual(model.start())
    friction = residual.copy()
    for j in range(model.arm.nv):
        places = [model.index(kind, j) for kind in ("coulomb", "viscous", "torque_offset")]
        columns = jacobian[:, j, places]
        step = np.linalg.lstsq(columns[rows[:, j]], -residual[rows[:, j], j], rcond=None)[0]
        friction[:, j] = residual[:, j] + columns @ step
    return {
        "logged": rms_of(_centred(model.logged(0.0), rows), rows),
        "URDF": rms_of(residual, rows),
        "+ friction, offset": rms_of(friction, rows),
        "+ all": fit.sigma,
    }


def _of_the_filter(model: TorqueModel) -> float:
    """Correlation time of white noise that went through the filter, in rows."""
    noise = np.random.default_rng(0).normal(size=(len(model.motion.time), 8))
    through = model.motion.fitted(noise)
    return float(np.median(correlation_time(through, np.ones(through.shape, dtype=np.bool_))))
