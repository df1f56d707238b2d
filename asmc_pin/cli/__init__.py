"""The command line: parse, call, print.

Takes words; gives the lines or the JSON of the same functions as in Python. May import all rooms; nobody imports it.

Exit status: 0 it holds, was not refuted, or ran; 1 the condition is violated, no M̄ within the bounds satisfies it, the
loop is unstable somewhere, the engines disagree, or a certificate is not valid; 2 bad input; 3 undecided; 4 a fault of
asmc-pin itself, with a file that the traceback went to; 130 interrupted, at any moment. Output that nobody reads to its
end, or that cannot show every sign, keeps the status.
"""

from asmc_pin.cli.entry import main

__all__ = ["main"]
