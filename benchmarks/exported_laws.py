"""A table of docs/export.md: every law as C on the demo's arm, single from double precision, instructions in a tick.

    python benchmarks/exported_laws.py

Needs gcc and valgrind. A tick's instructions are those of `_step` in callgrind's count, the largest over all
recorded ticks of the law: they do not depend on the machine's load, but on compiler, flags and the C library.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from asmc_pin import CONTROLLERS, export, load_experiment

COUNTING = """
#include "{name}.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
/* Runs the ticks one by one; between two of them callgrind writes down what the tick took. */
int main(int argc, char **argv)
{{
    static char line[20000];
    static {name}_state state;
    FILE *file = fopen(argv[argc - 1], "r");
    if (file == NULL || fgets(line, sizeof line, file) == NULL) return 2;
    while (fgets(line, sizeof line, file) != NULL) {{
        double cell[3 + 7 * {upper}_NV];
        {name}_sample sample;
        {name}_setpoint setpoint;
        {name}_real tau[{upper}_NV];
        char *at = line;
        for (int i = 0; i < 3 + 7 * {upper}_NV; ++i) {{
            cell[i] = strtod(at, &at);
            ++at;
        }}
        for (int i = 0; i < {upper}_NV; ++i) {{
            sample.q[i] = ({name}_real)cell[3 + i];
            sample.v[i] = ({name}_real)cell[3 + {upper}_NV + i];
            sample.tau[i] = ({name}_real)cell[3 + 2 * {upper}_NV + i];
            setpoint.q[i] = ({name}_real)cell[3 + 3 * {upper}_NV + i];
            setpoint.v[i] = ({name}_real)cell[3 + 4 * {upper}_NV + i];
            setpoint.a[i] = ({name}_real)cell[3 + 5 * {upper}_NV + i];
        }}
        if (cell[0] != 0.0) {name}_init({name}_parameters_exported(), &state, &sample);
        else {name}_step({name}_parameters_exported(), &state, &sample, &setpoint, ({name}_real)cell[1], tau);
    }}
    return 0;
}}
"""


def instructions(folder: Path, name: str) -> int:
    """Most instructions that a tick takes, -O2."""
    (folder / "counting.c").write_text(COUNTING.format(name=name, upper=name.upper()))
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-fno-inline-functions-called-once"]
    subprocess.run(["gcc", *flags, f"{name}.c", "counting.c", "-o", "counting", "-lm"], cwd=folder, check=True)
    step = f"{name}_step"  # a function of its own file, so that it is not inlined into the loop
    options = ["--tool=callgrind", f"--toggle-collect={step}", f"--dump-after={step}", "--callgrind-out-file=taken"]
    vectors = f"{name}_vectors.csv"
    subprocess.run(["valgrind", "-q", *options, "./counting", vectors], cwd=folder, check=True, capture_output=True)
    counts = []
    for path in folder.glob("taken*"):
        found = re.search(r"^(?:summary|totals): (\d+)", path.read_text(), re.M)
        counts.append(int(found[1]) if found else 0)
        path.unlink()
    return max(counts)


def main() -> None:
    """Print the table."""
    demo = load_experiment("demo")
    print("| law | float from double | instructions | in float |")
    print("| --- | --- | --- | --- |")
    work = Path(tempfile.mkdtemp())
    for law, kind in CONTROLLERS.items():
        own = next((c for c in demo.controllers.values() if c["law"] == law), {"law": law, **kind.typical})
        experiment = demo.replace(controllers={"It": own})
        cells, counted = [], []
        for real in ("double", "float"):
            folder = work / f"{law}_{real}"
            done = export(experiment, "It", folder, real=real)
            cells += [f"{done.from_double:.1e}"] if real == "float" else []
            counted.append(str(instructions(folder, "demo_it")))
        print("| " + " | ".join([f"`{law}`", *cells, *counted]) + " |", flush=True)
    shutil.rmtree(work)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    main()
