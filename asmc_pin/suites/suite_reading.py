"""A suite: its arms, tasks, laws and conditions, read from TOML, and parts of it.

A suite of one's own is a file with ``extends`` and ``laws``: other laws under the conditions of a shipped suite.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from asmc_pin.disk.reading import user_path
from asmc_pin.disk.resources import shipped
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.experiment.toml_text import read_toml
from asmc_pin.words.nearest_name import nearest

DEFAULT = "asmc-bench-1"
_OWN = ("extends", "laws")


@dataclass(frozen=True, eq=False)
class Suite:
    """Conditions, and the laws that meet them.

    Attributes:
        name: Of the suite, the version in it.
        tables: The file's, all of them; `arms`, `tasks` and `laws` say which are used.
        arms: Name -> table.
        tasks: Name -> table.
        laws: Name -> table of a controller.
        trials: Candidates of each law on each arm and task.
        held_out: Draws that the best are judged on.
        folders: Law -> where a law of one's own is looked for.
    """

    name: str
    tables: Mapping[str, Any]
    arms: Mapping[str, Mapping[str, Any]]
    tasks: Mapping[str, Mapping[str, Any]]
    laws: Mapping[str, Mapping[str, Any]]
    trials: int
    held_out: int
    folders: Mapping[str, Path]

    @property
    def sha256(self) -> str:
        """SHA-256 of all conditions, in hex: of the shipped file's content but for its laws."""
        conditions = {key: value for key, value in self.tables.items() if key != "laws"}
        return hashlib.sha256(json.dumps(conditions, sort_keys=True).encode()).hexdigest()

    @property
    def cells(self) -> list[tuple[str, str, str]]:
        """Every arm, task and law, arm by arm."""
        return [(arm, task, law) for arm in self.arms for task in self.tasks for law in self.laws]

    @property
    def whole(self) -> bool:
        """Whether it is run as its file says: all arms and tasks, its budget, and at least its laws."""
        tables = self.tables
        same = (self.trials, self.held_out) == (tables["trials"], tables["held_out"])
        every = all(set(getattr(self, part)) >= set(tables[part]) for part in ("arms", "tasks", "laws"))
        return same and every

    def scope(self) -> str:
        """What of the suite is run, in words."""
        found = [
            f"{len(getattr(self, part))} of {len(self.tables[part])} {part}"
            for part in ("arms", "tasks")
            if len(getattr(self, part)) < len(self.tables[part])
        ]
        missing = [law for law in self.tables["laws"] if law not in self.laws]
        found += [f"without the laws {', '.join(missing)}"] if missing else []
        for part, said in (("trials", "candidates a law"), ("held_out", "held-out draws")):
            own = getattr(self, part)
            found += [f"{own} {said} in the place of {self.tables[part]}"] if own != self.tables[part] else []
        return ", ".join(found)

    def part(
        self,
        *,
        quick: bool = False,
        arms: Iterable[str] | None = None,
        tasks: Iterable[str] | None = None,
        laws: Iterable[str] | None = None,
    ) -> Suite:
        """A part of the suite.

        Raises:
            ParameterError: it has no such arm, task or law.
        """
        changed: dict[str, Any] = {}
        if quick:
            table = self.tables["quick"]
            changed = {"trials": table["trials"], "held_out": table["held_out"]}
            arms, tasks = arms or table["arms"], tasks or table["tasks"]
        for name, wanted in (("arms", arms), ("tasks", tasks), ("laws", laws)):
            if wanted is None:
                continue
            known, asked = getattr(self, name), list(wanted)
            for item in asked:
                if item not in known:
                    raise ParameterError(name, f"{self.name} has no '{item}': {nearest(item, known)}")
            changed[name] = {item: table for item, table in known.items() if item in asked}
        return replace(self, **changed)


def load_suite(source: str | Path = DEFAULT) -> Suite:
    """Read a suite: a shipped one by its name, or a file that extends one by laws.

    Raises:
        ExperimentError: there is none, or its file is no suite.
    """
    names = suite_names()
    if isinstance(source, str) and source in names:
        return _shipped(source)
    path = user_path(source)
    if not path.is_file():
        raise ExperimentError("", f"there is no suite '{source}', neither a file nor a shipped one; {_known(names)}")
    data = read_toml(path)[1]
    unknown = [key for key in data if key not in _OWN]
    if unknown:
        raise ExperimentError(unknown[0], f"{path}: a suite of one's own has extends and laws; {_known(names)}")
    base, laws = data.get("extends"), data.get("laws", {})
    if base not in names:
        raise ExperimentError("extends", f"{path}: must name a shipped suite, got {base!r}; {_known(names)}")
    if not isinstance(laws, Mapping) or not all(isinstance(x, Mapping) and "law" in x for x in laws.values()):
        raise ExperimentError("laws", f'{path}: each is a table such as Mine = {{ law = "my_laws:Mine", gain = 2.0 }}')
    suite = _shipped(str(base))
    taken = [name for name in laws if name in suite.laws]
    if taken:
        raise ExperimentError(f"laws.{taken[0]}", f"{path}: {base} has a law of that name; give another")
    return replace(suite, laws={**suite.laws, **laws}, folders=dict.fromkeys(laws, path.resolve().parent))


def suite_names() -> list[str]:
    """Names of the suites that the package ships."""
    return sorted(path.stem for path in (shipped("experiments") / "suites").glob("*.toml"))


def _known(names: Iterable[str]) -> str:
    return f"shipped are {', '.join(names)}"


def _shipped(name: str) -> Suite:
    tables = read_toml(shipped("experiments") / "suites" / f"{name}.toml")[1]
    return Suite(
        name=name,
        tables=tables,
        arms=tables["arms"],
        tasks=tables["tasks"],
        laws=tables["laws"],
        trials=int(tables["trials"]),
        held_out=int(tables["held_out"]),
        folders={},
    )
