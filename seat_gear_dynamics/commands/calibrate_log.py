"""`seat-gear calibrate LOG`: what a measured bench says of the model's parameters."""

import argparse
import csv
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seat_gear_dynamics.gears import GearTrain
    from seat_gear_dynamics.logs.reader import Bag
    from seat_gear_dynamics.studies.identification.identify import Fitted
    from seat_gear_dynamics.studies.identification.observables import Dwell

UNITS = {
    "force": {"N": 1.0, "kN": 1e3, "mN": 1e-3},
    "acceleration": {"m/s²": 1.0, "m/s^2": 1.0, "g": 9.80665, "mm/s²": 1e-3, "mm/s^2": 1e-3},
}
"""Unit of a topic → SI."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what only a fit to a log takes."""
    parser.add_argument(
        "log", metavar="LOG", type=Path, nargs="?", help="fit this recorded bench, a bag directory or .mcap file"
    )
    group = parser.add_argument_group("with a LOG")
    measured = group.add_mutually_exclusive_group()
    measured.add_argument(
        "--force", metavar="TOPIC[:FIELD]", help="force in the mesh s1_s2; FIELD is a joint or, as in a.b, a field"
    )
    measured.add_argument("--acceleration", metavar="TOPIC[:FIELD]", help="of a gear along the line of action")
    group.add_argument("--unit", metavar="U", help="of that topic: N, kN or mN; m/s², mm/s² or g (default N, m/s²)")
    group.add_argument("--gear", default="s1", metavar="G", help="that carries the accelerometer, s1 or s2")
    group.add_argument("--free", metavar="NAMES", help="with commas (default time_scale,damping,stiffness,backlash)")
    group.add_argument(
        "--set", action="append", default=[], metavar="PATH=VALUE", help="a parameter at the start; may be repeated"
    )
    group.add_argument("--noise", type=float, default=0.0, metavar="X", help="sensor's standard deviation, in its unit")
    group.add_argument("--starts", type=int, default=3, metavar="N", help="searches from different starts (default 3)")
    group.add_argument("--speed-topic", metavar="T", help="speed of s1 (default: the monitor's input, motor/speed)")
    group.add_argument("--load-topic", metavar="T", help="load on s4 (default: the monitor's input, load/torque)")
    group.add_argument("--joint", metavar="NAME", help="joint of a JointState with speed or load (default: its first)")
    group.add_argument("--speed-unit", default="rad/s", metavar="U", help="rad/s, r/min, Hz or deg/s (default rad/s)")
    group.add_argument("--load-unit", default="N·m", metavar="U", help="Nm, mNm or kNm (default Nm)")


def run(arguments: argparse.Namespace) -> int:
    """Find the dwells, fit, write description, table, values and figure, print."""
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.commands.progress import stages
    from seat_gear_dynamics.logs.reader import Bag
    from seat_gear_dynamics.studies.identification.identify import identify
    from seat_gear_dynamics.studies.identification.parameters import DEFAULT
    from seat_gear_dynamics.studies.identification.waveform import Sensor

    kind, topic, factor = _measured(arguments)
    bag = Bag(arguments.log)
    train = _train(bag, arguments)
    try:
        with stages(quiet=arguments.json) as tell:
            fitted = identify(
                train,
                read_dwells(bag, topic, factor, arguments),
                Sensor(kind, arguments.gear),
                free=DEFAULT if arguments.free is None else tuple(arguments.free.split(",")),
                noise=arguments.noise * factor,
                seed=arguments.seed,
                searches=max(1, arguments.starts),
                tell=tell,
            )
        written = _write(fitted, train.text, _folder(arguments))
    except ValueError as error:
        raise CommandError(str(error)) from error
    _print(fitted, written, as_json=arguments.json)
    return 0


def read_dwells(bag: "Bag", topic: str, factor: float, arguments: argparse.Namespace) -> "list[Dwell]":
    """Return the dwells of a log with what `topic` (TOPIC[:FIELD]) showed in each, times `factor`.

    A dwell is what `seat-gear analyze` calls one (steady speed and load for 0.8 s at least), without its first 0.3 s.
    Samples stand at their stamp, else at the time they were published. Samples that are not finite are left out;
    dwells with fewer than 50 are too. Raises LogError where the topic or the drive is not in the log.
    """
    import numpy as np

    from seat_gear_dynamics.logs.analysis.batches import Batch
    from seat_gear_dynamics.logs.analysis.dwells import SETTLING, Dwells
    from seat_gear_dynamics.studies.identification.observables import Dwell

    drive, signal = _samples(bag, topic, arguments)
    finder = Dwells(keep=0)
    finder.add(Batch(drive=np.column_stack([drive, np.zeros(len(drive))])))
    finder.finish()
    turned = np.concatenate([[0.0], np.cumsum(np.diff(drive[:, 0]) * (drive[1:, 1] + drive[:-1, 1]) / 2)])
    signal = signal[np.isfinite(signal).all(axis=1)]
    signal = signal[np.unique(signal[:, 0], return_index=True)[1]]
    found = []
    for row in finder.rows:
        own = signal[(signal[:, 0] >= row.begin + SETTLING) & (signal[:, 0] <= row.end)]
        if len(own) >= 50:
            angle = np.interp(own[:, 0], drive[:, 0], turned)
            found.append(Dwell(row.speed, row.load, own[:, 0], angle, own[:, 1] * factor))
    return found


def _measured(arguments: argparse.Namespace) -> tuple[str, str, float]:
    """Return the sensor's kind, topic and factor to SI."""
    from seat_gear_dynamics.commands.errors import CommandError

    kind = "acceleration" if arguments.acceleration else "force"
    topic = arguments.acceleration or arguments.force
    if not topic:
        raise CommandError(
            "No measured topic is named for the log; give --force TOPIC or --acceleration TOPIC, such as "
            "--force bench/mesh_force."
        )
    known, unit = UNITS[kind], arguments.unit or next(iter(UNITS[kind]))
    if unit not in known:
        raise CommandError(f"The unit of the {kind} is {unit!r}, expected one of {', '.join(known)}.")
    return kind, topic, known[unit]


def _train(bag: "Bag", arguments: argparse.Namespace) -> "GearTrain":
    """Return the train of the option, else of the log, else the packaged one, with the values of --set."""
    from seat_gear_dynamics.gears import load_train
    from seat_gear_dynamics.gears.description import parse_train
    from seat_gear_dynamics.logs.analysis.what_if import split, with_values

    kept = (bag.metadata or {}).get("system") if arguments.system is None else None
    train = parse_train(kept) if kept else load_train(arguments.system)
    system, others = split(arguments.set)
    return parse_train(with_values(train.text, {**system, **others})) if arguments.set else train


def _samples(bag: "Bag", topic: str, arguments: argparse.Namespace) -> tuple[Any, Any]:
    """Return the drive (n, 3): time in s, rad/s, N·m; and the signal (m, 2): time in s, value as logged."""
    import numpy as np

    from seat_gear_dynamics.logs.analysis.sources import Source, readers

    units = arguments.speed_unit, arguments.load_unit
    source = Source(arguments.speed_topic, arguments.load_topic, arguments.joint, *units)
    name, _, field = topic.partition(":")
    name = bag.resolve(name)
    read_drive, read_signal = readers(bag, source), _reader(bag, name, field)
    drive: list[tuple[float, float, float]] = []
    signal: list[tuple[float, float]] = []
    load: float | None = None
    for own, log_ns, publish_ns, data in bag.messages({name, *read_drive}):
        if own in read_drive:
            stamp, speed, told = read_drive[own](data)
            load = told if told is not None and np.isfinite(told) else load
            t = _seconds(stamp, publish_ns or log_ns, bag.start_ns)
            if speed is not None and np.isfinite(speed) and load is not None and (not drive or t > drive[-1][0]):
                drive.append((t, speed, load))
        if own == name:
            stamp, value = read_signal(data)
            signal.append((_seconds(stamp, publish_ns or log_ns, bag.start_ns), value))
    return np.array(drive).reshape(-1, 3), np.array(signal).reshape(-1, 2)


def _seconds(stamp_ns: int | None, sent_ns: int, start_ns: int) -> float:
    # A stamp of another clock (simulated time, or a sensor's own) cannot be held against the drive's.
    own = stamp_ns if stamp_ns and abs(stamp_ns - sent_ns) < 10_000_000_000 else sent_ns
    return (own - start_ns) * 1e-9


def _reader(bag: "Bag", name: str, field: str) -> Callable[[bytes], tuple[int | None, float]]:
    """Return the function that reads stamp and number of the measured topic's messages."""
    from seat_gear_dynamics.logs import topics
    from seat_gear_dynamics.logs.analysis.message_bytes import JointDecoder, float64

    kind = bag.topics[name].type
    if kind == topics.FLOAT64:
        return lambda data: (None, float64(data))
    if kind != topics.JOINT_STATE:
        return _field_reader(name, kind, field or "data")
    decoder = JointDecoder()

    def effort(data: bytes) -> tuple[int | None, float]:
        found = decoder.decode(data)
        by_name = dict(zip(found.names, found.effort, strict=False))
        value = by_name.get(field) if field else next(iter(found.effort), None)
        return found.stamp_ns or None, float("nan") if value is None else value

    return effort


def _field_reader(name: str, kind: str, field: str) -> Callable[[bytes], tuple[int | None, float]]:
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.logs.schemas import Decoder

    decoder = Decoder({})

    def read(data: bytes) -> tuple[int | None, float]:
        message: Any = decoder.decode(data, kind)
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        found = message
        try:
            for part in field.split("."):
                found = getattr(found, part)
            number = float(found)
        except (AttributeError, TypeError) as error:
            raise CommandError(
                f"The topic {name} is {kind}, which has no number {field!r}; name one as TOPIC:FIELD, such as "
                f"bench/wrench:wrench.force.z."
            ) from error
        return (stamp.sec * 1_000_000_000 + stamp.nanosec if stamp is not None else None), number

    return read


def _folder(arguments: argparse.Namespace) -> Path:
    log: Path = arguments.log
    folder = Path(arguments.output) if arguments.output else (log if log.is_dir() else log.parent) / "identification"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _write(fitted: "Fitted", text: str, folder: Path) -> dict[str, Path]:
    """Write what was found; return what is where."""
    from seat_gear_dynamics.studies.identification.describe import COLUMNS, described, table, values
    from seat_gear_dynamics.views.figures.identification import identification_figure
    from seat_gear_dynamics.views.figures.style import save

    names = {"system": "fitted.yaml", "values": "identification.json", "table": "identification.csv"}
    written = {what: folder / name for what, name in (names | {"figure": "identification.png"}).items()}
    written["system"].write_text(described(text, fitted), encoding="utf-8")
    written["values"].write_text(json.dumps(values(fitted), indent=1), encoding="utf-8")
    with written["table"].open("w", newline="", encoding="utf-8") as file:
        rows: Sequence[Sequence[Any]] = [COLUMNS, *table(fitted)]
        csv.writer(file).writerows(rows)
    save(identification_figure(fitted), written["figure"])
    return written


def _print(fitted: "Fitted", written: dict[str, Path], *, as_json: bool) -> None:
    from seat_gear_dynamics.studies.identification.describe import lines, values

    if as_json:
        print(json.dumps(values(fitted) | {what: str(path) for what, path in written.items()}))
        return
    print("\n".join([*lines(fitted), *(f"{what + ':':8s} {path}" for what, path in written.items())]))
