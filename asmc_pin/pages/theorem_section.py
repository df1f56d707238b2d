"""The theorems' section of a report page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pandas as pd

from asmc_pin.monitors import STATEMENTS, STATUSES
from asmc_pin.pages.html_fragments import definition_list, details, scroll
from asmc_pin.pages.theorem_tables import INTRODUCTION, TITLE, asked, reasons, theorem_table
from asmc_pin.words.media import for_html


def theorem_section(claims: pd.DataFrame, colours: Mapping[str, str]) -> Iterator[str]:
    """The verdicts, a row for each controller, then what each claim says and why it held or not.

    Args:
        claims: See `asmc_pin.monitors.claim_rows`.
        colours: Colour of each controller, shown beside its name.
    """
    table = theorem_table(claims)
    shown = [STATEMENTS[key] for key in asked(claims)]
    yield f'<h2 id="theorems">{for_html(TITLE)}</h2><p class="soft">{for_html(INTRODUCTION)}</p>'
    head = "".join(f'<th scope="col">{for_html(item.title)}</th>' for item in shown)
    rows = []
    for i, label in enumerate(table.header[1:], start=1):
        chip = f'<span class="chip" style="--colour:{colours[label]}"></span>' if label in colours else ""
        cells = "".join(_cell(row[i]) for row in table.rows)
        rows.append(f'<tr data-controller="{for_html(label)}"><th scope="row">{chip}{for_html(label)}</th>{cells}</tr>')
    head = f'<th scope="col">controller</th>{head}'
    body = f"<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody>"
    yield scroll(TITLE, f'<table class="claims">{body}</table>')
    texts = definition_list([(item.title, item.text) for item in shown])
    yield details("What each claim says", f'<div class="body">{texts}</div>')
    for label, lines in reasons(claims):
        items = "".join(f"<li>{for_html(line)}</li>" for line in lines)
        yield details(f"{label}: what was seen, and why", f'<ul class="body">{items}</ul>')


def _cell(text: str) -> str:
    """Red only where no cause is known: what finite sampling or the plant does to every law is no fault of this one."""
    verdict = next((status for status in STATUSES if text == status or text.startswith(f"{status} ")), "")
    if verdict == "broken":
        cause = text.partition(" at ")[0]
        kind, verdict = ("over" if cause == "broken" else "noted"), cause
    else:
        kind = "held" if text == "held" else "soft"
    return f'<td class="{kind}"><b>{for_html(verdict)}</b>{for_html(text.removeprefix(verdict))}</td>'
