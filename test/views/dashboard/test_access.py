"""Who is let in: host names, origins, tokens."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seat_gear_dynamics.views.dashboard.access import Access, AccessError, is_loopback

TOKEN = "a-token-that-is-long-enough"


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.9.1", "::1", "localhost", "LOCALHOST"])
def test_loopback(host: str) -> None:
    assert is_loopback(host)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "10.0.0.1", "bench", "localhost.example.org", ""])
def test_not_loopback(host: str) -> None:
    assert not is_loopback(host)


@pytest.mark.parametrize(
    "header", ["127.0.0.1:8642", "localhost:8642", "localhost", "[::1]:8642", "LocalHost:1", "localhost."]
)
def test_names_of_this_machine_are_ours(header: str) -> None:
    assert Access("127.0.0.1").host_is_ours(header)


@pytest.mark.parametrize(
    "header",
    [
        None,
        "",
        "evil.example:8642",
        "localhost.evil.example",
        "127.0.0.1.evil.example",
        "localhost:8642@evil.example",
        "evil.example#localhost",
        "10.0.0.7:8642",
        "localhost:8642:1",
        "localhost:",
        "localhost:999999",
        "[::1",
        "localhost\r\nX: y",
        "ｌocalhost",
        "0x7f.1",
    ],
)
def test_names_that_could_be_made_to_point_here_are_not(header: str | None) -> None:
    assert not Access("127.0.0.1").host_is_ours(header)


def test_elsewhere_literal_addresses_and_the_names_given_are_ours_and_no_others() -> None:
    access = Access("0.0.0.0", token=TOKEN, names=("bench", "bench.lab"))
    for header in ("192.168.1.7:8642", "[fe80::1]:8642", "bench:8642", "BENCH.lab", "localhost"):
        assert access.host_is_ours(header), header
    for header in ("evil.example:8642", "bench.evil.example", "notbench"):
        assert not access.host_is_ours(header), header


@pytest.mark.parametrize(
    ("origin", "ours"),
    [
        ("http://localhost:8642", True),
        ("https://localhost:8642", True),
        ("http://LOCALHOST:8642", True),
        ("http://localhost", False),
        ("http://localhost:1", False),
        ("http://127.0.0.1:8642", False),
        ("http://evil.example", False),
        ("http://user@localhost:8642", False),
        ("null", False),
        ("", False),
        (None, False),
        ("file://", False),
        ("ftp://localhost:8642", False),
        ("http://[::1", False),
    ],
)
def test_only_the_page_that_this_server_gave_out_may_talk(origin: str | None, ours: bool) -> None:
    assert Access("127.0.0.1").origin_is_ours(origin, "localhost:8642") is ours


@given(st.text(), st.text())
def test_no_origin_of_another_host_passes_and_nothing_raises(origin: str, host: str) -> None:
    access = Access("127.0.0.1")
    if access.origin_is_ours(origin, host):
        assert origin.lower().endswith(f"://{host.lower()}") or f"://{host.lower()}" in origin.lower()
    if access.host_is_ours(host):
        assert host.lower().startswith(("localhost", "127.", "[", "::"))


@pytest.mark.parametrize(
    ("host", "control", "token", "role"),
    [
        ("127.0.0.1", False, "", "watch"),
        ("127.0.0.1", True, "", "watch"),
        ("127.0.0.1", True, TOKEN, "control"),
        ("127.0.0.1", True, "wrong" * 6, None),
        ("0.0.0.0", False, "", None),
        ("0.0.0.0", False, TOKEN, "watch"),
        ("0.0.0.0", True, TOKEN, "control"),
        ("0.0.0.0", True, TOKEN[:-1], None),
        ("0.0.0.0", True, TOKEN + "x", None),
        ("0.0.0.0", True, "ü" * 20, None),
    ],
)
def test_what_the_bearer_of_a_token_may_do(host: str, control: bool, token: str, role: str | None) -> None:
    assert Access(host, token=TOKEN, control=control).role(token) == role


def test_without_a_token_of_its_own_this_machine_looks_on_whatever_it_brings() -> None:
    assert Access("127.0.0.1").role("left over in a tab") == "watch"


@pytest.mark.parametrize(("host", "control"), [("0.0.0.0", False), ("bench", False), ("127.0.0.1", True)])
def test_no_token_is_refused_where_one_is_needed(host: str, control: bool) -> None:
    with pytest.raises(AccessError, match="needs a token"):
        Access(host, control=control)


@pytest.mark.parametrize("token", ["", "short", "x" * 15, "with\nline" * 3, "ümlaut" * 5])
def test_a_token_that_is_none_is_refused(token: str) -> None:
    with pytest.raises(AccessError, match="expected at least 16, printable ASCII"):
        Access("127.0.0.1", token=token)
