"""A headless Chromium with one page: opened, sized, asked, photographed."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import tempfile
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

from asmc_pin.errors import MissingDependencyError, ParameterError

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
_FLAGS = (
    *("--headless", "--no-first-run", "--disable-sync", "--disable-background-networking", "--hide-scrollbars"),
    *("--disable-component-update", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--remote-debugging-port=0", "--remote-allow-origins=*"),
)
_PATIENCE = 300.0
"""s; a software renderer on a busy machine takes its time."""
_FAREWELL = 30.0
"""s that a browser has to end by itself before it is ended."""


class HeadlessPage:
    """One page of a browser."""

    def __init__(self, socket: Any) -> None:
        self._socket, self._count = socket, 0

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """A command of the DevTools protocol, and its result.

        Raises:
            RuntimeError: The browser refuses it.
        """
        self._count += 1
        self._socket.send(json.dumps({"id": self._count, "method": method, "params": parameters}))
        while True:
            answer = json.loads(self._socket.recv())
            if answer.get("id") != self._count:
                self.heard(answer)
            else:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error'].get('message', 'refused')}")
                return dict(answer["result"])

    def heard(self, event: dict[str, Any]) -> None:
        """What the browser tells unasked; nothing here."""

    def run(self, expression: str) -> Any:
        """The value of a JavaScript expression; a promise is waited for.

        Raises:
            RuntimeError: It throws.
        """
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            thrown = details.get("exception", {}).get("description", details.get("text", "the page failed"))
            raise RuntimeError(str(thrown))
        return answer["result"].get("value")

    def size(self, width: int, height: int, *, dark: bool = False) -> None:
        """So many pixels, and whether the reader's system is set to dark."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])

    def open(self, url: str) -> None:
        """Show a page."""
        self.call("Page.navigate", url=url)
        self.run("new Promise((done) => document.readyState === 'complete' ? done() : addEventListener('load', done))")

    def picture(self) -> bytes:
        """What it shows, as PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])


_Page = TypeVar("_Page", bound=HeadlessPage)


class HeadlessBrowser:
    """A running browser, which opens pages.

    Attributes:
        port: Where it is spoken to, on 127.0.0.1.
        process: The browser's own.
    """

    def __init__(self, process: subprocess.Popen[bytes], port: int) -> None:
        self.process, self.port = process, port

    @contextmanager
    def tab(self, kind: Callable[[Any], _Page]) -> Iterator[_Page]:
        """A page, closed afterwards; `kind` makes it of its socket."""
        import websocket

        request = urllib.request.Request(f"http://127.0.0.1:{self.port}/json/new?about:blank", method="PUT")
        with urllib.request.urlopen(request, timeout=_PATIENCE) as answer:
            address = json.load(answer)["webSocketDebuggerUrl"]
        socket = websocket.create_connection(address, timeout=_PATIENCE, max_size=None)
        try:
            page = kind(socket)
            yield page
            page.call("Page.close")
        finally:
            socket.close()


@contextmanager
def headless_browser() -> Iterator[HeadlessBrowser]:
    """A Chromium with a fresh profile, both gone afterwards.

    Raises:
        ParameterError: This machine has no Chromium.
        MissingDependencyError: websocket-client is not installed.
    """
    program = browser_program()
    if find_spec("websocket") is None:
        raise MissingDependencyError("websocket-client", "film", "pictures of a replay")
    with tempfile.TemporaryDirectory(prefix="asmc-pin-film-", ignore_cleanup_errors=True) as profile:
        # A process that runs as root has no sandbox, as in a container.
        sandbox = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
        process = subprocess.Popen(
            [program, *_FLAGS, *sandbox, f"--user-data-dir={profile}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            yield HeadlessBrowser(process, _port(process, Path(profile)))
        finally:
            process.terminate()
            try:
                process.wait(timeout=_FAREWELL)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


@contextmanager
def headless_page() -> Iterator[HeadlessPage]:
    """One page in a browser of its own; see `headless_browser` for what is raised."""
    with headless_browser() as browser, browser.tab(HeadlessPage) as page:
        yield page


def browser_program() -> str:
    """The path of a Chromium: what CHROMIUM names, or the first that is found.

    Raises:
        ParameterError: There is none.
    """
    named = os.environ.get("CHROMIUM")
    found = shutil.which(named) if named else next(filter(None, map(shutil.which, _NAMES)), None)
    if found is None:
        tried = f"CHROMIUM names '{named}', which is no program" if named else f"none of {', '.join(_NAMES)} is here"
        raise ParameterError(
            "view", f"pictures are taken by a Chromium, and {tried}; install one, or name it: CHROMIUM=…"
        )
    return found


def _port(process: subprocess.Popen[bytes], profile: Path) -> int:
    import time

    written, until = profile / "DevToolsActivePort", time.monotonic() + _PATIENCE
    while time.monotonic() < until:
        if process.poll() is not None:
            raise ParameterError("view", f"the browser ended at once with status {process.returncode}")
        lines = written.read_text(encoding="ascii").split() if written.is_file() else []
        if lines:
            return int(lines[0])
        time.sleep(0.05)
    raise ParameterError("view", "the browser does not answer")
