"""`seat-gear calibrate LOG`: what a measured bench says of the model's parameters."""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seat_gear_dynamics.commands.progress import Tell
    from seat_gear_dynamics.gears import GearTrain
    from seat_gear_dynamics.logs.reader import Bag
    from seat_gear_dynamics.studies.identification.identify import Fitted
    from seat_gear_dynamics.studies.identification.observables import Dwell

UNITS = {
    "force": {"N": 1.0, "kN": 1e3, "mN": 1e-3},
    "acceleration": {"m/s²": 1.0, "m/s^2": 1.0, "g": 9.80665, "mm/s²": 1e-3, "mm/s^2": 1e-3},
}
"""Unit of a topic → SI."""
_TOLD = 5000  # messages between two tellings of how far the reading is


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
                read_dwells(bag, topic, factor, arguments, lambda done, total: tell("reading", done, total)),
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


def read_dwells(bag: "Bag", topic: str, factor: float, arguments: argparse.Namespace, tell: "Tell") -> "list[Dwell]":
    """Return the dwells of a log with what `topic` (TOPIC[:FIELD]) showed in each, times `factor`.

    A dwell is what `seat-gear analyze` calls one (steady speed and load for 0.8 s at least), without its first 0.3 s.
    Samples stand at their stamp, else at the time they were published. Samples that are not finite are left out;
    dwells with fewer than 50 are too. `tell` gets (messages read, in all). Raises LogError where the topic or the drive
    is not in the log, CommandError where the topic holds no such number.
    """
    import numpy as np

    from seat_gear_dynamics.logs.analysis.batches import Batch
    from seat_gear_dynamics.logs.analysis.dwells import SETTLING, Dwells
    from seat_gear_dynamics.studies.identification.observables import Dwell

    drive, signal = _samples(bag, topic, arguments, tell)
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


def _samples(bag: "Bag", topic: str, arguments: argparse.Namespace, tell: "Tell") -> tuple[Any, Any]:
    """Return the drive (n, 3): time in s, rad/s, N·m; and the signal (m, 2): time in s, value as logged."""
    import numpy as np

    name, _, field = topic.partition(":")
    signal: list[tuple[float, float]] = []
    total = bag.topics[bag.resolve(name)].count
    for time_ns, stamp, value in _signal(bag, bag.resolve(name), field):
        signal.append((_seconds(stamp, time_ns, bag.start_ns), value))
        if not len(signal) % _TOLD:
            tell(len(signal), total)
    return np.array(_drive(bag, arguments)).reshape(-1, 3), np.array(signal).reshape(-1, 2)


def _drive(bag: "Bag", arguments: argparse.Namespace) -> list[tuple[float, float, float]]:
    import numpy as np

    from seat_gear_dynamics.logs.analysis.sources import Source, readers

    units = arguments.speed_unit, arguments.load_unit
    read = readers(bag, Source(arguments.speed_topic, arguments.load_topic, arguments.joint, *units))
    drive: list[tuple[float, float, float]] = []
    load: float | None = None
    for name, log_ns, publish_ns, data in bag.messages(read):
        stamp, speed, told = read[name](data)
        load = told if told is not None and np.isfinite(told) else load
        t = _seconds(stamp, publish_ns or log_ns, bag.start_ns)
        if speed is not None and np.isfinite(speed) and load is not None and (not drive or t > drive[-1][0]):
            drive.append((t, speed, load))
    return drive


def _seconds(stamp_ns: int | None, sent_ns: int, start_ns: int) -> float:
    # A stamp of another clock (simulated time, or a sensor's own) cannot be held against the drive's.
    own = stamp_ns if stamp_ns and abs(stamp_ns - sent_ns) < 10_000_000_000 else sent_ns
    return (own - start_ns) * 1e-9


def _signal(bag: "Bag", name: str, field: str) -> Iterator[tuple[int, int | None, float]]:
    """Yield (time sent in ns, stamp in ns, number) of the measured topic's messages."""
    from seat_gear_dynamics.logs import topics
    from seat_gear_dynamics.logs.analysis.message_bytes import float64

    kind = bag.topics[name].type
    if kind == topics.FLOAT64 and field in ("", "data"):
        for _, log_ns, publish_ns, data in bag.messages(name):
            yield publish_ns or log_ns, None, float64(data)
    elif kind == topics.JOINT_STATE:
        yield from _efforts(bag, name, field)
    else:
        for _, log_ns, publish_ns, message in bag.decoded(name):
            stamp = getattr(getattr(message, "header", None), "stamp", None)
            stamp_ns = None if stamp is None else stamp.sec * 1_000_000_000 + stamp.nanosec
            yield publish_ns or log_ns, stamp_ns, _number(message, name, kind, field or "data")


def _efforts(bag: "Bag", name: str, joint: str) -> Iterator[tuple[int, int | None, float]]:
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.logs.analysis.message_bytes import JointDecoder

    decoder, others = JointDecoder(), dict[str, None]()
    told = False
    for _, log_ns, publish_ns, data in bag.messages(name):
        found = decoder.decode(data)
        index = 0 if not joint else found.names.index(joint) if joint in found.names else len(found.names)
        if index < len(found.effort):
            told = True
            yield publish_ns or log_ns, found.stamp_ns or None, found.effort[index]
        others.update(dict.fromkeys(found.names))
    if not told:
        whose = f"of the joint {joint!r}" if joint else "of any joint"
        raise CommandError(f"The topic {name} holds no effort {whose}; its joints are {', '.join(others) or 'none'}.")


def _number(message: Any, name: str, kind: str, field: str) -> float:
    from seat_gear_dynamics.commands.errors import CommandError

    found = message
    try:
        for part in field.split("."):
            found = found[int(part)] if part.isdigit() else getattr(found, part)
        return float(found)
    except (AttributeError, IndexError, TypeError, ValueError) as error:
        raise CommandError(
            f"The topic {name} is {kind}, which has no number {field!r}; name one as TOPIC:FIELD, such as "
            f"bench/wrench:wrench.force.z, or bench/forces:data.0 for the first of several."
        ) from error


def _folder(arguments: argparse.Namespace) -> Path:
    log: Path = arguments.log
    folder = Path(arguments.output) if arguments.output else (log if log.is_dir() else log.parent) / "identification"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _write(fitted: "Fitted", text: str, folder: Path) -> dict[str, Path]:
    """Write what was found; return what is where."""
    from seat_gear_dynamics.studies.identification.describe import described, values
    from seat_gear_dynamics.views.figures.identification import identification_figure
    from seat_gear_dynamics.views.figures.style import save

    names = {"system": "fitted.yaml", "values": "identification.json", "table": "identification.csv"}
    written = {what: folder / name for what, name in (names | {"figure": "identification.png"}).items()}
    written["system"].write_text(described(text, fitted), encoding="utf-8")
    written["values"].write_text(json.dumps(values(fitted), indent=1), encoding="utf-8")
    fitted.to_csv(written["table"])
    save(identification_figure(fitted), written["figure"])
    return written


def _print(fitted: "Fitted", written: dict[str, Path], *, as_json: bool) -> None:
    from seat_gear_dynamics.studies.identification.describe import lines, values

    if as_json:
        print(json.dumps(values(fitted) | {what: str(path) for what, path in written.items()}))
        return
    print("\n".join([*lines(fitted), *(f"{what + ':':8s} {path}" for what, path in written.items())]))
