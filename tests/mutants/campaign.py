"""Hundreds of mutants against the quick tests, and a report of those that no test noticed."""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
import pickle
import re
import subprocess
import sys
import tomllib
from collections import Counter
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import Phase, settings

from mutants.draw import Mutant, by_hand, draw
from mutants.judge import LONGEST, Covered, Judge, Verdict, file_of, judging
from mutants.operators import check_examples

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).parent
SCRATCH = ROOT / "results" / "mutants"
"""Where what tests call is kept between runs, and the verdicts of the last."""


def modules_of(parts: dict[str, list[str]]) -> dict[str, str]:
    """Each module's part, by the module's path."""
    return {
        path.relative_to(ROOT).as_posix(): part
        for part, patterns in parts.items()
        for pattern in patterns
        for path in sorted(ROOT.glob(pattern))
    }


def _digest(paths: list[Path]) -> str:
    together = hashlib.sha256()
    for path in sorted(paths):
        together.update(path.relative_to(ROOT).as_posix().encode() + path.read_bytes())
    return together.hexdigest()[:16]


def drawn(modules: dict[str, str], count: int, seed: int) -> tuple[list[Mutant], int]:
    """The mutants of a seed; kept, as to make them takes a minute."""
    key = _digest([*(ROOT / module for module in modules), HERE / "draw.py", HERE / "operators.py"])
    kept = SCRATCH / f"drawn-{key}-{count}-{seed}.pickle"
    if not kept.exists():
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_bytes(pickle.dumps(draw(ROOT, list(modules), count, seed)))
    mutants, possible = pickle.loads(kept.read_bytes())
    return mutants, possible


def covered(judge: Judge, names: list[str], modules: list[str], workers: int) -> Covered:
    """What tests call; measured anew for those whose file changed, or that call a module that did."""
    compilation = "off" if os.environ.get("NUMBA_DISABLE_JIT") == "1" else "on"
    shared = f"{compilation}-{LONGEST:g}s-{_digest([*ROOT.glob('tests/support/*.py'), HERE / 'plain_steps.py'])}"
    found: Covered = {}
    for file in dict.fromkeys(map(file_of, names)):
        kept = SCRATCH / f"calls-{shared}-{_digest([ROOT / file])}.json"
        known = json.loads(kept.read_text()) if kept.exists() else {}
        asked = [name for name in names if file_of(name) == file]
        missing = [name for name in asked if name not in known or not _still_true(known[name])]
        if missing:
            made = judge.cover(missing, modules, workers)
            for name in missing:
                seconds, calls = made.get(name, (-1.0, frozenset()))  # −1: it does not judge
                called = [ROOT / module for module in {each.split(":")[0] for each in calls}]
                known[name] = [seconds, sorted(calls), _digest(called)]
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_text(json.dumps(known))
            print(f" {file}: {len(made)} of {len(missing)} tests judge", flush=True)
        found |= {name: (known[name][0], frozenset(known[name][1])) for name in asked if known[name][0] >= 0.0}
    return found


def _still_true(known: list[Any]) -> bool:
    """Whether the modules that a test called are as they were."""
    modules = [ROOT / module for module in {each.split(":")[0] for each in known[1]}]
    return all(module.exists() for module in modules) and _digest(modules) == known[2]


def equivalents() -> dict[tuple[str, str, str], str]:
    """The reasons of `equivalents.toml` by module, line and what it becomes."""
    listed = tomllib.loads((HERE / "equivalents.toml").read_text(encoding="utf-8")).get("equivalent", [])
    return {(each["module"], each["was"], each["becomes"]): each["reason"] for each in listed}


def report(verdicts: dict[Mutant, Verdict], parts: dict[str, str], possible: int) -> bool:
    """Print the counts of each part and the survivors that are not listed; whether there are none."""
    known = equivalents()
    counts: dict[str, Counter[str]] = {}
    left = []
    for mutant, verdict in verdicts.items():
        what = verdict.what
        if what in ("survived", "not called"):
            what = "equivalent" if mutant.name in known else what
            if what != "equivalent":
                left.append((mutant, verdict))
        counts.setdefault(parts[mutant.module], Counter())[what] += 1
    kinds = ("killed", "endless", "equivalent", "survived", "not called")
    print(f"\n{'part':12}{'drawn':>8}" + "".join(f"{kind:>12}" for kind in kinds))
    for part, row in [*counts.items(), ("all", sum(counts.values(), Counter()))]:
        print(f"{part:12}{row.total():8}" + "".join(f"{row[kind]:12}" for kind in kinds))
    print(f"({possible} faults to draw from; an endless mutant is noticed by the clock)")
    for mutant, verdict in left:
        tests = f"{verdict.tests} tests pass" if verdict.tests else "no test calls it"
        print(f"\n{mutant.module}:{mutant.line} in {mutant.function or 'the module'} ({mutant.operator}); {tests}")
        print(f"  - {mutant.was}\n  + {mutant.becomes}")
    print(f"\n{len(left)} survivors that are not named equivalent")
    return not left


def _survived(verdict: Verdict) -> bool:
    return verdict.what in ("survived", "not called")


_COMPILERS = re.compile(r"((numba\.)?njit\b|(compiled|short_loops|inlined|with_room|trial_step)$)")


def _compiled_functions(source: str) -> set[str]:
    """The functions of a module that are compiled, where they stand or when they are first asked for."""
    decorated = {
        each.name
        for each in ast.parse(source).body
        if isinstance(each, ast.FunctionDef) and any(_COMPILERS.match(ast.unparse(d)) for d in each.decorator_list)
    }
    return decorated | set(re.findall(r"njit\(.*\)\((\w+)\)", source))


@cache
def _seen_by_compiled_code() -> frozenset[str]:
    """The modules with compiled functions, and those from which they import, by their paths."""
    seen = set()
    for path in ROOT.glob("asmc_pin/**/*.py"):
        source = path.read_text(encoding="utf-8")
        if _compiled_functions(source):
            named = re.findall(r"^from (asmc_pin[.\w]*) import", source, re.MULTILINE)
            seen |= {path.relative_to(ROOT).as_posix(), *(f"{name.replace('.', '/')}.py" for name in named)}
    return frozenset(seen)


def compiled(mutant: Mutant) -> bool:
    """Whether a mutant is judged with compilation off.

    So is a compiled function, and what is not the code of a function in a module of which compiled code may have seen
    the constants, which it keeps. All else is judged with compilation on, where whole runs of the plant are quick.
    """
    if mutant.function is None:
        return mutant.module in _seen_by_compiled_code()
    return mutant.function in _compiled_functions(mutant.source)


def _file(seed: int, compilation: str) -> Path:
    return SCRATCH / f"verdicts-{seed}-{compilation}.json"


def _held(seed: int, *compilations: str) -> dict[tuple[str, ...], Verdict]:
    """The verdicts so far of a seed."""
    files = [file for each in compilations if (file := _file(seed, each)).exists()]
    return {tuple(name): Verdict(*each) for file in files for name, each in json.loads(file.read_text())}


def _killers() -> dict[tuple[str, ...], str]:
    """The test that noticed each mutant when it was last judged; it goes first the next time."""
    kept = SCRATCH / "killers.json"
    return {tuple(name): test for name, test in json.loads(kept.read_text())} if kept.exists() else {}


@dataclass
class _Round:
    """What is tried in one process, with compilation on or off."""

    mutants: list[Mutant]
    parts: dict[str, str]
    judges: dict[str, list[str]]
    asked: Any
    killers: dict[tuple[str, ...], str] = field(default_factory=_killers)
    calls: Covered = field(default_factory=dict)

    def work(self, judge: Judge) -> None:
        """Show each mutant the test that killed it before, then its part's, one file after the other."""
        judge.warm(self.judges["warm"])
        trying = {m.name for m in self.mutants}
        self._keep({name: verdict for name, verdict in self._held().items() if name not in trying})
        known = {m: [test] for m in self.mutants if (test := self.killers.get(m.name)) in judge.items}
        self._cover(judge, [name for names in known.values() for name in names])
        left = self._try(judge, {m: [n for n in names if n in self.calls] for m, names in known.items()}, "")
        left += [m for m in self.mutants if m not in known]
        outside = [m for m in left if m.function is None]
        inside = [m for m in left if m.function is not None]
        uncalled = set(inside)
        for file in dict.fromkeys(map(file_of, judge.items)):
            names = {part: [n for n in self._judges(judge, part) if file_of(n) == file] for part in self.judges}
            near = [m for m in inside if names[self.parts[m.module]]]
            if near:
                self._cover(judge, [name for m in near for name in names[self.parts[m.module]]])
                shown = {m: judging(m, self.calls, names[self.parts[m.module]]) for m in near}
                uncalled -= {m for m in shown if shown[m]}
                left = self._try(judge, shown, file)
                inside = [m for m in inside if m not in near or m in left]
        # What no test calls may be called while its module is imported. A new process for each of these costs some
        # seconds: one for all tests of their part.
        outside += [replace(m, function=None) for m in inside if m in uncalled]
        near_by = {m: self._judges(judge, self.parts[m.module]) for m in outside}
        self._cover(judge, [name for names in near_by.values() for name in names])
        self._try(judge, {m: judging(m, self.calls, names) for m, names in near_by.items()}, "all tests of their part")

    def _judges(self, judge: Judge, part: str) -> list[str]:
        """The tests that judge a part."""
        asked = self.asked.judge or self.judges[part]
        return [name for name in judge.items if any(name.startswith(each) for each in asked)]

    def _cover(self, judge: Judge, names: list[str]) -> None:
        self.calls |= covered(judge, [*dict.fromkeys(names)], list(self.parts), self.asked.workers)

    def _try(self, judge: Judge, shown: dict[Mutant, list[str]], by: str) -> list[Mutant]:
        """Judge mutants, keep what comes of each, and give back those that no test noticed so far."""
        left = []
        for mutant, verdict in judge.verdicts(shown, self.calls, self.asked.workers):
            held = self._held()
            before = held.get(mutant.name, Verdict("not called"))
            if _survived(verdict):
                left.append(mutant)
                shown_all = before.tests + verdict.tests if by else 0
                verdict = Verdict("survived" if shown_all else "not called", "", shown_all)
            else:
                self.killers[mutant.name] = verdict.by
                (SCRATCH / "killers.json").write_text(json.dumps([*self.killers.items()]))
            self._keep(held | {mutant.name: verdict})
        print(f"{by or 'what killed before'}: {len(shown) - len(left)} of {len(shown)} noticed", flush=True)
        return left

    def _held(self) -> dict[tuple[str, ...], Verdict]:
        return _held(self.asked.seed, self.asked.compilation)

    def _keep(self, verdicts: dict[tuple[str, ...], Verdict]) -> None:
        listed = [[name, [each.what, each.by, each.tests]] for name, each in verdicts.items()]
        _file(self.asked.seed, self.asked.compilation).write_text(json.dumps(listed))

    def run(self) -> None:
        """Collect the tests and work."""
        # The same examples for every mutant, none kept, and no time spent on making a failing one small.
        settings.register_profile("mutants", database=None, derandomize=True, phases=[Phase.explicit, Phase.generate])
        settings.load_profile("mutants")
        quiet = ["-q", "--no-header", "-p", "no:cacheprovider", "-p", "mutants.plain_steps", "-s"]
        quiet += ["-o", "addopts=--strict-markers", "-m", "not long and not soundness", "--rootdir", str(ROOT)]
        near = [
            f for part in self.judges if part in {self.parts[m.module] for m in self.mutants} for f in self.judges[part]
        ]
        tests = [*dict.fromkeys([*(self.asked.judge or near), *self.judges["warm"]])]
        status = pytest.main([*quiet, *tests], plugins=[Judge(ROOT, self.work)])
        if status not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
            sys.exit(4)


def main() -> None:
    """The command line of ``python -m mutants``; status 1 where a mutant survived that is not named equivalent."""
    parser = argparse.ArgumentParser(prog="python -m mutants", description=__doc__)
    targets = tomllib.loads((HERE / "targets.toml").read_text(encoding="utf-8"))
    parser.add_argument("--part", action="append", choices=list(targets["parts"]), help="one part; repeatable")
    parser.add_argument("--count", type=int, default=500, help="mutants drawn from all parts together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--again", action="store_true", help="only those that survived the last run, or were not run")
    parser.add_argument("--equivalents", action="store_true", help="also try those that are named equivalent")
    parser.add_argument("--judge", action="append", help="a file of tests that judges, in place of all; repeatable")
    parser.add_argument("--compilation", choices=("on", "off"), help=argparse.SUPPRESS)
    asked = parser.parse_args()
    check_examples()
    parts = modules_of(targets["parts"])
    mutants, possible = drawn(parts, asked.count, asked.seed)
    faults = tomllib.loads((HERE / "by_hand.toml").read_text(encoding="utf-8"))["fault"]
    every = list({m.name: m for m in (*mutants, *by_hand(ROOT, faults))}.values())
    chosen = [m for m in every if parts[m.module] in (asked.part or targets["parts"])]
    known = {} if asked.equivalents else equivalents()
    named = {m: Verdict("equivalent") for m in chosen if m.name in known}
    chosen = [m for m in chosen if m not in named]
    if asked.again:
        held = _held(asked.seed, "on", "off")
        chosen = [m for m in chosen if m.name not in held or _survived(held[m.name])]
    if asked.compilation is not None:
        now = [m for m in chosen if compiled(m) == (asked.compilation == "off")]
        if now:
            order = list(targets["parts"])
            now.sort(key=lambda m: order.index(parts[m.module]))
            _Round(now, parts, targets["judges"], asked).run()
        return
    print(f"{len(mutants)} of {possible} faults by seed {asked.seed}, {len(faults)} by hand; {len(chosen)} to try")
    for compilation in ("on", "off"):
        print(f"Compilation {compilation}", flush=True)
        if not asked.again and not asked.part:
            _file(asked.seed, compilation).unlink(missing_ok=True)
        environment = {key: value for key, value in os.environ.items() if key != "NUMBA_DISABLE_JIT"}
        environment |= {"NUMBA_DISABLE_JIT": "1"} if compilation == "off" else {}
        command = [sys.executable, "-m", "mutants", *sys.argv[1:], "--compilation", compilation]
        done = subprocess.run(command, env=environment, check=False)
        if done.returncode:
            sys.exit(done.returncode)
    held = _held(asked.seed, "on", "off")
    verdicts = {m: held[m.name] for m in every if m.name in held} | named
    good = report(verdicts, parts, possible)
    if len(verdicts) < len(every):
        print(f"{len(every) - len(verdicts)} not run")
    sys.exit(0 if good and len(verdicts) == len(every) else 1)
