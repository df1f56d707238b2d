"""Two parts of the page on the paper: where its numbers cannot hold, and which other readings of them were tried."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from asmc_pin.pages.tables.text_table import Table, markdown_table, number


def words(reading: Mapping[str, str]) -> str:
    """A reading's departures from what is printed, as an addition to a sentence."""
    return f" ({_departures(reading)})" if reading else ""


def _departures(reading: Mapping[str, str]) -> str:
    return ", ".join(_option(*item) for item in reading.items()) or "as printed"


def _option(axis: str, option: str) -> str:
    if axis == "errors":
        return "errors in rad, though labelled deg"
    return option if axis in ("gains", "adaptation", "inertia") else f"{axis}: {option}"


def cannot_hold(data: Mapping[str, Any]) -> Iterator[str]:
    """Claims about numbers that no detail of the plant can save."""
    for name, bound in data["limits"].items():
        item = data["experiments"][name]
        told = item["paper"]["rms_deg"]["PPC"]
        found = item["controllers"]["PPC"]["rms_deg"]
        yield (
            f"**Table {item['table']}, PPC.** Under a load that drifts at ḣ the sampled loop (7) settles at e = L "
            "ḣ/(m̄ β k_s), exactly so on a joint of constant "
            "inertia. With the printed L, M̄, β and K_s the gravity torque along the reference alone asks for "
            f"{_pair(bound['drift_deg'])} deg RMS by this formula. "
            f"Measured {_pair(found)}, printed {_pair(told)}. "
            + (
                "The formula is for small errors; that it asks for more than a radian says that the printed gains do "
                "not "
                "track this motion at all."
                if max(bound["drift_deg"]) > 57.0
                else "Here the two are of one order, so that the printed gains are possible."
            )
        )
        yield ""
        for joint, turn in enumerate(bound["reversals"]):
            if turn is None:
                continue
            yield (
                f"**Fig. {item['figures']['error']}, joint {joint + 1}, PPC.** Where the reference reverses (t = "
                f"{number(turn['time'])} s) the Coulomb friction of 50 N·m does, "
                "and the joint sticks until its torque has moved by 100 N·m. The printed gains move it so slowly "
                "that the joint breaks away with an error of "
                f"{number(turn['error_deg'])} deg; the figure shows "
                f"{number(item['paper']['max_error_deg'][joint])} deg at most, for which "
                f"β = k_s would have to be {number(turn['gain'])}. With M̄ = 0.01 and L = 1 ms the loop diverges at "
                "57 already (see the readings below)."
            )
            yield ""
    last = data["experiments"].get("baek2016_experiment")
    if last:
        s = last["controllers"]["Proposed"]["max_s"]
        yield (
            f"**Section IV, ε = 35.** The largest |s| of the run is {_pair(s)} rad/s; the paper's Fig. 11 shows up to "
            "140. In rad/s the threshold ε = 35 is never "
            "reached, and the proposed law only adds to its gain in the ticks at which k̂ is 0. In degrees per "
            "second ε is 0.61 rad/s."
        )
        yield ""


def search_section(data: Mapping[str, Any]) -> Iterator[str]:
    """What was tried, and what came nearest."""
    yield (
        "PPC and the proposed law, whose gains are printed, were run under other readings of units and gains. The "
        "distance is the root mean square of the logarithms "
        "of measured over printed, said as a factor: 1 would be the paper. It is over the RMS errors of both laws at "
        "both joints, and over the largest torque, gain and "
        "s of the proposed law; of these three an axis of a figure is met by half to all of it. Two rules: a reading "
        "that asks for more than twice the torque that the figure "
        "shows is out; and a departure from what is printed has to halve the factor at least, or it is not taken."
    )
    yield ""
    for found in data["readings"].values():
        tables = [data["experiments"][name]["table"] for name in found["members"]]
        name = f"Table {tables[0]}" if len(tables) == 1 else f"Tables {' and '.join(tables)} together"
        yield f"### {name}"
        yield ""
        taken = found["taken"]
        yield (
            f"{found['tried']} readings. Taken: {_departures(taken['reading'])}, a factor of "
            f"{number(taken['factor'])}; as "
            "printed it is "
            f"{_factor(found['alone'][0])}."
        )
        yield ""
        if _same(taken, found["alone"][0]):
            yield (
                "This reading changes no RMS error: ‖s‖_∞ stays below ε under both, so that k̂ leaves 0 "
                "for a "
                "tick at a time, and all that changes is what the axes of s and k̂ are read in. It does not explain "
                "the "
                "rest of the distance."
            )
            yield ""
        yield "The nearest reading for each number of departures, combined:"
        yield ""
        yield _readings_table(found["ladder"], tables)
        yield ""
        yield "One departure at a time:"
        yield ""
        yield _readings_table(found["alone"], tables)
        yield ""


def _same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether two readings have the same RMS errors, to a part in a thousand."""
    pairs = [
        (a, b)
        for x, y in zip(one["rms"] or [], other["rms"] or [], strict=True)
        for label in x
        for a, b in zip(x[label], y[label], strict=True)
    ]
    return bool(pairs) and all(math.isclose(a, b, rel_tol=1e-3) for a, b in pairs)


def _readings_table(rows: list[Mapping[str, Any]], tables: list[str]) -> str:
    header = ["reading", "factor"]
    for table in tables:
        header += [f"Table {table}, PPC", f"Table {table}, proposed", "torque [N·m]"]
    cells = []
    for row in rows:
        line = [_departures(row["reading"]), _factor(row)]
        for i in range(len(tables)):
            if row["rms"] is None:
                line += ["–", "–", "–"]
            else:
                line += [_pair(row["rms"][i]["PPC"]), _pair(row["rms"][i]["Proposed"]), number(row["torque"][i])]
        cells.append(line)
    return markdown_table(Table("", header, cells))


def _factor(row: Mapping[str, Any]) -> str:
    return "a law diverges" if row["factor"] is None else number(row["factor"])


def _pair(values: list[float | None]) -> str:
    return " / ".join(number(math.nan if x is None else x if abs(x) > 1e-9 else 0.0) for x in values)
