"""`asmc-pin check`, `agree` and `reproduce`: what others can replay."""

from __future__ import annotations

import shlex
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from asmc_pin.cli.app import LISTS, MBAR, STUDIES, app
from asmc_pin.cli.condition_output import EXIT
from asmc_pin.cli.console import announce_compiling, print_json, progress_bar, say
from asmc_pin.cli.next_step import again, say_next
from asmc_pin.cli.opening_arms import open_single
from asmc_pin.cli.option_groups.grouping import takes_option_groups
from asmc_pin.cli.option_groups.loading_options import NOTHING, ONE_VALUE, LoadingOptions
from asmc_pin.cli.options import (
    ArmArgument,
    JsonOption,
)
from asmc_pin.condition.hypotheses import Hypotheses
from asmc_pin.disk.file_access import check_readable
from asmc_pin.words.text import quoted

if TYPE_CHECKING:
    from asmc_pin.condition.checker import CheckResult
    from asmc_pin.condition.hypotheses import Premises

_FEW_FILES, _LARGEST = 64, 2**24
"""Of URDFs in the folder that are looked at for the one that a certificate is about, bytes."""


@app.command(rich_help_panel=MBAR)
def check(
    certificate: Annotated[str, typer.Argument(metavar="CERTIFICATE", help="A file of --certificate.")],
    as_json: JsonOption = False,
) -> None:
    """Replay a certificate by two other routes: of a condition on M̄, of bounds of M(q), or of a sampled loop.

    Exit status 0: the certificate is valid and what it is about proven; 1: not valid, or valid and a counter-example,
    the text says which; 2: unreadable as a certificate; 3: valid, and what it is about undecided.
    """
    check_readable(certificate, "the certificate")
    from asmc_pin.condition.checker import check as run

    with progress_bar() as progress:
        result = run(certificate, progress=progress)
    if as_json:
        print_json(result.to_json_dict())
    else:
        say(*result.lines())
        _say_next(result)
    raise typer.Exit(1 if result.verdict is None else {"stable": 0, "unstable": 1, **EXIT}[result.verdict])


def _say_next(result: CheckResult) -> None:
    """What follows; never with words from a certificate that is not valid."""
    if result.hypotheses is None:
        mine = "asmc-pin verify two_link --mbar 0.02 --certify --certificate two_link.cert"
        say_next("how a certificate is made, here of a shipped arm", mine)
        return
    arm, whose = _arm_in(result.hypotheses)
    if result.verdict in ("holds", "stable"):
        said = f"whether the arm's model agrees with an independent engine{whose}"
        say_next(said, shlex.join(["asmc-pin", "agree", arm]))
    elif result.verdict == "violated":
        say_next(f"an M̄ that suits M(q){whose}", shlex.join(["asmc-pin", "design", arm]))
    elif result.verdict == "unstable":
        command = shlex.join(["asmc-pin", "design", arm, "--gains", "--period", "0.001"])
        say_next(f"gains that a loop bears, here at 1 ms{whose}", command)
    elif isinstance(result.hypotheses, Hypotheses) and result.hypotheses.mbar:
        mbar = ",".join(f"{value!r}" for value in result.hypotheses.mbar)
        command = shlex.join(["asmc-pin", "verify", arm, "--mbar", mbar, "--certify", "--budget", "10m"])
        say_next(f"more time for the proof, with the ranges of payload and rotors as they were{whose}", command)
    else:
        say_next(f"how large M(q) is{whose}", shlex.join(["asmc-pin", "bounds", arm, "--budget", "10m"]))


def _arm_in(premises: Premises) -> tuple[str, str]:
    """ARM for a command about what a certificate is about, and words that say whose file that is, if one has to ask.

    The certificate has the URDF's text, and knows not where the file lies: here, if one has the same hash.
    """
    import hashlib

    from asmc_pin.arms import arm_names

    for path in sorted(Path().glob("*.urdf"))[:_FEW_FILES]:
        with suppress(OSError):
            if path.stat().st_size < _LARGEST and hashlib.sha256(path.read_bytes()).hexdigest() == premises.sha256:
                return str(path), ""
    if premises.arm in arm_names():
        return premises.arm, ""
    return "ARM", f" (ARM: the URDF of {quoted(premises.arm)})"


@app.command(rich_help_panel=LISTS)
@takes_option_groups(instead=ONE_VALUE)
def agree(
    context: typer.Context,
    arm: ArmArgument,
    loading: LoadingOptions = NOTHING,
    seed: Annotated[int, typer.Option(min=0, help="Of the configurations and torques.")] = 0,
    as_json: JsonOption = False,
) -> None:
    """Compare an arm's dynamics with MuJoCo, which reads the same URDF text. Exit status 1 when they disagree."""
    loaded = open_single(arm, loading)
    from asmc_pin.agreement import agree as run

    report = run(loaded, seed=seed)
    if as_json:
        print_json(report.to_json_dict())
    else:
        say(*report.lines())
        if report.verdict == "agrees":
            say_next("the M̄ that suits M(q) best", again(context, "design"))
        else:
            say_next("what was read of the URDF, and what is doubtful", again(context, "inspect"))
    raise typer.Exit({"agrees": 0, "disagrees": 1, "not compared": 3}[report.verdict])


@app.command(rich_help_panel=STUDIES)
def reproduce(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Some of the paper's experiments.")
    ] = None,
    out: Annotated[
        str, typer.Option(metavar="DIR", help="Folder of the page and the results.")
    ] = "results/reproduction",
    force: Annotated[bool, typer.Option("--force", help="Replace results that are there already.")] = False,
    search: Annotated[bool, typer.Option("--search/--no-search", help="Try other readings of units and gains.")] = True,
    tune: Annotated[bool, typer.Option("--tune", help="Tune the laws anew first (long), into DIR/tuned.")] = False,
    docs: Annotated[str | None, typer.Option(metavar="DIR", help="Write the page into this folder as well.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Run the paper's experiments, as printed and as reconciled, and set its figures beside what is measured."""
    from asmc_pin.reproduction.printed_tables import known

    known(names)
    announce_compiling()
    from asmc_pin.reproduction.reproducing import reproduce as run

    with progress_bar() as progress:
        done = run(names, out, force=force, search=search, tune=tune, docs=docs, progress=progress)
    if as_json:
        print_json(done.to_json_dict())
    else:
        say(*done.lines())
