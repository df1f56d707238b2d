"""The application object, its exit statuses, and the one place where errors become messages."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence
from importlib.metadata import version
from typing import Annotated

import typer

from asmc_pin.errors import AsmcPinError

app = typer.Typer(
    name="asmc-pin",
    help="Is this M̄ allowed, which controller is better, what does it look like: TDE control of an arm from its URDF.",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

INTERRUPTED = 130
"""Exit status after Ctrl-C."""


def _print_version(value: bool) -> None:
    if value:
        typer.echo(f"asmc-pin {version('asmc-pin')}")
        raise typer.Exit()


@app.callback()
def _root(
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


def main(argv: Sequence[str] | None = None) -> None:
    """Run the command line and exit the process with its status.

    Args:
        argv: Arguments without the program's name; the process's own when None.
    """
    # Commands register themselves on import; what is heavy is imported inside each command, so that --help is quick.
    from asmc_pin.cli import condition, design, proof, study, tables  # noqa: F401

    warnings.showwarning = _show_warning
    try:
        status = app(args=None if argv is None else list(argv), standalone_mode=False)
    except AsmcPinError as error:
        _fail(str(error))
    except KeyboardInterrupt:
        status = INTERRUPTED
    except BrokenPipeError:
        # The reader (head, less) has left: not an error of ours, and nothing more can be said to it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except MemoryError as error:
        _fail(f"out of memory: {error or 'the run is too large'}; shorten it, or take fewer samples or trials")
    except OSError as error:
        _fail(f"{error.strerror or error}{f': {error.filename}' if error.filename else ''}")
    except Exception as error:
        # Usage errors: typer carries click's classes under names of its own that moved between its releases.
        if not (hasattr(error, "format_message") and hasattr(error, "exit_code")):
            raise
        context = getattr(error, "ctx", None)
        hint = f" (see '{context.command_path} --help')" if context is not None else ""
        _fail(f"{error.format_message().rstrip('.')}{hint}")
    if status == INTERRUPTED:  # typer makes of Ctrl-C a status, and says nothing
        _fail("interrupted; nothing half-written was left behind", INTERRUPTED)
    sys.exit(status if isinstance(status, int) else 0)


def _fail(message: str, status: int = 2) -> None:
    print(f"asmc-pin: {message}", file=sys.stderr)
    sys.exit(status)


def _show_warning(message: Warning | str, *_args: object, **_kwargs: object) -> None:
    print(f"asmc-pin: warning: {message}", file=sys.stderr)
