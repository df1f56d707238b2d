"""The package's headless Chromium as a person uses it: keys, clicks, what the console says, pictures as arrays."""

from __future__ import annotations

import atexit
import base64
import io
import json
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import needs
import numpy as np
from PIL import Image

from asmc_pin.viewer.film.headless_browser import HeadlessBrowser, HeadlessPage, headless_browser

TICK = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
"""Until what was asked for is drawn."""


class Page(HeadlessPage):
    """A page; `messages` and `requests` hold what the console said and what was fetched."""

    def __init__(self, socket: Any) -> None:
        super().__init__(socket)
        self.messages: list[str] = []
        self.requests: list[str] = []
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def heard(self, event: dict[str, Any]) -> None:
        method, parameters = event.get("method", ""), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = parameters["exceptionDetails"]
            self.messages.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled":
            said = " ".join(
                str(argument.get("value", argument.get("description", ""))) for argument in parameters["args"]
            )
            self.messages.append(f"{parameters['type']}: {said}")
        elif method == "Log.entryAdded":
            self.messages.append(f"{parameters['entry']['level']}: {parameters['entry']['text']}")
        elif method == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])

    def open(self, url: str) -> None:
        self.messages.clear()
        self.requests.clear()
        super().open(url)

    def key(self, key: str, code: str) -> None:
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code, text=key if len(key) == 1 else "")

    def click(self, selector: str) -> None:
        x, y = self.run(
            f"(() => {{ const r = document.querySelector({json.dumps(selector)}).getBoundingClientRect();"
            " return [r.x + r.width / 2, r.y + r.height / 2]; })()"
        )
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def pixels(self) -> np.ndarray[Any, np.dtype[np.uint8]]:
        """What the page shows, shape (height, width, 3)."""
        return np.asarray(Image.open(io.BytesIO(self.picture())).convert("RGB"))

    def until(self, condition: str) -> None:
        """Wait until a JavaScript expression is true."""
        self.run(
            f"new Promise((done) => {{ const look = () => ({condition}) ? done() : setTimeout(look, 20); look(); }})"
        )

    def pdf(self) -> bytes:
        """What a printer gets, on A4."""
        return base64.b64decode(self.call("Page.printToPDF", paperWidth=8.27, paperHeight=11.69)["data"])


class Browser:
    """The running Chromium that all tests of a process share: each opens pages of its own."""

    def __init__(self, running: HeadlessBrowser) -> None:
        self.running = running

    @contextmanager
    def page(self, width: int = 1000, height: int = 700, *, dark: bool = False) -> Iterator[Page]:
        with self.running.tab(Page) as page:
            page.size(width, height, dark=dark)
            yield page


@cache
def shared_browser() -> Browser:
    """Started once for all tests of a process; without a Chromium the test is skipped."""
    needs.program("browser")
    running = headless_browser()
    atexit.register(running.__exit__, None, None, None)
    return Browser(running.__enter__())


def save(picture: np.ndarray[Any, np.dtype[np.uint8]], path: str | Path) -> None:
    Image.fromarray(picture).save(path)
