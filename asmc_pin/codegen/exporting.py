"""A controller of an experiment as C99, checked tick by tick against Python."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.codegen.c_compiler import compile_c, find_compiler, run_vectors
from asmc_pin.codegen.code_provenance import provenance_lines
from asmc_pin.codegen.exported_code import ABI, CodeText, guard_arrays, ramp_ticks, translate
from asmc_pin.codegen.guarded_law import LIMITED, Guard, GuardedLaw
from asmc_pin.codegen.recorded_vectors import Vectors, number_of, record, record_motion
from asmc_pin.codegen.ros2_control import ros2_control_texts
from asmc_pin.codegen.translation.c_words import slug
from asmc_pin.controllers import TdeLaw
from asmc_pin.disk.files import whole_folder
from asmc_pin.engine import rollout
from asmc_pin.errors import ExperimentError, ParameterError, ResultError
from asmc_pin.experiment import Experiment
from asmc_pin.plant import Plant
from asmc_pin.words.choices import RealType, Target
from asmc_pin.words.shown import Shown

MOTION_TICKS = 600
"""Ticks of the experiment's own motion among the recorded vectors, at most."""


class NotTheSame(RuntimeError):
    """The exported code does not compute what Python computes: a fault of this package."""


@dataclass(frozen=True, repr=False)
class Exported(Shown):
    """What was exported.

    Attributes:
        files: All that was written.
        abi: Of the interface in C.
        law: Name of the law.
        exact: Whether C and Python agree to the last bit, in ``-ffp-contract=off``.
        ticks: Recorded ticks.
        checked_ticks: Of them, those that were compiled, run and compared; 0 without a compiler.
        largest_difference: Of a torque in them, N·m, C against Python in the same precision; None without compiler.
        from_double: Largest difference along the motion, in Python, between that precision and double, N·m.
        motion_ticks: Ticks of the motion among those recorded.
        limited_ticks: Of these, those at which a limit cut the law's torque.
        compiler: With which; None where there is none.
    """

    files: tuple[Path, ...]
    abi: int
    law: str
    exact: bool
    ticks: int
    checked_ticks: int
    largest_difference: float | None
    from_double: float
    motion_ticks: int
    limited_ticks: int
    compiler: str | None

    def to_json_dict(self) -> dict[str, Any]:
        """The keys of ``export --json``."""
        return {
            "files": [str(path) for path in self.files],
            "abi": self.abi,
            "law": self.law,
            "exact": self.exact,
            "ticks": self.ticks,
            "checked_ticks": self.checked_ticks,
            "largest_difference": self.largest_difference,
            "from_double": self.from_double,
            "motion_ticks": self.motion_ticks,
            "limited_ticks": self.limited_ticks,
            "compiler": self.compiler,
        }

    def lines(self) -> list[str]:
        """What was written, and how it was checked."""
        said = [f"wrote {path}" for path in self.files]
        if self.compiler is None:
            said.append("not compiled: there is no C compiler here (CC, gcc, clang or cc); run the runner yourself")
        else:
            how = "equal to the last bit" if self.exact else f"within {self.largest_difference:.3g} N·m"
            said.append(f"compiled with {self.compiler}: {self.checked_ticks} ticks, {how} of what Python computes")
        if self.from_double > 0.0:
            said.append(f"single precision is up to {self.from_double:.3g} N·m from double along the motion")
        if self.limited_ticks:
            said.append(
                f"limits cut the law's torque at {self.limited_ticks} of {self.motion_ticks} ticks of the motion; "
                "`compare` has the torque limit, but no limit on its rate"
            )
        return said


def export(
    experiment: Experiment,
    label: str,
    out: str | Path,
    *,
    target: Target = "c",
    real: RealType = "double",
    certificate: str | Path | None = None,
    torque_rate: ArrayLike | None = None,
    safe_torque: ArrayLike = 0.0,
    ramp: float = 0.5,
    fault_ticks: int = 5,
    force: bool = False,
) -> Exported:
    """Write a controller of an experiment as C99, with recorded vectors and a runner; compile and run them.

    Args:
        experiment: See `asmc_pin.load_experiment`.
        label: Which of its controllers.
        out: Folder; it appears whole or not at all.
        target: ``"c"``, or ``"ros2_control"`` for a controller plugin around the C as well.
        real: Type of every number in C.
        certificate: A file of ``--certificate`` about this arm and M̄, for the header; it is checked again.
        torque_rate: Torque-rate limit, a scalar or (nv,), N·m/s; inf for none. The experiment's
            ``metrics.torque_rate_limit`` when omitted.
        safe_torque: Where a fault leads to, a scalar or (nv,), N·m, within the torque limits.
        ramp: Time from a fault to there, above 0, s.
        fault_ticks: Ticks in a row that are not in order and make a fault, at least 1.
        force: Whether an export that is there already may be replaced.

    Raises:
        ExperimentError: no such controller, its law cannot be exported, or a joint has no torque limit.
        ParameterError: a value has a wrong size or sign, or the certificate is about something else.
        ResultError: something is there that may not be replaced.
        CompilerError: a compiler is there and does not work.
    """
    folder = Path(out)
    name = f"{slug(experiment.name)}_{slug(label)}"
    name = name if name[0].isalpha() else f"law_{name}"
    _check_target(folder, force)
    law, plant = _law_of(experiment, label), experiment.build_plant()
    arm = plant.arm
    guard = _guard(experiment, plant, torque_rate, safe_torque, ramp, fault_ticks, real)
    provenance = provenance_lines(experiment, label, arm, law, certificate)
    translated = translate(law, arm.nv, name, real)
    heading = f"{law.title or type(law).__name__}: controller {label} of experiment {experiment.name}"
    code = CodeText(translated, guard, arm.joint_names, heading, provenance)

    def guarded(number: Any) -> GuardedLaw:
        return GuardedLaw(law, guard, translated.first, translated.step.period_row, number)

    motion = _motion(experiment, plant, law)
    vectors = record(guarded(number_of(real)), motion, law.period, guard.fault_ticks + guard.longest_ramp, real)
    along = vectors.torques[1 : len(motion) + 1]
    from_double = 0.0
    if real == "float":
        doubles = record_motion(guarded(np.float64), motion, law.period, real).torques[1:]
        from_double = float(np.abs(along - doubles).max())
    texts = {
        f"{name}.h": code.header(),
        f"{name}.c": code.source(),
        f"{name}_runner.c": code.runner(),
        f"{name}_vectors.csv": vectors.csv(list(arm.joint_names)),
    }
    if target == "ros2_control":
        texts |= ros2_control_texts(code)
    with whole_folder(folder, lambda: _check_target(folder, force)) as made:
        for file, text in texts.items():
            (made / file).write_text(text, encoding="utf-8")
        compiler = find_compiler()
        checked, largest = (0, None) if compiler is None else _checked(compiler, made, name, vectors)
    return Exported(
        files=tuple(folder / file for file in texts),
        abi=ABI,
        law=str(experiment.controllers[label]["law"]),
        exact=translated.exact,
        ticks=len(vectors.rows),
        checked_ticks=checked,
        largest_difference=largest,
        from_double=from_double,
        motion_ticks=len(along),
        limited_ticks=int((vectors.came_to[1 : len(motion) + 1] == LIMITED).sum()),
        compiler=compiler,
    )


def _law_of(experiment: Experiment, label: str) -> TdeLaw:
    if label not in experiment.controllers:
        raise ExperimentError(
            "controllers",
            f"there is no '{label}' in {experiment.origin}; there are {', '.join(experiment.controllers)}",
        )
    law = experiment.build_controllers()[label]
    if not isinstance(law, TdeLaw) or law.trial_step is None:
        raise ExperimentError(
            f"controllers.{label}.law",
            f"'{experiment.controllers[label]['law']}' cannot be exported: it has no step for one trial that could be "
            "translated (docs/export.md); laws that know the model and laws in numpy have none",
        )
    return law


def _guard(
    experiment: Experiment,
    plant: Plant,
    rate: ArrayLike | None,
    safe: ArrayLike,
    ramp: float,
    fault_ticks: int,
    real: RealType,
) -> Guard:
    nv, period = plant.arm.nv, experiment.period
    limit = np.array(np.broadcast_to(np.atleast_2d(plant.effort_limit)[0], (nv,)), dtype=np.float64)
    unlimited = [name for name, value in zip(plant.arm.joint_names, limit, strict=True) if not math.isfinite(value)]
    if unlimited:
        raise ExperimentError(
            "plant.effort_limit",
            f"joint '{unlimited[0]}' has no torque limit, and nothing is exported without; give [plant] effort_limit",
        )
    rates = _per_joint("torque_rate", experiment.metrics.torque_rate_limit if rate is None else rate, nv)
    if not (rates > 0.0).all():
        raise ParameterError("torque_rate", f"{rates.tolist()} given; expected values above 0 N·m/s, or inf")
    safes = _per_joint("safe_torque", safe, nv)
    if not (np.abs(safes) <= limit).all():
        raise ParameterError(
            "safe_torque", f"{safes.tolist()} given; expected values within the torque limits {limit.tolist()} N·m"
        )
    if not (math.isfinite(ramp) and ramp > 0.0):
        raise ParameterError("ramp", f"{ramp!r} given; expected a time above 0 s")
    if isinstance(fault_ticks, bool) or int(fault_ticks) != fault_ticks or not 1 <= fault_ticks <= 10_000:
        raise ParameterError("fault_ticks", f"{fault_ticks!r} given; expected a whole number from 1 to 10000")
    limits, step = guard_arrays(limit, rates, period, real)
    ticks = ramp_ticks(ramp, period)
    if ticks > 100_000:
        raise ParameterError("ramp", f"{ramp:g} s are {ticks} periods; expected at most 100000")
    return Guard(period, limits, step, safes, int(fault_ticks), ticks)


def _per_joint(name: str, value: ArrayLike, nv: int) -> Array:
    try:
        return np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (nv,)))
    except ValueError:
        raise ParameterError(name, f"{value!r} given; expected one number, or {nv} of them") from None


def _motion(experiment: Experiment, plant: Plant, law: TdeLaw) -> Array:
    """Samples and set points of the experiment's own motion with this law, (ticks, 6, nv), until it diverged if so."""
    duration = min(experiment.duration, MOTION_TICKS * law.period)
    run = rollout(plant, law, experiment.build_reference(), duration, q0=experiment.plant.q0)
    told = (run.q_measured[0], run.v_measured[0], run.torque_measured[0], run.q_ref, run.v_ref, run.a_ref)
    motion = np.stack([np.asarray(x) for x in told], axis=1)
    return motion[: max(1, int(np.isfinite(motion).all(axis=(1, 2)).cumprod().sum()))]


def _checked(compiler: str, folder: Path, name: str, vectors: Vectors) -> tuple[int, float]:
    runner = folder / "runner"
    compile_c(compiler, [folder / f"{name}.c", folder / f"{name}_runner.c"], runner)
    found = run_vectors(runner.resolve(), folder / f"{name}_vectors.csv")
    runner.unlink()
    if found.wrong or found.ticks != len(vectors.rows):
        raise NotTheSame(
            f"{found.wrong} of {found.ticks} ticks of {name}.c, compiled with {compiler}, are not what Python "
            f"computes; the first is line {found.first_wrong_line} of its vectors, the largest difference "
            f"{found.largest_difference:.6g} N·m; nothing was written"
        )
    return found.ticks, found.largest_difference


def _check_target(folder: Path, force: bool) -> None:
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise ResultError(folder, f"{folder} is not a folder; give another one with --out")
    there: Sequence[Path] = sorted(folder.iterdir()) if folder.exists() else ()
    if not there:
        return
    ours = [path for path in there if path.name.endswith(("_vectors.csv", "_runner.c"))]
    if len(ours) < 2:
        raise ResultError(folder, f"{folder} holds files that are no export, and is left alone; give another --out")
    if not force:
        raise ResultError(
            folder, f"there is an export in {folder} already; --force replaces it, --out writes elsewhere"
        )
