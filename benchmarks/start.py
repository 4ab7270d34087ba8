"""How long people wait before anything begins: `python -m benchmarks.start` prints one JSON object.

`--help` of the command line and of some commands, as processes of their own, beside the bare interpreter that each of
them has to start as well; the shortest of several counts for the seconds, meant to be below 0.3.
"""

import json
import subprocess
import sys
from collections.abc import Callable, Sequence

from benchmarks.ratio import Findings, Ratio
from benchmarks.timing import seconds_of

HELP = "from seat_gear_dynamics.commands import main; import sys; sys.exit(main(sys.argv[1:]))"
COMMANDS: dict[str, tuple[str, ...]] = {
    "help": ("--help",),
    "simulate_help": ("simulate", "--help"),
    "sweep_help": ("sweep", "--help"),
    "bench_help": ("bench", "--help"),
}
REACH = 0.3
REPEATS = 7


def measure(*, short: bool = False, progress: Callable[[str], None] | None = None) -> Findings:
    """Measure the waits; `short` takes `seat-gear --help` only."""
    if progress is not None:
        progress("start of the command line")
    asked = {"help": COMMANDS["help"]} if short else COMMANDS
    times: dict[str, list[float]] = {name: [] for name in ("bare", *asked)}
    _run("pass")
    _run(HELP, "--help")  # from then on the files are in memory
    for _ in range(REPEATS):
        times["bare"].append(seconds_of(lambda: _run("pass")))
        for name, words in asked.items():
            times[name].append(_timed(words))
    ratios = {}
    for name in asked:
        seconds, bare = times[name], times["bare"]
        ratios[f"{name}_seconds"] = Ratio(tuple(seconds), f"seconds of {name}", better="lower", reach=REACH)
        ratios[f"{name}_over_bare"] = Ratio(
            tuple(a / b for a, b in zip(seconds, bare, strict=True)), "over the bare interpreter", better="lower"
        )
    return Findings({name: {"seconds": min(found)} for name, found in times.items()}, ratios)


def _timed(words: Sequence[str]) -> float:
    return seconds_of(lambda: _run(HELP, *words))


def _run(program: str, *words: str) -> None:
    subprocess.run([sys.executable, "-c", program, *words], stdout=subprocess.DEVNULL, check=True)


if __name__ == "__main__":
    print(json.dumps(measure().as_dict(), indent=1))
