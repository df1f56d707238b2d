"""In whose words a message speaks of an option: those of the interface that the user has before them."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Literal, TypeAlias

Interface: TypeAlias = Literal["Python", "command line", "experiment"]

_SPOKEN: ContextVar[Interface] = ContextVar("interface", default="Python")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


@contextmanager
def speaking(interface: Interface) -> Iterator[None]:
    """In the block, messages name options as this interface does."""
    before = _SPOKEN.set(interface)
    try:
        yield
    finally:
        _SPOKEN.reset(before)


def flag_words(option: str) -> str:
    """How an option is switched on."""
    return {"Python": f"{option}=True", "command line": f"--{option}", "experiment": f"arm.{option} = true"}[
        _SPOKEN.get()
    ]


def option_words(option: str) -> str:
    """An option to which a value is given, as one speaks of it within a sentence."""
    return f"--{option}" if _SPOKEN.get() == "command line" else f"{option}=…"


def lock_words(locks: Mapping[str, float | str]) -> str:
    """How joints are locked, or freed by the word ``free``."""
    spoken = _SPOKEN.get()
    if spoken == "command line":
        said = (f"{name}={value if isinstance(value, str) else f'{value:g}'}" for name, value in locks.items())
        return " ".join(f"--lock {shlex.quote(item)}" for item in said)
    if spoken == "experiment":
        pairs = ", ".join(f"{_toml_key(name)} = {json.dumps(value)}" for name, value in locks.items())
        return f"arm.lock = {{ {pairs} }}"
    return f"lock={dict(locks)!r}"


def chain_words(base: str, tip: str) -> str:
    """How the joints between two links are asked for."""
    spoken = _SPOKEN.get()
    if spoken == "command line":
        return f"--chain {shlex.quote(f'{base}:{tip}')}"
    if spoken == "experiment":
        return f"arm.chain = [{json.dumps(base, ensure_ascii=False)}, {json.dumps(tip, ensure_ascii=False)}]"
    return f"chain={(base, tip)!r}"


def column_words(kind: str) -> str:
    """How a column of a log is named that has another name than is looked for."""
    if _SPOKEN.get() == "command line":
        return f"--columns {kind}=NAME"
    return f"columns={{'{kind}': 'NAME'}}"


def parameter_words(option: str) -> str:
    """An option's name, for the beginning of a message; a TOML key gets its table where it is known."""
    return f"--{option}" if _SPOKEN.get() == "command line" else option


def _toml_key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else json.dumps(name, ensure_ascii=False)
