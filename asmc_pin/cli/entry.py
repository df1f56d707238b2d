"""Where the process begins: Ctrl-C, the standard streams and faults are taken care of before all else is loaded."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from asmc_pin.cli import interrupt


def main(argv: Sequence[str] | None = None) -> None:
    """Run the command line and exit the process with its status.

    Args:
        argv: Arguments without the program's name. When None, the process's own; then what is set here for Ctrl-C, the
            streams and faults stays until the process has ended.
    """
    own = argv is None
    with interrupt.at_once(keep=own):
        from asmc_pin.cli import fault, output

        with output.guarded(keep=own), fault.caught(keep=own):
            try:
                # A command imports what is heavy itself: --help and the answer to a typing error are quick.
                from asmc_pin.cli.dispatch import run

                status = run(argv)
                sys.stdout.flush()
            except BaseException as error:
                status = fault.status_of(error)
            status = fault.final(status)
    sys.exit(status)
