"""Frames per second of the player, and the time that pages take to open, in a browser that draws without a GPU.

    python benchmarks/viewer.py [--result DIR] [--repeats 5] [--seconds 6] [--keep DIR] [--against DIR] [--readme]

The headless Chromium of `asmc-pin view --png` draws all of it on the processor (SwiftShader), so the frames are those
of the slowest machine that anyone has. The pages are those of the demo: four UR5, each with its reference. A page is
complete when its words, its curves and the first picture of its scene are there, which a pixel read back proves.
``--keep`` leaves the pages; ``--against`` measures those of another version in turn with these.
"""

from __future__ import annotations

import argparse
import dataclasses
import re
import statistics
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from asmc_pin import compare, explore, load_arm, load_experiment, verify
from asmc_pin.disk.files import write_whole
from asmc_pin.pages.comparison_page import report_html
from asmc_pin.pages.condition_page import write_condition_report
from asmc_pin.results.result_folder import Result, load_result
from asmc_pin.viewer import write_replay
from asmc_pin.viewer.film.headless_browser import HeadlessBrowser, HeadlessPage, headless_browser

SIZE = (1280, 720)
MBAR = 0.05
"""kg·m², of the pages about a condition."""

EMPTY = """<!doctype html><html lang="en"><meta charset="utf-8"><title>empty</title>
<canvas width="1280" height="720"></canvas><script>
const gl = document.querySelector("canvas").getContext("webgl2");
const draw = (now) => { gl.clearColor(0.5 + 0.5 * Math.sin(now / 500), 0, 0, 1); gl.clear(gl.COLOR_BUFFER_BIT); };
const tick = (now) => { requestAnimationFrame(tick); draw(now); window.drawn = true; };
requestAnimationFrame(tick);
</script></html>
"""
"""What a frame and an opening cost without anything of ours."""

CONTEXTS = (
    "const contexts = () => window.gl ? [gl] :"
    " [...(window.replays ?? []).map(({ stage }) => stage), ...(window.explorer ? [explorer.stage] : [])]"
    ".map(({ viewer }) => viewer.renderer.getContext());"
    "const read = () => contexts().forEach("
    "(c) => c.readPixels(0, 0, 1, 1, c.RGBA, c.UNSIGNED_BYTE, new Uint8Array(4)));"
)
"""A pixel that was read back has waited for all that was asked of the renderer before."""

COMPLETE = (
    f"(() => {{ {CONTEXTS} const ready = () => window.drawn || (window.replays?.length &&"
    " replays.every(({ stage }) => !stage.viewer.needs_render)) ||"
    " (window.explorer && !explorer.stage.viewer.needs_render && !document.querySelector('.map.is-stale'));"
    " return new Promise((done) => { const look = async () => { if (!ready()) return requestAnimationFrame(look);"
    " await Promise.all((window.signalFigures ?? []).map((figure) => figure.ready)); read();"
    " const painted = performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? performance.now();"
    " done([painted, performance.now()]); };"
    " requestAnimationFrame(look); }); })()"
)
"""Milliseconds from the navigation to the first words and to the complete page."""

FRAMES = (
    f"((wanted) => {{ {CONTEXTS} const replay = window.replays?.[0];"
    " if (replay) { replay.loop.checked = true; replay.speed = 1; replay.seek(0); replay.play(); }"
    " return new Promise((done) => { let first = 0, count = -1; const look = () => { count += 1;"
    " if (count === 0) { read(); first = performance.now(); }"
    " if (performance.now() - first < wanted) return requestAnimationFrame(look);"
    " read(); done(1000 * count / (performance.now() - first)); };"
    " requestAnimationFrame(look); }); })"
)
"""Frames per second while it plays."""

OPENED = {
    "empty": "an empty WebGL canvas",
    "one": "player, one UR5",
    "player": "player, four UR5",
    "report": "report of the demo",
    "condition": "condition on M̄, UR5",
    "explore": "explorer, UR5",
}
PLAYED = {
    ("empty", False): "an empty WebGL canvas",
    ("one", False): "one UR5 and its reference",
    ("player", False): "four UR5 side by side",
    ("player", True): "four UR5 on one base",
}
README = Path(__file__).with_name("README.md")


def make_pages(result: Result, folder: Path) -> None:
    """All pages of `OPENED`."""
    one = dataclasses.replace(result, dataset=result.dataset.isel(controller=[0]))
    write_whole(folder / "empty.html", EMPTY)
    write_replay(one, folder / "one.html")
    write_replay(result, folder / "player.html")
    report_html(result, folder / "report.html")
    arm = load_arm("ur5")
    write_condition_report(verify(arm, MBAR), arm, folder / "condition.html")
    explore(arm, MBAR, html=folder / "explore.html")


def opening(browser: HeadlessBrowser, page: Path) -> tuple[float, float]:
    """Seconds until the first words, and until a page is complete, in a tab of its own."""
    with browser.tab(HeadlessPage) as tab:
        tab.size(*SIZE)
        tab.open(page.as_uri())
        words, complete = tab.run(COMPLETE)
    return words / 1000.0, complete / 1000.0


def frames(browser: HeadlessBrowser, page: Path, together: bool, seconds: float) -> float:
    """Frames per second of a page that plays."""
    with browser.tab(HeadlessPage) as tab:
        tab.size(*SIZE)
        tab.open(page.as_uri())
        tab.run(COMPLETE)
        if together:
            tab.run("replays[0].stage.gather(true)")
        tab.run(f"{FRAMES}(1000)")
        return float(tab.run(f"{FRAMES}({1000.0 * seconds})"))


def told(values: Sequence[float], form: str) -> str:
    """Median, and from where to where in brackets."""
    return f"{statistics.median(values):{form}} ({min(values):{form}} to {max(values):{form}})"


def measured(versions: Mapping[str, Path], repeats: int, seconds: float) -> dict[str, list[str]]:
    """Rows of the two tables; versions take turns, so that a busy minute is one of all of them."""
    opened: dict[tuple[str, str], list[tuple[float, float]]] = {}
    played: dict[tuple[str, tuple[str, bool]], list[float]] = {}
    with headless_browser() as browser:
        opening(browser, next(iter(versions.values())) / "player.html")  # the browser's own start
        for _ in range(repeats):
            for version, folder in versions.items():
                for name in OPENED:
                    opened.setdefault((version, name), []).append(opening(browser, folder / f"{name}.html"))
                for page, together in PLAYED:
                    rate = frames(browser, folder / f"{page}.html", together, seconds)
                    played.setdefault((version, (page, together)), []).append(rate)
    rows: dict[str, list[str]] = {"viewer-open": [], "viewer-frames": []}
    for (version, name), both in opened.items():
        whole, empty = (statistics.median(x for _, x in opened[version, each]) for each in (name, "empty"))
        size = (versions[version] / f"{name}.html").stat().st_size / 1e6
        cells = [
            OPENED[name] + version,
            f"{size:.2f}",
            told([x for x, _ in both], ".2f"),
            told([x for _, x in both], ".2f"),
        ]
        rows["viewer-open"].append(f"| {' | '.join(cells)} | {whole / empty:.1f} |")
    for (version, key), rates in played.items():
        one = statistics.median(played[version, ("one", False)])
        cells = [PLAYED[key] + version, told(rates, ".1f"), f"{one / statistics.median(rates):.2f}"]
        rows["viewer-frames"].append(f"| {' | '.join(cells)} |")
    return rows


HEADERS = {
    "viewer-open": (
        "| page | MB | first words, s | complete, s | over the empty page |",
        "| --- | ---: | ---: | ---: | ---: |",
    ),
    "viewer-frames": ("| what plays | frames per second | time of a frame over one UR5's |", "| --- | ---: | ---: |"),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--result", type=Path, help="of `asmc-pin compare demo`; else it is run here")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=6.0, help="of each film")
    parser.add_argument("--keep", type=Path, help="where to leave the pages")
    parser.add_argument("--against", type=Path, help="pages that another version left there")
    parser.add_argument("--readme", action="store_true", help="replace the tables of benchmarks/README.md")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        result = options.result or compare(load_experiment("demo"), out=Path(scratch) / "demo").out
        make_pages(load_result(result), folder.resolve())
        versions = {"": folder.resolve()}
        if options.against is not None:
            versions[", other version"] = options.against.resolve()
        rows = measured(versions, options.repeats, options.seconds)
    text = README.read_text(encoding="utf-8")
    for table, lines in rows.items():
        made = "\n".join([*HEADERS[table], *lines])
        print(f"\n{made}")
        text = re.sub(
            rf"(<!-- from here: {table} -->\n).*?(<!-- to here: {table} -->)",
            lambda match, made=made: f"{match[1]}{made}\n{match[2]}",
            text,
            flags=re.DOTALL,
        )
    if options.readme:
        write_whole(README, text)


if __name__ == "__main__":
    main()
