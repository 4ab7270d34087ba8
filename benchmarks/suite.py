"""All benchmarks, one after the other; one that breaks does not take the others with it."""

from collections.abc import Callable, Sequence
from importlib import import_module
from time import perf_counter
from traceback import format_exc

from benchmarks.ratio import Findings, Ratio

FULL = ("core", "lanes", "peers", "studies", "memory", "start", "node", "cost")
"""In the order in which they run; the short ones first see an idle machine soonest."""
SHORT = ("core", "lanes", "peers", "studies", "start")
_MODULES = {"peers": "peers.measure"}

Progress = Callable[[str], None]


def run(names: Sequence[str], *, short: bool, progress: Progress) -> tuple[dict[str, Findings], dict[str, str]]:
    """Run the benchmarks named; return what they found, and the traceback of each that broke."""
    found: dict[str, Findings] = {}
    broken: dict[str, str] = {}
    for name in names:
        begin = perf_counter()
        try:
            module = import_module(f"benchmarks.{_MODULES.get(name, name)}")
            found[name] = module.measure(short=short, progress=progress)
        except Exception:  # whatever it is, the others are to be measured still
            broken[name] = format_exc()
            progress(f"{name} is broken: {broken[name].strip().splitlines()[-1]}")
        else:
            found[name].figures["took_seconds"] = perf_counter() - begin
    return found, broken


def pooled(runs: Sequence[dict[str, Ratio]]) -> dict[str, Ratio]:
    """Return each ratio with the repeats of all runs, which may differ by more than those within one run do."""
    together: dict[str, Ratio] = {}
    for one in runs:
        for name, ratio in one.items():
            before = together[name].values if name in together else ()
            together[name] = Ratio((*before, *ratio.values), ratio.meaning, ratio.better, ratio.reach)
    return together
