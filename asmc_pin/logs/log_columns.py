"""Which columns of a table are the joints' angles, velocities and torques."""

from __future__ import annotations

from collections.abc import Sequence

from asmc_pin.disk.reading import Fail
from asmc_pin.logs.log_options import LogOptions
from asmc_pin.words.interface import column_words
from asmc_pin.words.text import printable

_WORDS = {
    "q": ("q", "pos", "position", "angle", "joint_position"),
    "v": ("v", "dq", "qd", "qdot", "vel", "velocity", "joint_velocity"),
    "tau": ("tau", "torque", "effort", "eff", "current", "joint_torque"),
}
_JOINED = ("{w}{n}", "{w}_{n}", "{w}[{i}]", "{w}.{i}", "{w}_{joint}", "{joint}_{w}", "{w}/{joint}", "{joint}/{w}")
_CLOCKS = ("t", "time", "timestamp", "stamp", "sec", "seconds", "__time")


def clock_column(columns: Sequence[str], options: LogOptions, name: str, fail: Fail) -> str:
    """The column of time stamps.

    Raises:
        AsmcPinError: What `fail` makes: there is none.
    """
    asked = options.columns.get("t")
    if asked is not None:
        if asked not in columns:
            raise fail(f"{name} has no column '{printable(asked)}' for the time; {_given(columns)}")
        return asked
    found = next((known for known in _CLOCKS if known in columns), None)
    if found is None:
        raise fail(
            f"{name} has no column 't' or 'time'; name the one with the time stamps: "
            f"{column_words('t')}; {_given(columns)}"
        )
    return found


def joint_columns(
    columns: Sequence[str], kind: str, joints: Sequence[str], options: LogOptions, name: str, fail: Fail
) -> list[str] | None:
    """The columns of one quantity in the order of the joints.

    Args:
        columns: Of the table.
        kind: ``"q"``, ``"v"`` or ``"tau"``.
        joints: Names of the joints, base first.
        options: May name them.
        name: Of the file.
        fail: Makes the error.

    Returns:
        None where the table has none of them.

    Raises:
        AsmcPinError: What `fail` makes: some are missing, or one is there by two names.
    """
    asked = options.columns.get(kind)
    if asked == "-":
        return None
    if asked is not None:
        wanted = [_filled(asked, i, joint) for i, joint in enumerate(joints)]
        if len(set(wanted)) < len(wanted):
            raise fail(
                f"columns: '{printable(asked)}' is the same for all joints; write {{n}}, {{i}} or {{joint}} in it"
            )
        missing = [column for column in wanted if column not in columns]
        if missing:
            raise fail(f"{name} has no column '{printable(missing[0])}'; {_given(columns)}")
        return wanted
    found: list[str | None] = []
    for i, joint in enumerate(joints):
        known = dict.fromkeys(_filled(form.replace("{w}", word), i, joint) for word in _WORDS[kind] for form in _JOINED)
        there = [column for column in known if column in columns]
        if len(there) > 1:
            raise fail(
                f"{name} has both '{printable(there[0])}' and '{printable(there[1])}'; keep one, or name the columns"
            )
        found.append(there[0] if there else None)
    if all(column is None for column in found):
        return None
    if None in found:
        i = found.index(None)
        raise fail(
            f"{name} has no column '{kind}{i + 1}' or '{kind}_{joints[i]}'; where they have other names: "
            f"{column_words(kind)}; {_given(columns)}"
        )
    return [str(column) for column in found]


def form_by_name(columns: Sequence[str], kind: str, joints: Sequence[str]) -> str | None:
    """The pattern by which a table names the columns of these joints, the bare name first; None where it has no such.

    Args:
        columns: Of the table.
        kind: ``"q"``, ``"v"`` or ``"tau"``.
        joints: Names of the joints.
    """
    by_name = [form.replace("{w}", word) for word in _WORDS[kind] for form in _JOINED if "{joint}" in form]
    fits = (form for form in ("{joint}", *by_name) if all(_filled(form, 0, joint) in columns for joint in joints))
    return next(fits, None)


def _filled(pattern: str, index: int, joint: str) -> str:
    return pattern.replace("{n}", str(index + 1)).replace("{i}", str(index)).replace("{joint}", joint)


def _given(columns: Sequence[str]) -> str:
    return f"its columns: {printable(', '.join(columns))}"
