"""A still at one time, or a film of all of it, from the page that replays a result."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from asmc_pin.disk.files import write_whole
from asmc_pin.errors import MissingDependencyError, ParameterError
from asmc_pin.viewer.film.headless_browser import HeadlessPage, headless_page

SIZE = (1280, 720)
"""Pixels of a picture."""

FPS = 30.0
"""Frames of a film per second."""

BARE = (
    "(() => { const r = replays[0]; r.pause(); document.querySelector('.replay-controls').style.display = 'none';"
    " document.querySelector('header').style.display = 'none'; r.loop.checked = false;"
    " return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => {"
    " r.stage.turned = false; r.stage.viewer.set_3d_pane_size(); r.stage.arrange(); r.stage.resetView();"
    " done(r.duration); }))); })()"
)
"""Leaves of the page the scene with its labels, and says how long the motion is."""


def take_still(html: str, path: str | Path, time: float = 0.0) -> None:
    """Write what a replay shows at a time as PNG.

    Args:
        html: A page of `asmc_pin.viewer.replay_page`.
        path: Where to.
        time: s; within the motion.

    Raises:
        ParameterError: No browser, or a time outside the motion.
        MissingDependencyError: A package of the extra ``film`` is not installed.
        ResultError: It cannot be written.
    """
    with _scene(html) as (page, duration):
        if not 0.0 <= time <= duration:
            raise ParameterError("time", f"{time:g} s given, 0 to {duration:g} s expected: the motion is that long")
        write_whole(path, _at(page, time))


def take_film(
    html: str, path: str | Path, *, fps: float = FPS, progress: Callable[[float], None] | None = None
) -> None:
    """Write a replay as MP4 (H.264), in its own time.

    Args:
        html: As for `take_still`.
        path: Where to.
        fps: Frames per second.
        progress: Called with the share that is done.

    Raises:
        ParameterError: No browser, or nothing moves.
        MissingDependencyError: A package of the extra ``film`` is not installed.
        ResultError: It cannot be written.
    """
    try:
        import av
    except ImportError:
        raise MissingDependencyError("av", "film", "films of a replay") from None
    from PIL import Image

    with _scene(html) as (page, duration):
        if not duration > 0.0:
            raise ParameterError("mp4", "nothing moves in this result; --png makes a still of it")
        count = max(2, round(duration * fps) + 1)
        film = io.BytesIO()
        with av.open(film, "w", format="mp4") as container:
            stream = container.add_stream("libx264", rate=round(fps))
            stream.width, stream.height = SIZE
            stream.pix_fmt = "yuv420p"
            for k in range(count):
                image = Image.open(io.BytesIO(_at(page, min(k / fps, duration)))).convert("RGB")
                container.mux(stream.encode(av.VideoFrame.from_ndarray(np.asarray(image), format="rgb24")))
                if progress is not None:
                    progress((k + 1) / count)
            container.mux(stream.encode())
        write_whole(path, film.getvalue())


@contextmanager
def _scene(html: str) -> Iterator[tuple[HeadlessPage, float]]:
    """The replay alone on a page, and how long it is, s."""
    with tempfile.TemporaryDirectory(prefix="asmc-pin-film-") as folder, headless_page() as page:
        file = Path(folder) / "replay.html"
        file.write_text(html, encoding="utf-8")
        page.size(*SIZE)
        page.open(f"{file.as_uri()}#t=0")
        if not page.run("window.replays?.length > 0"):
            said = page.run("document.querySelector('.replay-message')?.textContent ?? ''")
            raise ParameterError("view", f"the browser does not show the motion: {said or 'it has no WebGL'}")
        yield page, float(page.run(BARE))


def _at(page: HeadlessPage, time: float) -> bytes:
    page.run(
        f"(() => {{ replays[0].seek({time!r}); return new Promise((done) =>"
        " requestAnimationFrame(() => requestAnimationFrame(done))); })()"
    )
    return page.picture()
