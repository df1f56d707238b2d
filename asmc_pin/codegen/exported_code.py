"""What is exported, as text: the law in C with its guard, from a translated step and the numbers of an experiment."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.codegen.first_state import FirstRow, first_state
from asmc_pin.codegen.guarded_law import Guard
from asmc_pin.codegen.translation.c_words import LARGEST, comment, literal
from asmc_pin.codegen.translation.step_translation import NotInC, StepTranslation
from asmc_pin.controllers import TdeLaw
from asmc_pin.controllers.one_trial.compiled_law import CompiledLaw
from asmc_pin.controllers.one_trial.compiled_tde import PERIOD
from asmc_pin.controllers.one_trial.state_rows import named_rows
from asmc_pin.controllers.protocol import Sample
from asmc_pin.words.choices import RealType

ABI = 1
"""Of the exported interface; it rises when the structures or what they mean change."""

_TEXTS = Path(__file__).parent / "c_text"

_HELPERS = {
    "absolute": """static {r} {p}_absolute({r} x)
{{
    return x > {zero} ? x : {zero} - x;
}}
""",
    "smaller": """/* NaN if one of them is. */
static {r} {p}_smaller({r} x, {r} y)
{{
    return x <= y || x != x ? x : y;
}}
""",
    "larger": """/* NaN if one of them is. */
static {r} {p}_larger({r} x, {r} y)
{{
    return x >= y || x != x ? x : y;
}}
""",
    "with_sign_of": """static {r} {p}_with_sign_of({r} size, {r} of)
{{
    return ({r})copysign{f}(size, of);
}}
""",
    "root": """static {r} {p}_root({r} x)
{{
    return ({r})sqrt{f}(x);
}}
""",
    "power": """static {r} {p}_power({r} x, {r} exponent)
{{
    return ({r})pow{f}(x, exponent);
}}
""",
}
_FROM_LIBM = ("with_sign_of", "root", "power")
ROUNDED_IN_SEVERAL_WAYS = ("power",)
"""Helpers of libm whose last digits are the library's own; copysign and the square root are exact by IEEE 754."""


@dataclass(frozen=True)
class TranslatedLaw:
    """A law in C, before it has a guard.

    Attributes:
        law: In Python.
        prefix: With which every name in C begins.
        real: What it computes in.
        step: Its step and all that it calls.
        entry: Name of the step in C.
        first: Its memory before the first tick.
        nv: Number of joints.
    """

    law: CompiledLaw
    prefix: str
    real: RealType
    step: StepTranslation
    entry: str
    first: Sequence[FirstRow]
    nv: int

    @property
    def exact(self) -> bool:
        """Whether every operation is rounded in one way only, so that C and Python agree to the last bit."""
        return not set(ROUNDED_IN_SEVERAL_WAYS) & self.step.helpers

    @property
    def libraries(self) -> str:
        """What the linker has to be told, with a blank before it."""
        return " -lm" if set(_FROM_LIBM) & self.step.helpers else ""


def translate(law: CompiledLaw, nv: int, prefix: str, real: RealType) -> TranslatedLaw:
    """A law's step and start in C.

    Raises:
        NotInC: the law has its step in numpy, or does in it what has no counterpart here.
    """
    if law.trial_step is None:
        raise NotInC(
            f"{type(law).__name__} has its step in numpy; only a step for one trial (docs/controllers.md, 'Compiled') "
            "can be translated to C"
        )
    period_row = PERIOD if isinstance(law, TdeLaw) else None
    step = StepTranslation(prefix, real, period_row)
    zero = np.zeros((1, nv))
    step.name_memory([name for name, _, _ in named_rows(law.init(Sample(zero, zero.copy(), zero.copy())))])  # type: ignore[attr-defined]
    entry = step.entry(law.trial_step.function).c_name
    return TranslatedLaw(law, prefix, real, step, entry, first_state(law, nv, step.rows["law"], law.rows(), real), nv)


@dataclass(frozen=True)
class CodeText:
    """The files of a law.

    Attributes:
        translated: The law.
        guard: What stands around it.
        joints: Names of the joints.
        heading: What it is, one line.
        provenance: Where it comes from, and what holds for it.
    """

    translated: TranslatedLaw
    guard: Guard
    joints: Sequence[str]
    heading: str
    provenance: Sequence[str] = field(default_factory=tuple)

    @property
    def name(self) -> str:
        """Of the files, and the prefix of all names."""
        return self.translated.prefix

    def header(self) -> str:
        """The ``.h``."""
        law, step, guard = self.translated, self.translated.step, self.guard
        said = row_meanings(law.law)
        rows = sorted(step.rows["law"].items())
        return self._filled(
            "law.h.in",
            title=_remark([self.heading]),
            provenance=_remark(self.provenance),
            joints=comment(", ".join(self.joints)),
            ramp=f"{guard.ramp_ticks * guard.period:g}",
            longest_ramp=f"{guard.longest_ramp * guard.period:g}",
            abi=ABI,
            fault_ticks=f"{guard.fault_ticks}U",
            ramp_ticks=f"{guard.ramp_ticks}U",
            parameter_fields=self._fields(
                (name, said.get(name.rstrip("_"), "as the law's step reads it")) for _, name in rows
            ),
            memory_fields=self._fields(
                (step.rows["memory"][number], row.said.rstrip(".")) for number, row in enumerate(law.first)
            ),
        )

    def source(self) -> str:
        """The ``.c``."""
        law, step = self.translated, self.translated.step
        values = law.law.law_rows(law.nv)[0]
        rows = [values[number] for number, _ in sorted(step.rows["law"].items())]
        rows += [self.guard.torque_limit, self.guard.torque_step, self.guard.safe_torque]
        zero = self._literal(0.0)
        memory = [step.rows["memory"][number] for number in range(len(law.first))]
        first = (
            f"        state->memory.{name}[i] = "
            + (f"finite ? {row.formula} : {zero};" if row.formula != zero else f"{zero};")
            for name, row in zip(memory, law.first, strict=True)
        )
        kind = {
            "r": f"{self.name}_real",
            "p": self.name,
            "f": "f" if law.real == "float" else "",
            "zero": self._literal(0.0),
        }
        work = [(name, "") for _, name in sorted(step.rows["work"].items())]
        return self._filled(
            "law.c.in",
            heading=comment(self.heading),
            entry=law.entry,
            includes="#include <math.h>\n\n" if law.libraries else "",
            work_fields=self._fields(work) if work else "    char nothing;",
            helpers="\n".join(text.format(**kind) for name, text in _HELPERS.items() if name in step.helpers),
            functions="\n\n".join(function.text for function in step.functions),
            parameter_values=",\n".join(f"        {{{', '.join(map(self._literal, row))}}}" for row in rows),
            first_values="\n".join(first),
            memory_finite="".join(
                f"\n                && {self.name}_all_finite(memory.{name}, {self.name.upper()}_NV)" for name in memory
            ),
            shortest=self._literal(0.5 * self.guard.period),
            longest=self._literal(1.5 * self.guard.period),
        )

    def runner(self) -> str:
        """The runner of the recorded vectors."""
        bounds = self.bounds()
        return self._filled(
            "runner.c.in",
            libraries=self.translated.libraries,
            bounds=", ".join(f"{bound!r}" for bound in bounds),
            line_length=64 + 32 * (3 + 7 * self.translated.nv),
            # Whether a torque just touches its limit is a matter of the last digit.
            status_slack="" if self.translated.exact else " || (status <= 1 && cell[2] <= 1.0)",
        )

    def bounds(self) -> list[float]:
        """Largest difference from the recorded vectors that counts as equal, N·m per joint; 0: none."""
        share = 0.0 if self.translated.exact else {"double": 1e-10, "float": 1e-3}[self.translated.real]
        return [share * float(limit) for limit in self.guard.torque_limit]

    def _filled(self, text: str, **words: Any) -> str:
        shared = {
            "name": self.name,
            "prefix": self.name,
            "PREFIX": self.name.upper(),
            "nv": self.translated.nv,
            "real": self.translated.real,
            "period": self._literal(self.guard.period),
            "zero": self._literal(0.0),
        }
        return Template((_TEXTS / text).read_text(encoding="utf-8")).substitute(shared | words)

    def _fields(self, fields: Any) -> str:
        kind, size = f"{self.name}_real", f"{self.name.upper()}_NV"
        return "\n".join(
            f"    {kind} {name}[{size}];" + (f" /* {comment(said)} */" if said else "") for name, said in fields
        )

    def _literal(self, value: float) -> str:
        return literal(float(value), self.translated.real)


def row_meanings(law: CompiledLaw) -> Mapping[str, str]:
    """What each row of a law's parameters is, with its unit: what its class and those before it say."""
    said: dict[str, str] = {}
    for each in reversed(type(law).__mro__):
        said |= vars(each).get("row_meanings", {})
    return said


def no_limit(real: RealType) -> float:
    """What stands for no limit on the change of torque: a step that no change reaches."""
    return LARGEST[real] / 4.0


def guard_arrays(limit: Array, rate: Array, period: float, real: RealType) -> tuple[Array, Array]:
    """Torque limits and the largest step of a tick, with what is infinite made finite."""
    step = np.where(np.isfinite(rate), rate * period, no_limit(real))
    return np.minimum(limit, no_limit(real)), np.minimum(step, no_limit(real))


def _remark(lines: Sequence[str]) -> str:
    text = [part for line in lines for part in comment(line).split("\n")]
    return "\n".join(f" * {line}".rstrip() for line in text)


def ramp_ticks(seconds: float, period: float) -> int:
    """Periods in a ramp of so many seconds, at least 1."""
    return max(1, math.ceil(seconds / period - 1e-9))
