"""`lemons lab` answers this machine only, and only with files of the lab."""

import gzip
import http.client
import resource
import signal
import socket
import subprocess
from contextlib import closing

import pytest
from visit import LEMONS, PATIENCE, missing


def test_only_this_machine_is_answered_and_only_with_files_of_the_lab(url: str) -> None:
    host = url.removeprefix("http://").rstrip("/")

    def ask(path: str, method: str = "GET", named: str | None = None) -> http.client.HTTPResponse:
        connection = http.client.HTTPConnection(host)
        connection.request(method, path, headers={"Host": named or host})
        response = connection.getresponse()
        response.read()
        return response

    page = ask("/?x=1")
    assert page.status == 200 and page.headers["Content-Type"].startswith("text/html")
    assert "frame-ancestors 'none'" in page.headers["Content-Security-Policy"]
    assert ask("/lemons_lab.wasm").headers["Content-Type"] == "application/wasm"
    assert ask("/", named=host.replace("127.0.0.1", "localhost")).status == 200
    for named in ("example.org", "127.0.0.1", "localhost:1"):
        assert ask("/", named=named).status == 403
    assert ask("/", method="POST").status == 405
    for path in ("/../Cargo.toml", "/binaries/linux64/../../lemons", "//etc/passwd", "/%2e%2e/lemons", "/nothing"):
        assert ask(path).status == 404, path


def test_files_come_compressed_where_the_browser_takes_that(url: str) -> None:
    host = url.removeprefix("http://").rstrip("/")

    def ask(path: str, takes: str) -> tuple[str | None, bytes]:
        connection = http.client.HTTPConnection(host)
        connection.request("GET", path, headers={"Host": host, "Accept-Encoding": takes})
        response = connection.getresponse()
        content = response.read()
        assert response.status == 200 and response.headers["Vary"] == "Accept-Encoding" and int(response.headers["Content-Length"]) == len(content)
        return response.headers["Content-Encoding"], content

    for path, share in (("/lemons_lab.wasm", 0.3), ("/page.js", 0.45), ("/style.css", 0.4)):
        coding, short = ask(path, "br, GZIP;q=0.8, deflate")
        plain, whole = ask(path, "gzip; q=0.0, identity")
        assert (coding, plain) == ("gzip", None) and len(short) < share * len(whole), (path, len(short), len(whole))
        assert gzip.decompress(short) == whole


@pytest.mark.parametrize("most", [16, 24, 40, 80])
def test_where_few_files_can_be_open_the_oldest_idle_connections_end(most: int) -> None:
    if not LEMONS.is_file():
        pytest.exit(missing(LEMONS), returncode=1)

    def few() -> None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))

    command = subprocess.Popen([LEMONS, "lab", "--no-browser"], stdout=subprocess.PIPE, text=True, preexec_fn=few)
    try:
        assert command.stdout
        host = command.stdout.readline().split()[4].rstrip(",/").removeprefix("http://")
        name, port = host.split(":")
        idle = [socket.create_connection((name, int(port)), timeout=PATIENCE) for _ in range(2 * most)]
        for _ in range(3):  # who asks is answered, and its connection takes no descriptor then
            with closing(http.client.HTTPConnection(host, timeout=PATIENCE)) as connection:
                connection.request("GET", "/", headers={"Host": host})
                assert connection.getresponse().read().startswith(b"<!doctype html>")
        assert idle[0].recv(1) == b""
        for connection in idle:
            connection.close()
        assert command.poll() is None
    finally:
        command.send_signal(signal.SIGTERM)
        assert command.wait(PATIENCE) == 0
