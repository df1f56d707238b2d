"""The replay is served to this machine alone, and ends with Ctrl-C."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Iterator
from http.client import HTTPConnection
from http.server import ThreadingHTTPServer
from pathlib import Path

import psutil
import pytest
from viewer_cases import awkward_result

from asmc_pin.errors import ParameterError, ResultError
from asmc_pin.viewer import make_server, serve

PAGE = "<!doctype html><p>Schlüssel ‖I − M⁻¹M̄‖</p>"


@pytest.fixture
def server() -> Iterator[ThreadingHTTPServer]:
    with make_server(PAGE) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        yield server
        server.shutdown()
        thread.join()


def get(
    server: ThreadingHTTPServer, path: str = "/", method: str = "GET", host: str | None = None
) -> tuple[int, bytes]:
    connection = HTTPConnection("127.0.0.1", server.server_port, timeout=60)
    connection.request(method, path, headers={"Host": host} if host else {})
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer.status, content


def test_the_page_is_served_and_nothing_else(server: ThreadingHTTPServer) -> None:
    assert get(server) == (200, PAGE.encode())
    assert get(server, "/?reload") == (200, PAGE.encode())
    assert get(server, method="HEAD") == (200, b"")
    for path in ("/../../etc/passwd", "/trajectories.nc", "/index.html"):
        assert get(server, path)[0] == 404


def test_only_this_machine_is_answered(server: ThreadingHTTPServer) -> None:
    assert server.server_address[0] == "127.0.0.1"
    # 127.0.0.2 is this machine as well, but another address: a server on all interfaces would answer there.
    with socket.socket() as other:
        other.settimeout(60)
        assert other.connect_ex(("127.0.0.2", server.server_port)) != 0


def test_of_all_ports_that_this_process_listens_on_none_is_seen_from_outside(server: ThreadingHTTPServer) -> None:
    listening = [at.laddr for at in psutil.Process().net_connections("inet") if at.status == psutil.CONN_LISTEN]
    assert server.server_port in {at.port for at in listening}
    assert {at.ip for at in listening} == {"127.0.0.1"}


def test_a_foreign_name_for_this_machine_is_refused(server: ThreadingHTTPServer) -> None:
    assert get(server, host=f"attacker.example:{server.server_port}")[0] == 403
    assert get(server, host=f"localhost:{server.server_port}")[0] == 200


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", "LOCALHOST"])
def test_at_port_80_a_browser_names_no_port(server: ThreadingHTTPServer, name: str) -> None:
    assert get(server, host=name)[0] == 200


@pytest.mark.parametrize("name", ["attacker.example", "127.0.0.1.attacker.example", "[::1]:80", ""])
def test_no_other_name_is_answered_without_a_port_either(server: ThreadingHTTPServer, name: str) -> None:
    with socket.create_connection(server.server_address[:2], timeout=60) as connection:
        connection.sendall(f"GET / HTTP/1.1\r\nHost: {name}\r\nConnection: close\r\n\r\n".encode())
        assert connection.recv(64).split()[1] == b"403"


def test_a_browser_that_leaves_prints_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    with make_server(PAGE * 2_000_000) as server:
        server.daemon_threads = False  # so that to close it waits for all answers
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        for sent in (b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n", b"GET / HT", b""):
            connection = socket.create_connection(server.server_address[:2], timeout=60)
            connection.sendall(sent)
            # Reset, as a browser does that is closed at once.
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            connection.close()
        assert get(server, method="HEAD") == (200, b"")
        server.shutdown()
        thread.join()
    assert capfd.readouterr() == ("", "")


def test_any_other_trouble_in_a_request_is_a_fault(server: ThreadingHTTPServer) -> None:
    try:
        raise ZeroDivisionError
    except ZeroDivisionError:
        with pytest.raises(ZeroDivisionError):
            server.handle_error(None, None)  # type: ignore[arg-type]


def test_a_port_in_use_is_told(server: ThreadingHTTPServer) -> None:
    with pytest.raises(ParameterError, match=f"port: {server.server_port} cannot be used .*; 0 takes a free one"):
        make_server(PAGE, server.server_port)


def test_serving_prints_the_address_and_ends_with_ctrl_c(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    served: list[int] = []

    def interrupted(self: ThreadingHTTPServer, poll_interval: float = 0.5) -> None:
        served.append(self.server_port)
        raise KeyboardInterrupt

    monkeypatch.setattr(ThreadingHTTPServer, "serve_forever", interrupted)
    serve(awkward_result().path)
    assert f"http://127.0.0.1:{served[0]}/" in capsys.readouterr().out


def test_a_folder_that_is_no_result_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ResultError, match="is not a result"):
        serve(tmp_path)
