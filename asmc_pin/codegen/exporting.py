"""A controller of an experiment as C99, checked tick by tick against Python."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.codegen.c_compiler import EXACT, STRICT, compile_c, find_compiler, run_vectors
from asmc_pin.codegen.code_provenance import provenance_lines
from asmc_pin.codegen.experiment_guard import experiment_guard
from asmc_pin.codegen.exported_code import ABI, CodeText, translate
from asmc_pin.codegen.guarded_law import LIMITED, GuardedLaw
from asmc_pin.codegen.recorded_vectors import Vectors, number_of, record, record_motion
from asmc_pin.codegen.ros2_control import ros2_control_texts
from asmc_pin.codegen.translation.c_words import slug
from asmc_pin.controllers import TdeLaw
from asmc_pin.disk.files import whole_folder
from asmc_pin.disk.reading import user_path
from asmc_pin.engine import Rollout, rollout
from asmc_pin.errors import ExperimentError, ResultError
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.named_robot import trip_words
from asmc_pin.metrics import first_trip
from asmc_pin.plant import Plant
from asmc_pin.words.choices import RealType, Target
from asmc_pin.words.given import check_experiment
from asmc_pin.words.interface import flag_words, option_words
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
        trip: What the motion would have stopped the named robot by, in words; None where nothing, or none is named.
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
    trip: str | None = None

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
            "trip": self.trip,
        }

    def check_yourself(self) -> str:
        """The command that runs the recorded ticks again, here or, with the files there, on the robot's computer."""
        source = next(path for path in self.files if path.name.endswith("_runner.c"))
        law = source.with_name(source.name.replace("_runner.c", ".c"))
        vectors = source.with_name(source.name.replace("_runner.c", "_vectors.csv"))
        compiling = ["cc", STRICT[0], *EXACT, str(law), str(source), "-o", source.stem, "-lm"]
        return f"{shlex.join(compiling)} && {shlex.join([f'./{source.stem}', str(vectors)])}"

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
        if self.trip is not None:
            said.append(
                f"warning: along the first {self.motion_ticks} ticks of the motion, as `compare` runs it, {self.trip}; "
                "the code keeps torque and torque rate within its limits, and does not watch speeds"
            )
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
            ``metrics.torque_rate_limit`` when omitted. Limits of torque and its rate are never above those of the robot
            that ``plant.limits`` names.
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
    check_experiment(experiment)
    folder = user_path(out)
    name = f"{slug(experiment.name)}_{slug(label)}"
    name = name if name[0].isalpha() else f"law_{name}"
    _check_target(folder, force)
    law, plant = _law_of(experiment, label), experiment.build_plant()
    arm = plant.arm
    guard = experiment_guard(experiment, plant, torque_rate, safe_torque, ramp, fault_ticks, real)
    provenance = provenance_lines(experiment, label, arm, law, certificate)
    translated = translate(law, arm.nv, name, real)
    heading = f"{law.title or type(law).__name__}: controller {label} of experiment {experiment.name}"
    code = CodeText(translated, guard, arm.joint_names, heading, provenance)

    def guarded(number: Any) -> GuardedLaw:
        return GuardedLaw(law, guard, translated.first, translated.step.period_row, number)

    run = _run(experiment, plant, law)
    motion = _motion(run)
    trip, robot = first_trip(run, experiment.metric_settings().trips), experiment.plant.limits
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
        trip=None if trip is None or robot is None else trip_words(robot, arm.joint_names, trip),
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


def _run(experiment: Experiment, plant: Plant, law: TdeLaw) -> Rollout:
    """The experiment's own motion with this law, its first ticks."""
    duration = min(experiment.duration, MOTION_TICKS * law.period)
    return rollout(plant, law, experiment.build_reference(), duration, q0=experiment.plant.q0)


def _motion(run: Rollout) -> Array:
    """Samples and set points of a run, (ticks, 6, nv), until it diverged if so."""
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
        raise ResultError(folder, f"{folder} is not a folder; give another one with {option_words('out')}")
    there: Sequence[Path] = sorted(folder.iterdir()) if folder.exists() else ()
    if not there:
        return
    ours = [path for path in there if path.name.endswith(("_vectors.csv", "_runner.c"))]
    if len(ours) < 2:
        raise ResultError(
            folder,
            f"{folder} holds files that are no export, and is left alone; give another one with {option_words('out')}",
        )
    if not force:
        raise ResultError(
            folder,
            f"there is an export in {folder} already; "
            f"{flag_words('force')} replaces it, {option_words('out')} writes elsewhere",
        )
