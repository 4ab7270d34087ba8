"""`seat-gear analyze`: the report of a recorded run."""

import argparse
import json
from os import cpu_count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seat_gear_dynamics.commands.texts import Texts

if TYPE_CHECKING:
    from seat_gear_dynamics.commands.progress import Tell
    from seat_gear_dynamics.gears import GearTrain
    from seat_gear_dynamics.logs.analysis import Analysis
    from seat_gear_dynamics.sensing import BandSource

TEXTS = {
    "analyze": Texts(
        "report of a recorded run: one HTML page, figures and tables",
        "seat-gear analyze bags/third_party_bench --output report",
    )
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    parser.add_argument("log", metavar="LOG", type=Path, help="bag directory or .mcap file")
    parser.add_argument("--output", metavar="DIR", type=Path, help="where the report goes (default: the log's folder)")
    parser.add_argument("--speed-topic", metavar="T", help="speed of s1 (default: the monitor's input, motor/speed)")
    parser.add_argument("--load-topic", metavar="T", help="load on s4 (default: the monitor's input, load/torque)")
    parser.add_argument("--joint", metavar="NAME", help="joint of a JointState topic (default: its first)")
    parser.add_argument("--speed-unit", default="rad/s", metavar="U", help="rad/s, r/min, Hz or deg/s (default rad/s)")
    parser.add_argument("--load-unit", default="N·m", metavar="U", help="Nm, mNm or kNm (default Nm)")
    parser.add_argument(
        "--map",
        type=Path,
        metavar="F.npz",
        help="judge by this map, or `packaged` (default: the bands that the log's warnings name, or published)",
    )
    parser.add_argument("--no-model", action="store_true", help="the log alone: no sweep, map and spectra beside it")
    parser.add_argument(
        "--processes", type=int, metavar="N", help="that march a long log without forces (default: one for each core)"
    )
    parser.add_argument("--parquet", action="store_true", help="tables as Parquet too (needs pyarrow)")


def run(arguments: argparse.Namespace) -> int:
    """Analyse, write page, figures and tables, print the summary."""
    from seat_gear_dynamics.commands.progress import progress, stages
    from seat_gear_dynamics.logs.analysis import ModelSettings, Source, analyse

    train, bands = _machine(arguments.log, arguments.system, arguments.map)
    source = Source(
        arguments.speed_topic, arguments.load_topic, arguments.joint, arguments.speed_unit, arguments.load_unit
    )
    with stages(quiet=arguments.json) as tell:
        found = analyse(
            arguments.log,
            train,
            source=source,
            model=None if arguments.no_model else ModelSettings(),
            bands=bands,
            processes=(cpu_count() or 1) if arguments.processes is None else arguments.processes,
            tell=tell,
        )
    with progress("figures", quiet=arguments.json) as drawn:
        values, lines = _write(found, _folder(arguments.log, arguments.output), drawn, parquet=arguments.parquet)
    print(json.dumps(values) if arguments.json else "\n".join(lines))
    return 0


def report(
    log: Path, output: Path | None, system: str | None, *, chart: Path | None = None, quiet: bool = False
) -> tuple[dict[str, Any], list[str]]:
    """Write the one-page picture report.png for `log`; return the summary as plain values and as lines.

    The machine is that of `system`, or of the description that the log keeps, or the packaged one; its bands are those
    of the map `chart`, or those that the log's warnings name. `quiet` says nothing of the progress.
    """
    from seat_gear_dynamics.commands.progress import stages
    from seat_gear_dynamics.logs.analysis import analyse
    from seat_gear_dynamics.logs.analysis.overview import overview
    from seat_gear_dynamics.views.analysis import summary
    from seat_gear_dynamics.views.report import summary_lines

    train, bands = _machine(log, system, chart)
    with stages(quiet=quiet) as tell:
        found = analyse(log, train, bands=bands, tell=tell)
    picture = _picture(found, _folder(log, output))
    lines = [*summary_lines(overview(found)), f"log:    {log}", f"report: {picture}"]
    return {**summary(found), "report": str(picture)}, lines


def _machine(log: Path, system: str | None, chart: Path | None = None) -> tuple["GearTrain", "BandSource"]:
    """Return the train of the option, else of the log, else the packaged one, and by which bands it is judged."""
    from seat_gear_dynamics.gears import load_train
    from seat_gear_dynamics.gears.description import parse_train
    from seat_gear_dynamics.logs.analysis.band_source import band_source
    from seat_gear_dynamics.logs.analysis.what_if import recorded_bands
    from seat_gear_dynamics.logs.reader import Bag

    bag = Bag(log)
    text = (bag.metadata or {}).get("system") if system is None else None
    train = parse_train(text) if text else load_train(system)
    return train, band_source(train, chart, recorded_bands(bag))


def _folder(log: Path, output: Path | None) -> Path:
    folder = output or (log if log.is_dir() else log.parent)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _picture(found: "Analysis", folder: Path) -> Path:
    from seat_gear_dynamics.logs.analysis.overview import band_boxes, overview
    from seat_gear_dynamics.views.report import write_report

    path = folder / "report.png"
    write_report(overview(found), band_boxes(found), path, load_scale=found.train.model.load_scale)
    return path


def _write(found: "Analysis", folder: Path, tell: "Tell", *, parquet: bool) -> tuple[dict[str, Any], list[str]]:
    """Write everything to `folder`; return the summary as values and as lines."""
    from seat_gear_dynamics import __version__
    from seat_gear_dynamics.logs.analysis.tables import tables, write_tables
    from seat_gear_dynamics.views.analysis import figures, page, summary, summary_lines
    from seat_gear_dynamics.views.analysis.page import Picture
    from seat_gear_dynamics.views.figures.style import save

    written = write_tables(tables(found), folder / "tables", parquet=parquet)
    (folder / "figures").mkdir(exist_ok=True)
    pictures = []
    for drawn in figures(found):
        path = folder / "figures" / f"{drawn.name}.png"
        save(drawn.figure, path)
        pictures.append(Picture(path, drawn.section, drawn.caption, drawn.tables))
        tell(len(pictures), 0)
    html = folder / "report.html"
    html.write_text(page(found, pictures, version=__version__), encoding="utf-8")
    picture = _picture(found, folder)
    values = {
        **summary(found),
        "report": str(picture),
        "page": str(html),
        "figures": [str(each.path) for each in pictures],
        "tables": [str(path) for path in written],
    }
    return values, [*summary_lines(found), f"log:    {found.provenance.log}", f"report: {html}"]
