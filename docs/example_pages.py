"""Run examples/NAME.py for every docs/NAME.md there is, and put what it printed into the page's block of output.

    python docs/example_pages.py

The block is the one that ``sh`` with the command of the example stands before. It takes minutes, so `make docs` does
not do it; a long test says whether a page still shows what its example prints.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from asmc_pin.disk.files import write_whole

ROOT = Path(__file__).resolve().parent.parent


def pages() -> list[tuple[Path, Path]]:
    """Examples that have a page, and the page."""
    found = ((path, ROOT / "docs" / f"{path.stem}.md") for path in sorted((ROOT / "examples").glob("*.py")))
    return [(path, page) for path, page in found if page.is_file()]


def with_output(text: str, example: str, output: str) -> str:
    """A page with other output after the command that runs its example."""
    block = re.compile(rf"(```sh\npython examples/{example}\.py\n```\n\n```text\n).*?(```)", re.DOTALL)
    if len(block.findall(text)) != 1:
        raise SystemExit(f"docs/{example}.md has not exactly one block of output after 'python examples/{example}.py'")
    return block.sub(lambda match: match[1] + output + match[2], text)


def main() -> None:
    """Write all pages anew."""
    for path, page in pages():
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, str(path)], cwd=folder, check=True, capture_output=True, text=True)
        write_whole(page, with_output(page.read_text(encoding="utf-8"), path.stem, done.stdout))
        print(page.relative_to(ROOT))


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    main()
