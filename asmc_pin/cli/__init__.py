"""The command line: parse, call, print.

Exit status: 0 it holds, was not refuted, or ran; 1 the condition is violated, no M̄ within the bounds satisfies it, or
the loop is unstable; 2 bad input; 3 undecided within the budget; 130 interrupted.
"""

from asmc_pin.cli.app import main

__all__ = ["main"]
