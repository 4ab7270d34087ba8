"""Every example of the docs: blocks are run page by page as a reader would, command lines are parsed."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import pytest

from docs.generate.commands import parsers

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
QUOTING = [*PAGES, ROOT / "bags" / "README.md", ROOT / "benchmarks" / "README.md", ROOT / "CONTRIBUTING.md"]
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LEFT_OUT = re.compile(r"# not run by the tests: (.+)")
REASONS = (
    "needs ROS 2 Jazzy",
    "a node runs until it is told to end",
    "nodes run until they are told to end",
    "it takes half a minute of an idle machine",
    "a week is long",
    "it makes the environment that they run in",
    "it is a setting for your shell",
    "the tutorial's run is the same",
    "it needs other machines",
    "it needs a bench's log",
    "a minute of an idle machine with the command below",
    "see above",
)
"""Why a block may be left out; a new reason is added here, for others to see."""


NOT_RUN = {
    r"seat-gear (bench|dashboard|monitor|record|simulator)\b": "runs until it is told to end; the tutorial has one",
    r"seat-gear (reproduce|quality|calibrate)\b": "takes minutes",
    r"seat-gear map .*--samples": "takes a minute",
    r"seat-gear analyze (LOG|bags/ramp)": "the tutorial analyses its own log, the guides others",
    r"seat-gear analyze bags/third_party_bench": "the guide to own signals does, without the model's sweep",
    r"seat-gear (sweep|map) .*--scheduler": "needs other machines",
    r"seat-gear \w+ .*([/=]|--system )my_|seat-gear .*--map": "needs a file of the reader's own",
}
"""Commands that stand indented in a page, and why they are not run; all others are."""
READERS = {
    "my_run_0.mcap": "bags/killed/killed_0.mcap",
    "my_run": "bags/killed",
    "old_bag": "bags/third_party_bench",
    "LOG": "bags/bench_dwell",
}
"""What readers have under these names."""


class Block(NamedTuple):
    """A block of code in a page."""

    language: str
    text: str

    @property
    def reason(self) -> str | None:
        """Why the block is not run, as it says itself."""
        found = LEFT_OUT.match(self.text)
        return found[1] if found else None


def blocks(page: Path) -> list[Block]:
    """Return the blocks of a page that are shell or Python, in order."""
    found = FENCE.findall(page.read_text(encoding="utf-8"))
    return [Block(language, text) for language, text in found if language in ("sh", "python")]


def runnable(page: Path) -> list[Block]:
    return [block for block in blocks(page) if block.reason is None]


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


WITH_EXAMPLES = [page for page in PAGES if runnable(page)]


def made(folder: Path) -> Path:
    """Return a folder with what a clone's root has for readers: the bags and the packaged description."""
    shutil.copytree(ROOT / "bags", folder / "bags")
    shutil.copytree(ROOT / "config", folder / "config")
    return folder


def terminal() -> dict[str, str]:
    """Return the environment in which `seat-gear` and `python` are those of the tests, without a display."""
    paths = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": paths, "MPLBACKEND": "agg"}


@pytest.fixture(scope="session")
def runs(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[dict[Path, Future[None]]]:
    """Run the chosen pages, two at a time in their order: most of what they start uses one core, or waits."""
    chosen = [item for item in request.session.items if "runs" in getattr(item, "fixturenames", ())]
    pages = [Path(str(item.callspec.params["page"])) for item in chosen if isinstance(item, pytest.Function)]
    with ThreadPoolExecutor(2) as pool:
        yield {page: pool.submit(run_page, page, made(tmp_path_factory.mktemp(page.stem))) for page in pages}
        pool.shutdown(wait=False, cancel_futures=True)


@pytest.mark.parametrize("page", WITH_EXAMPLES, ids=name)
def test_the_blocks_of_a_page_run_in_order(page: Path, runs: dict[Path, Future[None]]) -> None:
    runs[page].result()


def run_page(page: Path, place: Path) -> None:
    """Run the blocks of a page in their order; raises AssertionError with what the first that fails said."""
    # A domain of its own, so that a bench of this page is not heard by another test's; 1 to 100 are safe port ranges.
    environment = {**terminal(), "ROS_DOMAIN_ID": str(1 + PAGES.index(page) % 100)}
    for block in runnable(page):
        shell = ["bash", "-euo", "pipefail", "-c"] if block.language == "sh" else [sys.executable, "-c"]
        done = run([*shell, block.text], place, environment)
        assert done.returncode == 0, f"{block.text}\n{done.stdout}\n{done.stderr}"


def run(command: list[str], place: Path, environment: dict[str, str]) -> "subprocess.CompletedProcess[str]":
    # 280 s is below the suite's own limit: a block that hangs is then named with what it said.
    return subprocess.run(
        command, cwd=place, env=environment, capture_output=True, text=True, timeout=280, stdin=subprocess.DEVNULL
    )


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_a_block_that_is_left_out_says_why(page: Path) -> None:
    for block in blocks(page):
        assert block.reason is None or block.reason in REASONS, f"{block.reason!r} is no reason that {__file__} lists"
        assert "not run by the tests" not in block.text or block.reason, "the reason has to be the block's first line"


def test_every_reason_is_used() -> None:
    used = {block.reason for page in PAGES for block in blocks(page)}
    optional = {"it needs a bench's log"}
    assert set(REASONS) - optional <= used


def command_lines(page: Path) -> Iterator[str]:
    """Yield each `seat-gear` command in a page's code, fenced or indented: no pipes, and what is optional is given."""
    for line in page.read_text(encoding="utf-8").replace("\\\n", " ").splitlines():
        if re.match(r"( {4})?(\$ )?(exec )?seat-gear [a-z]", line):
            yield re.sub(r" \[(.+?)\]", r" \1", re.split(r" [|>&;] ?", line.strip().removeprefix("$ "))[0])


def indented(page: Path) -> list[str]:
    """Return the commands of a page that stand indented and can be run, with what a reader has in the names' places."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    found = [line.partition(" #")[0].strip() for line in text.splitlines() if line.startswith("    seat-gear ")]
    kept = [line for line in found if not any(re.match(pattern, line) for pattern in NOT_RUN)]
    return [re.sub(rf"\b(?<![/_])({'|'.join(READERS)})(?![/_])\b", lambda m: READERS[m[1]], line) for line in kept]


def once(pages: list[Path]) -> dict[str, list[str]]:
    """Return page -> its indented commands, each with the first page that has it."""
    first = {line: name(page) for page in reversed(pages) for line in indented(page)}
    found = {page: [line for line in first if first[line] == page] for page in first.values()}
    return dict(sorted(found.items()))


INDENTED = once(QUOTING)


@pytest.mark.parametrize("page", INDENTED)
def test_commands_that_stand_indented_run(page: str, tmp_path: Path) -> None:
    lines = INDENTED[page]
    # Each for itself: they are alternatives. Two at a time, for most of them use one core.
    with ThreadPoolExecutor(2) as pool:
        every = list(
            pool.map(lambda k: run(["bash", "-c", lines[k]], made(tmp_path / str(k)), terminal()), range(len(lines)))
        )
    for line, done in zip(lines, every, strict=True):
        # A replay ends with 1 where floating point differs from the build that recorded; it is no error.
        accepted = (0, 1) if " replay " in line else (0,)
        assert done.returncode in accepted, f"{line}\n{done.stdout}\n{done.stderr}"
        assert "error:" not in done.stderr, f"{line}\n{done.stderr}"


def test_commands_that_stand_indented_are_found() -> None:
    assert {"README.md", "docs/analysis.md", "docs/recovery.md", "bags/README.md"} <= set(INDENTED)
    assert "seat-gear replay bags/bench_dwell" in INDENTED["README.md"]


COMMAND_LINES = [(name(page), line) for page in QUOTING for line in command_lines(page)]


@pytest.mark.parametrize(("page", "line"), COMMAND_LINES, ids=lambda value: value)
def test_every_command_line_is_one_that_the_program_takes(page: str, line: str) -> None:
    _, command, *arguments = shlex.split(line, comments=True)
    parser = parsers()[command]
    if "--help" not in arguments:
        parser.parse_args(arguments)  # ends the program with argparse's own words where something is wrong


def test_the_pages_do_quote_commands() -> None:
    quoted = {shlex.split(line, comments=True)[1] for _, line in COMMAND_LINES}
    assert quoted >= set(parsers()) - {"quality", "completion"}, "a command without an example in the docs"
