"""The translator keeps the order of operations, knows a new law in that form, and refuses what it does not know."""

from __future__ import annotations

import re

import numba
import numpy as np
import pytest
from export_cases import built, experiment_of, ran
from paths import TESTS

import asmc_pin
from asmc_pin.codegen.translation.c_words import NotInC, comment, identifier, literal
from asmc_pin.codegen.translation.step_translation import StepTranslation
from asmc_pin.controllers.one_trial.compiled_tde import OWN, S, pole_placement, with_sign
from asmc_pin.numerics.short_loops import ALLOCATING, OPTIONS, short_loops

ROW, OTHER = 0, 1


def translated(step) -> str:
    made = StepTranslation("x", "double", 3)
    made.entry(step)
    return "\n".join(function.text for function in made.functions)


def order(tick, law, memory, work, command):
    for i in range(command.size):
        a, b, c = law[ROW, i], law[OTHER, i], tick.q[i]
        command[i] = a - (b - c) + a * (b * c) - (a + b) * c / (a / b) - -a


def test_parentheses_stay_where_rounding_or_meaning_depends_on_them():
    text = translated(order)
    assert "command[i] = a - (b - c) + a * (b * c) - (a + b) * c / (a / b) - -a;" in text


def swaps(tick, law, memory, work, command):
    for i in range(command.size):
        a, b = law[ROW, i], law[OTHER, i]
        a, b = b, a
        command[i] = a - b


def test_a_tuple_is_read_before_it_is_stored():
    text = translated(swaps)
    assert re.search(r"next_1 = b;\s+const x_real next_2 = a;\s+a = next_1;\s+b = next_2;", text)


def later(tick, law, memory, work, command):
    for i in range(command.size):
        if law[ROW, i] > 0.0:
            w = tick.q[i] + 1.0
            w = w * w
        else:
            w = 2
        command[i] = w if not tick.ticks > 0 else 0


def test_a_variable_of_two_branches_lives_in_the_block_around_them():
    text = translated(later)
    assert re.search(r"\{\s+x_real w = \(x_real\)0;\s+if", text)
    assert "!(tick->ticks > 0U) ? w : 0.0" in text


@short_loops
def recursive(x: float) -> float:
    return recursive(x)


def refused_step(body: str):
    """A step with this body, in a file of its own, as a law's."""
    return f"def step(tick, law, memory, work, command):\n    for i in range(command.size):\n        {body}\n"


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("command[i] = np.sin(tick.q[i])", "np.sin"),
        ("command[i] = np.fmin(tick.q[i], 1.0)", "np.fmin"),
        ("command[i] = max(tick.q[i], 1.0)", "max"),
        ("command[i] = tick.q[i] ** 2", "as a product"),
        ("command[i] = tick.q[i] % 2.0", "operator"),
        ("command[i] = tick.q[i] // 2.0", "operator"),
        ("command[i] = tick.q[0]; tick.q[i] = 1.0", None),
        ("command[i] = law[i, i]", "constant"),
        ("command[i] = law[ROW, 1]", "variable of a loop"),
        ("command[i] = tick.q[i] if tick.q[i] else 0.0", "truth"),
        ("command[i] = 0.0 < tick.q[i] < 1.0", "two numbers at a time"),
        ("command[i] = unknown", "no value here"),
        ("command[i] = tick.gain[i]", "tick.gain"),
        ("command[i] = recursive(tick.q[i])", "calls itself"),
        ("law[ROW, i] = 1.0", "not to be written to"),
        ("while True: pass", "While"),
        ("command[i] = [1.0][0]", "no counterpart"),
        ("command[i] = (lambda x: x)(1.0)", "no counterpart"),
        ("command[i] = tick.ticks * 1.0", "count"),
        ("x = 1.0; x = True; command[i] = x", "one kind of value first"),
        ("command[i] = 1.0 if True else 1e400", "not finite"),
        ("import math", "Import"),
        ("command[i] = float('inf')", "no number"),
        ("command[i] = abs(*tick.q)", "one by one"),
        ("wörk = 1.0; command[i] = wörk", "C99 does not know"),
    ],
)
def test_what_has_no_counterpart_is_refused_with_its_place(body, says, tmp_path):
    file = tmp_path / "a_law.py"
    file.write_text(refused_step(body), encoding="utf-8")
    names = {"np": np, "ROW": ROW, "recursive": recursive}
    exec(compile(file.read_text(encoding="utf-8"), str(file), "exec"), names)
    with pytest.raises(NotInC, match=says or "not to be written to") as error:
        translated(names["step"])
    assert "a_law.py, line 3" in str(error.value) or "test_translation.py" in str(error.value)


def test_a_loop_variable_means_nothing_after_the_loop(tmp_path):
    def step(tick, law, memory, work, command):
        for i in range(command.size):
            command[i] = 0.0
        command[i] = 1.0

    with pytest.raises(NotInC, match="after the loop"):
        translated(step)


@pytest.mark.parametrize("value", [0.1, 1.0, -0.0, 1e-300, 5e-324, 1.7976931348623157e308, 2.0**60, 3.0])
def test_a_number_is_read_back_as_itself(value):
    assert float(literal(value, "double")) == value
    single = np.float32(value) if abs(value) < 3e38 else np.float32(1.0)
    assert np.float32(literal(float(single), "float").rstrip("f")) == single


def test_words_of_c_and_comments_are_made_harmless():
    assert identifier("register") == "register_"
    assert identifier("class") == "class_"
    assert "*/" not in comment("a */ b")
    assert "\\" not in comment("a\\\nb")
    with pytest.raises(NotInC, match="letters"):
        identifier("β")


DOCS = (TESTS.parent / "docs" / "controllers.md").read_text(encoding="utf-8")


def test_the_compiled_law_of_the_docs_is_exported_as_it_stands(tmp_path):
    """A law that nobody wrote C for: from its Python to code that agrees to the last bit."""
    shown = DOCS.split("It then\ndefines `trial_step` in place of `step`:\n")[1].split("\n- `tick` has")[0]
    lines = "\n".join(line.removeprefix("    ") for line in shown.split("\n"))
    assert "class Switched" in lines
    head = (
        "from dataclasses import dataclass\nfrom asmc_pin.controllers import PerJoint, TdeLaw\n"
        "from asmc_pin.controllers.one_trial.trial_step import trial_step\n"
    )
    (tmp_path / "switched_law.py").write_text(head + lines, encoding="utf-8")
    data = dict(experiment_of({"law": "ppc"})._data)
    data["controllers"] = {"It": {"law": "switched_law:Switched", "gain": [2.0, 1.0]}}
    experiment = asmc_pin.Experiment.from_dict(data, folder=tmp_path)
    done = asmc_pin.export(experiment, "It", tmp_path / "x", ramp=0.02)
    assert done.exact
    assert "wrong 0" in ran(built(tmp_path / "x", "c"), tmp_path / "x")


def test_numba_rounds_a_product_before_it_is_added():
    """Bits could not be equal if it fused the two: 1 − 2⁻⁶⁰ rounds to 1."""
    compiled = numba.njit(**{**OPTIONS, "cache": False})(lambda a, b, c: a * b + c)
    assert compiled(1.0 + 2.0**-30, 1.0 - 2.0**-30, -1.0) == 0.0
    assert not any(options.get("fastmath") for options in (OPTIONS, ALLOCATING))


def test_rows_have_the_names_of_the_constants_that_the_step_reads_them_by():
    def step(tick, law, memory, work, command):
        pole_placement(tick, law, memory, work, command)
        for i in range(command.size):
            command[i] += with_sign(law[OWN, i], work[S, i])

    made = StepTranslation("x", "double", 3)
    made.entry(step)
    assert made.rows["law"][0] == "mbar"
    assert made.rows["law"][OWN] == "own"
    assert 3 not in made.rows["law"]  # the period: the time since the last tick stands for it
