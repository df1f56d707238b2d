"""Hundreds of mutants against the quick tests, and a report of those that no test noticed."""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import pickle
import subprocess
import sys
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import Phase, settings

from mutants.draw import Mutant, by_hand, draw
from mutants.judge import Covered, Judge, Verdict
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


def covered(judge: Judge, modules: list[str], workers: int) -> Covered:
    """What each test calls; measured anew for files of tests that changed, and all when the package did."""
    shared = _digest([*ROOT.glob("asmc_pin/**/*.py"), *ROOT.glob("tests/support/*.py")])
    found: Covered = {}
    for file in sorted({name.split("::", maxsplit=1)[0] for name in judge.items}):
        names = [name for name in judge.items if name.split("::", maxsplit=1)[0] == file]
        kept = (
            SCRATCH
            / f"calls-{os.environ.get('NUMBA_DISABLE_JIT', '0')}-{shared}-{_digest([ROOT / file])}-{len(names)}.json"
        )
        if kept.exists():
            held = {
                name: (seconds, frozenset(calls)) for name, (seconds, calls) in json.loads(kept.read_text()).items()
            }
        else:
            held = judge.cover(names, modules, workers)
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_text(json.dumps({name: (seconds, sorted(calls)) for name, (seconds, calls) in held.items()}))
            print(f" {file}: {len(held)} of {len(names)} tests judge", flush=True)
        found |= held
    return found


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


def compiled(mutant: Mutant) -> bool:
    """Whether a mutant is judged with compilation off.

    So is what is compiled, and what is not the code of a function, as compiled code keeps constants that it has seen.
    All else is judged with compilation on, where whole runs of the plant are quick.
    """
    return mutant.function is None or "njit" in mutant.source or "@compiled" in mutant.source


def _file(seed: int, compilation: str) -> Path:
    return SCRATCH / f"verdicts-{seed}-{compilation}.json"


def _held(seed: int, *compilations: str) -> dict[tuple[str, ...], Verdict]:
    """The verdicts so far of a seed."""
    files = [file for each in compilations if (file := _file(seed, each)).exists()]
    return {tuple(name): Verdict(*each) for file in files for name, each in json.loads(file.read_text())}


def _campaign(mutants: list[Mutant], parts: dict[str, str], judges: dict[str, list[str]], asked: Any) -> None:
    """Judge mutants in this process and its forks, and keep what comes of each."""
    order = list(dict.fromkeys(parts.values()))
    mutants = sorted(mutants, key=lambda m: order.index(parts[m.module]))

    def work(judge: Judge) -> None:
        judge.warm(judges["warm"])
        calls = covered(judge, list(parts), asked.workers)
        for done, (mutant, verdict) in enumerate(judge.verdicts(mutants, calls, asked.workers), 1):
            held = _held(asked.seed, asked.compilation) | {mutant.name: verdict}
            listed = [[name, [each.what, each.by, each.tests]] for name, each in held.items()]
            _file(asked.seed, asked.compilation).write_text(json.dumps(listed))
            if _survived(verdict):
                print(f"{done}/{len(mutants)} {verdict.what}: {mutant.module}:{mutant.line}", flush=True)

    # The same examples for every mutant, none kept, and no time spent on making a failing one small.
    settings.register_profile("mutants", database=None, derandomize=True, phases=[Phase.explicit, Phase.generate])
    settings.load_profile("mutants")
    quiet = ["-q", "--no-header", "-p", "no:cacheprovider", "-s", "-o", "addopts=--strict-markers"]
    quiet += ["-m", "not long and not soundness"]
    tests = [
        *(asked.judge or judges["tests"]),
        *judges["warm"],
        "-m",
        "not long and not soundness",
        "--rootdir",
        str(ROOT),
    ]
    status = pytest.main([*quiet, *tests], plugins=[Judge(ROOT, work)])
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
    parser.add_argument("--judge", action="append", help="a file of tests that judges, in place of all; repeatable")
    parser.add_argument("--compilation", choices=("on", "off"), help=argparse.SUPPRESS)
    asked = parser.parse_args()
    check_examples()
    parts = modules_of(targets["parts"])
    mutants, possible = drawn(parts, asked.count, asked.seed)
    faults = tomllib.loads((HERE / "by_hand.toml").read_text(encoding="utf-8"))["fault"]
    every = list({m.name: m for m in (*mutants, *by_hand(ROOT, faults))}.values())
    chosen = [m for m in every if parts[m.module] in (asked.part or targets["parts"])]
    if asked.again:
        held = _held(asked.seed, "on", "off")
        chosen = [m for m in chosen if m.name not in held or (_survived(held[m.name]) and m.name not in equivalents())]
    if asked.compilation is not None:
        now = [m for m in chosen if compiled(m) == (asked.compilation == "off")]
        if now:
            _campaign(now, parts, targets["judges"], asked)
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
    verdicts = {m: held[m.name] for m in every if m.name in held}
    good = report(verdicts, parts, possible)
    if len(verdicts) < len(every):
        print(f"{len(every) - len(verdicts)} not run")
    sys.exit(0 if good and len(verdicts) == len(every) else 1)
