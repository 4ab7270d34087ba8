"""`seat-gear analyze`: the report of a recorded run."""

import argparse
import json
from pathlib import Path
from typing import Any

from seat_gear_dynamics.commands.texts import Texts

TEXTS = {
    "analyze": Texts(
        "report of a recorded run: picture and summary", "seat-gear analyze bags/third_party_bench --output report"
    )
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("log", metavar="LOG", type=Path, help="bag directory or .mcap file")
    parser.add_argument("--output", metavar="DIR", type=Path, help="where the report goes (default: the log's folder)")


def run(arguments: argparse.Namespace) -> int:
    """Read the log, draw it, print its summary."""
    values, lines = report(arguments.log, arguments.output, arguments.system)
    print(json.dumps(values) if arguments.json else "\n".join(lines))
    return 0


def report(log: Path, output: Path | None, system: str | None) -> tuple[dict[str, Any], list[str]]:
    """Write report.png for `log`; return the summary as plain values and as lines.

    The forbidden bands are those of `system`, or of the description that the log keeps, or the packaged one's.
    """
    from seat_gear_dynamics.gears import load_train
    from seat_gear_dynamics.gears.description import parse_train
    from seat_gear_dynamics.logs.run import read_run
    from seat_gear_dynamics.views.report import summary_lines, time_by_level, write_report

    recorded = read_run(log)
    train = parse_train(recorded.system_text) if system is None and recorded.system_text else load_train(system)
    folder = output or (log if log.is_dir() else log.parent)
    folder.mkdir(parents=True, exist_ok=True)
    picture = folder / "report.png"
    write_report(recorded, train.bands, picture, load_scale=train.model.load_scale)
    values = {
        "log": str(log),
        "duration": recorded.duration,
        "report": str(picture),
        "load_scale": train.model.load_scale,
        "warning_time": time_by_level(recorded),
        "topics": {
            f.topic: {"count": f.count, "period": f.period, "longest_gap": f.longest_gap} for f in recorded.flows
        },
        "damage": recorded.damage,
    }
    return values, [*summary_lines(recorded), f"log:    {log}", f"report: {picture}"]
