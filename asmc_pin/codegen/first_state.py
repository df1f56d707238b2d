"""What a law's `init` does with the sample of t = 0, found by having it compute with formulas in the place of numbers.

So that the start of a law, too, stands in one place: its `init` in Python.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.codegen.translation.c_words import NotInC, literal
from asmc_pin.controllers.one_trial.compiled_law import CompiledLaw
from asmc_pin.controllers.one_trial.state_rows import named_rows
from asmc_pin.controllers.protocol import Sample
from asmc_pin.words.choices import RealType

_SIGNS: dict[Any, str] = {np.add: "+", np.subtract: "-", np.multiply: "*", np.true_divide: "/"}


Value: TypeAlias = Callable[[Any, Any, Any], Any]


@dataclass(frozen=True)
class FirstRow:
    """A row of memory before the first tick.

    Attributes:
        name: The state's field.
        said: What the state says of it.
        formula: The number of joint i in C, from ``sample`` and ``parameters``.
        value: The same of q, v and τ, arrays (nv,) of any type of real numbers.
    """

    name: str
    said: str
    formula: str
    value: Value


class Formula(np.lib.mixins.NDArrayOperatorsMixin):
    """Stands for an array (1, nv) of which only the origin is known.

    Args:
        code: The number of joint i in C.
        value: The same in Python.
        nv: Number of joints.
        constant: An array of constants as such an object.
    """

    def __init__(self, code: str, value: Value, nv: int, constant: Callable[[Any], Formula]) -> None:
        self.code, self.value, self._nv, self._constant = code, value, nv, constant

    @property
    def shape(self) -> tuple[int, int]:
        """One trial."""
        return 1, self._nv

    def copy(self) -> Formula:
        """The same."""
        return self

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or options:
            return NotImplemented
        parts = [part if isinstance(part, Formula) else self._constant(part) for part in inputs]
        if ufunc is not np.negative and ufunc not in _SIGNS:
            return NotImplemented
        code = f" {_SIGNS.get(ufunc, '')} ".join(part.code for part in parts)

        def value(q: Any, v: Any, tau: Any) -> Any:
            return ufunc(*(part.value(q, v, tau) for part in parts))

        return Formula(f"-{code}" if len(parts) == 1 else f"({code})", value, self._nv, self._constant)

    def __array_function__(self, function: Any, _types: Any, arguments: Any, options: Any) -> Any:
        if function is np.zeros_like and not options:
            return np.zeros(self.shape)
        return NotImplemented


def first_state(
    law: CompiledLaw, nv: int, field_names: Mapping[int, str], fields: Sequence[Any], real: RealType
) -> list[FirstRow]:
    """The rows of a law's memory before its first tick.

    Args:
        law: The law.
        nv: Number of joints.
        field_names: The rows of its parameters in the exported structure, by number.
        fields: What the law gives as its rows: a constant that is one of them is read from the structure.
        real: What the exported code computes in.

    Raises:
        NotInC: its `init` does more with the sample than copy, add, multiply and divide.
    """

    def constant(value: Any) -> Formula:
        row = _row(value, nv)
        code = _constant_code(row, real)
        for number, own in enumerate(fields):
            if own is value and number in field_names:
                code = f"parameters->{field_names[number]}[i]"
        return Formula(code, lambda q, _v, _tau: row.astype(q.dtype), nv, constant)

    q = Formula("sample->q[i]", lambda q, _v, _tau: q, nv, constant)
    v = Formula("sample->v[i]", lambda _q, v, _tau: v, nv, constant)
    tau = Formula("sample->tau[i]", lambda _q, _v, tau: tau, nv, constant)
    try:
        state = law.init(Sample(q, v, tau))  # type: ignore[attr-defined,arg-type]
        rows = [
            (name, said, part if isinstance(part, Formula) else constant(part))
            for name, said, part in named_rows(state)
        ]
    except (TypeError, ValueError, AttributeError) as error:
        raise NotInC(
            f"init of {type(law).__name__} cannot be followed: {error}; a state is made of the sample's arrays, "
            "constants, and + − × ÷"
        ) from error
    return [FirstRow(name, said, part.code, part.value) for name, said, part in rows]


def _row(value: Any, nv: int) -> Array:
    array = np.asarray(value, dtype=np.float64)
    return np.array(np.broadcast_to(array[0] if array.ndim == 2 else array, (nv,)))


def _constant_code(row: Array, real: RealType) -> str:
    chosen = literal(float(row[-1]), real)
    if not (row == row[0]).all():
        # Joint by joint, so that the structure of parameters has nothing that only the start needs.
        for i in reversed(range(len(row) - 1)):
            chosen = f"(i == {i} ? {literal(float(row[i]), real)} : {chosen})"
    return chosen
