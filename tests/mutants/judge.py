"""Runs tests against mutants in forks of one warm process, in which all is imported and all tests are collected.

A fork gives the changed function its new code, in place, and runs those tests that call it, the quickest first, until
one fails. That costs a small part of a second, where a new process would import for some seconds first. What is not the
code of a function (a default, a constant of a module) does need that new process: see `substitute`.
"""

from __future__ import annotations

import gc
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import types
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from _pytest.runner import runtestprotocol

from mutants.draw import Mutant, changed_function

LONGEST = 2.0
"""Seconds of processor time that a test may take and still judge mutants."""

ENOUGH = 8.0
"""Seconds of processor time, without a fault, of all tests of a file that one mutant is shown."""

PATIENCE = 5.0
"""A mutant under which the tests take so many times as long, and as many seconds more, is killed: it does not end."""

Covered = dict[str, tuple[float, frozenset[str]]]
"""For each test that passes: its seconds, and the functions it calls, as `module:name`."""


@dataclass
class Verdict:
    """What became of a mutant: "killed" (by), "endless" (by), "survived" (tests), "not called" (of any test)."""

    what: str
    by: str = ""
    tests: int = 0


@dataclass
class Judge:
    """A pytest plugin whose loop of tests is a campaign.

    Attributes:
        root: The project's folder.
        work: Given a judge with its tests collected, does the campaign.
        items: The tests by name.
    """

    root: Path
    work: Callable[[Judge], None]
    items: dict[str, Any] = field(default_factory=dict)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: Any) -> bool:
        self.items = {item.nodeid: item for item in session.items}
        session.config._tmp_path_factory.getbasetemp()  # one for all forks
        self.work(self)
        return True

    def warm(self, names: list[str]) -> None:
        """Run some tests here, so that forks find compiled code loaded."""
        for name in names:
            if not self._passes(name):
                raise RuntimeError(f"{name} fails without any fault")

    def cover(self, names: list[str], modules: list[str], workers: int) -> Covered:
        """Time each test, and see what it calls; those that fail, or take too long, are left out."""
        inside = {str(self.root / module): module for module in modules}
        found: Covered = {}

        def one(name: str, out: Any) -> None:
            called = set()

            def enter(frame: Any, event: str, arg: Any) -> None:
                code = frame.f_code
                if code.co_filename in inside:
                    called.add(f"{inside[code.co_filename]}:{code.co_qualname}")

            _limit(LONGEST)
            sys.settrace(enter)
            passed = self._passes(name)
            sys.settrace(None)
            out.write(json.dumps([passed, _spent(), sorted(called)]))

        for name, text, _ in forked([(name, lambda out, name=name: one(name, out)) for name in names], workers):
            if text:
                passed, seconds, called = json.loads(text)
                if passed:
                    found[name] = (seconds, frozenset(_outermost(each) for each in called))
            _progress("." if name in found else "x")
        return found

    def _passes(self, name: str, following: str | None = None) -> bool:
        after = None if following is None else self.items[following]
        reports = runtestprotocol(self.items[name], log=False, nextitem=after)
        return all(report.passed or report.skipped for report in reports) and any(r.passed for r in reports)

    def verdicts(
        self, shown: dict[Mutant, list[str]], covered: Covered, workers: int
    ) -> Iterator[tuple[Mutant, Verdict]]:
        """Try mutants, each on the tests that it is shown, and say of each what became of it."""
        mutants = list(shown)
        live = _live_functions({str(self.root / m.module) for m in mutants})
        jobs: list[tuple[Any, Callable[[Any], None]]] = []
        for k, mutant in enumerate(mutants):
            names = shown[mutant]
            if not names:
                yield mutant, Verdict("not called")
            elif mutant.function is None:
                jobs.append((k, lambda out, m=mutant, n=names: out.write(_cold(self.root, m, n))))
            else:
                seconds = sum(covered[name][0] for name in names)
                jobs.append((k, lambda out, m=mutant, n=names, s=seconds: self._warm(m, live, n, s, out)))
        for k, text, status in forked(jobs, workers):
            done = [line for line in text.splitlines() if line]
            if status > 0:
                raise RuntimeError(f"the judge itself failed over {mutants[k].name}: {text}")
            if done and done[-1].startswith("killed "):
                verdict = Verdict("killed", done[-1].removeprefix("killed "), len(done))
            elif done and done[-1] == "survived":
                verdict = Verdict("survived", "", len(shown[mutants[k]]))
            else:
                # The clock, or a crash, ended it during the test after the last that passed.
                stopped = -status in (signal.SIGXCPU, signal.SIGKILL, signal.SIGALRM)
                by = shown[mutants[k]][min(len(done), len(shown[mutants[k]]) - 1)]
                verdict = Verdict("endless" if stopped else "killed", by, len(done))
            yield mutants[k], verdict

    def _warm(self, mutant: Mutant, live: dict[Any, list[Any]], names: list[str], seconds: float, out: Any) -> None:
        path = str(self.root / mutant.module)
        old = compile(Path(path).read_text(encoding="utf-8"), path, "exec")
        pair = changed_function(old, compile(mutant.source, path, "exec"))
        assert pair is not None
        there = live.get((path, pair[0].co_qualname, pair[0].co_firstlineno), [])
        # Without its functions (made and used while modules were imported), or with other variables from outside, which
        # cannot be put into one that is there, a mutant needs a process of its own.
        if not there or len(pair[0].co_freevars) != len(pair[1].co_freevars):
            out.write(_cold(self.root, mutant, names))
            return
        for function in there:
            function.__code__ = pair[1]
        _limit(PATIENCE * (seconds + 1.0))
        for name, following in zip(names, [*names[1:], None], strict=True):
            if not self._passes(name, following):
                out.write(f"killed {name}\n")
                return
            out.write("passed\n")
            out.flush()
        out.write("survived\n")


def judging(mutant: Mutant, covered: Covered, among: list[str]) -> list[str]:
    """The tests, of some, that a mutant is shown, the quickest first: those that call its function.

    What is no function's code (a default, a constant) is not called: all tests stand for it of those files in which one
    calls something of its module. Of a module of constants alone nothing can be called: all tests stand for it.
    """
    among = [name for name in among if name in covered]
    if mutant.function is not None:
        names = [name for name in among if f"{mutant.module}:{mutant.function}" in covered[name][1]]
    else:
        inside = f"{mutant.module}:"
        near = {file_of(name) for name in among if any(each.startswith(inside) for each in covered[name][1])}
        names = [name for name in among if file_of(name) in near or not near]
    names.sort(key=lambda name: covered[name][0])
    most = ENOUGH if mutant.function is not None else 4.0 * ENOUGH  # all tests of its part at once
    taken, total = [], 0.0
    for name in names:
        total += covered[name][0]
        if taken and total > most:
            break
        taken.append(name)
    return taken


def file_of(test: str) -> str:
    """The file of a test, from its name."""
    return test.split("::", maxsplit=1)[0]


def _outermost(called: str) -> str:
    """`module:f.<locals>.<lambda>` is the code of `module:f`."""
    return called.split(".<locals>", maxsplit=1)[0]


def _live_functions(paths: set[str]) -> dict[Any, list[Any]]:
    """The functions of some files that are in memory, by file, name and line."""
    found: dict[Any, list[Any]] = {}
    for each in gc.get_objects():
        if isinstance(each, types.FunctionType) and each.__code__.co_filename in paths:
            code = each.__code__
            found.setdefault((code.co_filename, code.co_qualname, code.co_firstlineno), []).append(each)
    return found


def _cold(root: Path, mutant: Mutant, names: list[str]) -> str:
    """Judge in a new process, which imports the changed module."""
    with tempfile.NamedTemporaryFile("w", suffix=".py", encoding="utf-8") as file:
        file.write(mutant.source)
        file.flush()
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-p",
            "mutants.substitute",
            "-p",
            "mutants.plain_steps",
            "-x",
            "-q",
            *names,
        ]
        command += ["-p", "no:cacheprovider", "-p", "no:randomly", "-n", "0"]
        environment = os.environ | {"MUTANT_OF": str(root / mutant.module), "MUTANT": file.name}
        environment["PYTHONPATH"] = os.pathsep.join([str(root), str(root / "tests"), environment.get("PYTHONPATH", "")])
        done = subprocess.run(
            command, cwd=root, env=environment, capture_output=True, text=True, check=False, timeout=1800
        )
    if done.returncode == 0:
        return "survived\n"
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return f"killed {failed[0].split()[1] if failed else 'while imported'}\n"


def _spent() -> float:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def _limit(seconds: float) -> None:
    """End this process by a signal when it has used so many seconds of a processor."""
    signal.signal(signal.SIGXCPU, signal.SIG_DFL)
    signal.alarm(int(60.0 * seconds) + 300)  # for what sleeps; processes may be many and processors few
    soft = int(_spent() + seconds) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (soft, soft + 5))


def _progress(mark: str) -> None:
    os.write(2, mark.encode())


def forked(jobs: list[tuple[Any, Callable[[Any], None]]], workers: int) -> Iterator[tuple[Any, str, int]]:
    """Run each job in a fork, some at a time: its key, what it wrote, and its exit status (negative: a signal)."""
    waiting, running = list(reversed(jobs)), dict[int, tuple[Any, Path]]()
    gc.collect()
    gc.freeze()  # a fork that looks for garbage among what is here would copy all of it
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        while waiting or running:
            while waiting and len(running) < workers:
                key, job = waiting.pop()
                path = Path(folder) / f"{len(waiting)}"
                pid = os.fork()
                if pid == 0:
                    _run_and_exit(job, path)
                running[pid] = (key, path)
            pid, raw = os.wait()
            if pid not in running:
                continue
            key, path = running.pop(pid)
            text = path.read_text(encoding="utf-8") if path.exists() else ""
            yield key, text, os.waitstatus_to_exitcode(raw)
    gc.unfreeze()


def _run_and_exit(job: Callable[[Any], None], path: Path) -> None:
    status = 1
    try:
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        with path.open("w", encoding="utf-8") as out:
            job(out)
        status = 0
    except BaseException as error:  # whatever it is, it ends this fork and no more
        path.write_text(f"{type(error).__name__}: {error}", encoding="utf-8")
    finally:
        os._exit(status)
