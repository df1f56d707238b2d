"""Shows a page in the browser of this machine, and to no other machine."""

from __future__ import annotations

import sys
import webbrowser
from collections.abc import Callable, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TypeAlias

from asmc_pin.errors import ParameterError

Answers: TypeAlias = Mapping[str, Callable[[str], str]]
"""Path to what makes JSON text of a query; a `ParameterError` of it is the asker's."""

ADDRESS = "127.0.0.1"


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: object, client_address: object) -> None:
        """A browser that leaves is no error; anything else ends its thread as an exception does."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            raise


def serve(directory: str | Path, port: int = 0, *, open_browser: bool = False) -> None:
    """Replay a result until Ctrl-C is pressed.

    Args:
        directory: Folder of the result.
        port: On 127.0.0.1; 0 takes a free one.
        open_browser: Open the page in the user's browser as well.

    Raises:
        ResultError: The folder is no result, or its arm cannot be drawn.
        ParameterError: The port is taken.
    """
    from asmc_pin.results.result_folder import load_result
    from asmc_pin.viewer.result_replay import replay_html

    serve_page(replay_html(load_result(directory)), port, open_browser=open_browser)


def serve_page(
    html: str | Callable[[], str],
    port: int = 0,
    *,
    what: str = "replay",
    open_browser: bool = False,
    answers: Answers | None = None,
) -> None:
    """Serve a page, see `make_server`, until Ctrl-C is pressed.

    Raises:
        ParameterError: The port is taken.
    """
    with make_server(html, port, answers) as server:
        url = f"http://{ADDRESS}:{server.server_port}/"
        print(f"{what}: {url} (Ctrl-C ends it)", flush=True)
        if open_browser:
            webbrowser.open(url)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print()


def make_server(html: str | Callable[[], str], port: int = 0, answers: Answers | None = None) -> ThreadingHTTPServer:
    """A server of one page on 127.0.0.1, not yet serving.

    Args:
        html: The page, or what makes it anew whenever it is asked for.
        port: 0 takes a free one.
        answers: What the page may ask.

    Raises:
        ParameterError: The port is taken, or not for us to take.
    """
    fixed = None if callable(html) else html.encode()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self._answer(body=True)

        def do_HEAD(self) -> None:
            self._answer(body=False)

        def _answer(self, *, body: bool) -> None:
            # Another name in Host is a foreign page that had its name point here, to read what it should not.
            host = self.headers.get("Host", "").partition(":")[0]  # without a port where it is 80
            if host.lower() not in (ADDRESS, "localhost"):
                self.send_error(HTTPStatus.FORBIDDEN, f"open http://{ADDRESS}:{self.server.server_port}/")  # type: ignore[attr-defined]
                return
            path, _, query = self.path.partition("?")
            if path == "/":
                content = html().encode() if callable(html) else fixed
                assert content is not None
                self._send(content, "text/html", body=body)
            elif path in (answers or {}):
                try:
                    answer = (answers or {})[path](query).encode()
                except ParameterError as error:
                    self.send_error(HTTPStatus.BAD_REQUEST, explain=str(error))
                else:
                    self._send(answer, "application/json", body=body)
            else:
                self.send_error(HTTPStatus.NOT_FOUND)

        def _send(self, content: bytes, kind: str, *, body: bool) -> None:
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", f"{kind}; charset=utf-8")
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.send_header("X-Content-Type-Options", "nosniff")
            self.end_headers()
            if body:
                self.wfile.write(content)

        def log_message(self, format: str, *args: object) -> None:
            """Nothing: the terminal is the user's."""

    try:
        return _Server((ADDRESS, port), Handler)
    except OSError as error:
        raise ParameterError("port", f"{port} cannot be used ({error.strerror}); 0 takes a free one") from error
