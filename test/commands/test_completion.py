"""Shell completion: a real bash asks the program and gets commands, options, choices and file names."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from seat_gear_dynamics.commands import COMMANDS, main
from seat_gear_dynamics.commands.completion import SHELLS

# bash fills these before it calls a completion function; the function leaves its answer in COMPREPLY.
_ASK = """
eval "$(seat-gear completion bash)"
COMP_WORDS=($1); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); COMP_LINE="$1"; COMP_POINT=${#COMP_LINE}; COMP_TYPE=9
[[ "$1" == *" " ]] && { COMP_WORDS+=(""); COMP_CWORD=$((COMP_CWORD + 1)); }
declare -p COMP_WORDS >/dev/null
$(complete -p seat-gear | sed 's/.*-F \\([^ ]*\\).*/\\1/') seat-gear "${COMP_WORDS[COMP_CWORD]}" ""
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture
def ask(tmp_path: Path) -> Callable[[str], set[str]]:
    program = tmp_path / "bin" / "seat-gear"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m seat_gear_dynamics "$@"\n')
    program.chmod(0o755)
    (tmp_path / "my_train.yaml").touch()

    def answer(line: str) -> set[str]:
        path = f"{program.parent}:{os.environ['PATH']}"
        environment = {**os.environ, "PATH": path, "PYTHONPATH": str(Path(__file__).parents[2])}
        done = subprocess.run(
            ["bash", "-c", _ASK, "bash", line],
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env=environment,
            check=True,
            timeout=120,
        )
        return {word.strip() for word in done.stdout.split("\n")} - {""}

    return answer


def test_bash_completes_commands_options_choices_and_files(ask: Callable[[str], set[str]]) -> None:
    assert set(COMMANDS) <= ask("seat-gear ")
    assert ask("seat-gear rec") == {"record", "recover"}
    assert "--frequency" in ask("seat-gear simulate --fr")
    assert ask("seat-gear sweep --direction u") == {"up"}
    assert "my_train.yaml" in ask("seat-gear stiffness --system my_")


@pytest.mark.parametrize("shell", SHELLS)
def test_the_code_names_the_program(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["shell"] == shell
    assert "seat-gear" in printed["code"]


def test_another_shell_is_wrong_use() -> None:
    with pytest.raises(SystemExit) as ended:
        main(["completion", "cmd"])
    assert ended.value.code == 2
