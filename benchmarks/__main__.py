"""`python -m benchmarks`: run the benchmarks, print one JSON object, and say on stderr what changed.

Nothing here fails for being slow: the exit code is 1 where a benchmark is broken, and 0 else.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from benchmarks import guard, machine, suite
from benchmarks.ratio import Findings, Ratio


def main(words: list[str] | None = None) -> int:
    """Run what the command line asks for; return the exit code."""
    parser = _parser()
    arguments = parser.parse_args(words)
    form = "short" if arguments.short else "full"
    names = arguments.only or (suite.SHORT if arguments.short else suite.FULL)
    described = machine.description()
    found, broken = suite.run(names, short=arguments.short, progress=_tell)
    ratios = suite.pooled([guard.ratios_of(found), *(_again(form, names) for _ in range(arguments.times - 1))])
    path = guard.record_path(form, arguments.records)
    changes, lines = guard.report(described, ratios, guard.read_record(path))
    for line in lines:
        _tell(line)
    if arguments.record and not broken:
        _record(path, described, ratios)
    if arguments.plot is not None and "cost" in found:
        _draw(found["cost"], arguments.plot)
    text = json.dumps(_report(form, described, found, broken, ratios, changes), indent=1)
    print(text)
    if arguments.output is not None:
        arguments.output.write_text(text + "\n", encoding="utf-8")
    return 1 if broken else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--short", action="store_true", help="the short form, as CI runs it: below a minute")
    parser.add_argument("--only", nargs="+", choices=suite.FULL, metavar="NAME", help=f"of {', '.join(suite.FULL)}")
    parser.add_argument("--times", type=int, default=1, metavar="N", help="run in N processes, one after the other")
    parser.add_argument("--record", action="store_true", help="keep the ratios as what later runs compare with")
    parser.add_argument("--records", type=Path, default=guard.FOLDER, metavar="FOLDER", help="where records stand")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the cost curves into this file")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the JSON object to this file too")
    return parser


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _again(form: str, names: Any) -> dict[str, Ratio]:
    """Return the ratios of one more run, in a process of its own."""
    command = [sys.executable, "-m", "benchmarks", *(["--short"] if form == "short" else []), "--only", *names]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True)
    return {name: Ratio.from_dict(one) for name, one in json.loads(done.stdout)["ratios"].items()}


def _record(path: Path, described: dict[str, Any], ratios: dict[str, Ratio]) -> None:
    """Record the ratios; those of benchmarks that did not run now stay as they were recorded."""
    before = guard.read_record(path)
    measured = {name.partition(".")[0] for name in ratios}
    kept = {} if before is None else {n: r for n, r in before[1].items() if n.partition(".")[0] not in measured}
    guard.write_record(path, described, kept | ratios)
    _tell(f"recorded in {path}")


def _draw(found: Findings, path: Path) -> None:
    from benchmarks.cost import draw

    draw(found.figures, path)
    _tell(f"drawn into {path}")


def _report(
    form: str,
    described: dict[str, Any],
    found: dict[str, Findings],
    broken: dict[str, str],
    ratios: dict[str, Ratio],
    changes: list[guard.Change],
) -> dict[str, Any]:
    return {
        "form": form,
        "machine": described,
        "figures": {name: one.figures for name, one in found.items()},
        "skipped": {name: one.skipped for name, one in found.items() if one.skipped},
        "ratios": {name: ratio.as_dict() for name, ratio in ratios.items()},
        "missed": [name for name, ratio in ratios.items() if ratio.reached is False],
        "changes": [change.as_dict() for change in changes],
        "broken": broken,
    }


if __name__ == "__main__":
    sys.exit(main())
