"""The command that the last line of a verdict names."""

import re
import shlex


def next_words(out: str) -> list[str]:
    """Its words without the program's name.

    Args:
        out: What was printed.
    """
    found = re.fullmatch(r"next: [^:]+: (asmc-pin .*)", out.splitlines()[-1])
    assert found, out.splitlines()[-1]
    return shlex.split(found[1])[1:]
