"""`lemons lab` answers this machine only, and only with files of the lab."""

import http.client


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
