"""`seat-gear simulate`: how far it is, on standard error, and only there."""

import io
import json
import sys

import pytest

from seat_gear_dynamics.commands import main

ASKED = ["simulate", "--frequency", "1.3", "--load", "600", "--transient", "150", "--periods", "100"]


class Terminal(io.StringIO):
    """A standard error that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("quiet", [False, True])
def test_a_terminal_sees_the_mesh_periods_and_none_with_json(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], quiet: bool
) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    assert main([*ASKED, *(["--json"] if quiet else [])]) == 0
    said = capsys.readouterr().out
    if quiet:
        assert stream.getvalue() == ""
        assert json.loads(said)["frequency"] == 1.3
    else:
        assert "mesh periods" in stream.getvalue()
        assert "250/250" in stream.getvalue()
        assert said.startswith("Ω = 1.3000")


def test_a_pipe_sees_nothing_of_a_short_run(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(ASKED) == 0
    assert capsys.readouterr().err == ""
