"""`seat-gear calibrate LOG`: a bag of a bench with a force sensor goes in, a system that opens comes out."""

import csv
import json
import struct
from collections.abc import Callable, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from seat_gear_dynamics.commands import main
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.schemas import schema
from seat_gear_dynamics.logs.topics import FLOAT64, JOINT_STATE, LOAD_TORQUE, MOTOR_SPEED
from seat_gear_dynamics.logs.writer import BagWriter
from seat_gear_dynamics.motion import load_system
from seat_gear_dynamics.studies.identification.observables import Dwell
from seat_gear_dynamics.studies.identification.parameters import Candidate
from seat_gear_dynamics.studies.identification.synthetic import synthetic_dwells
from seat_gear_dynamics.studies.identification.waveform import Sensor

BEGIN_NS = 1_790_000_000_000_000_000
FORCE = "/bench/mesh_force"
DRIVES = [(speed * RPM, load) for speed in (250, 400, 550) for load in (300.0, 600.0)]


SPEED, LOAD = MOTOR_SPEED.absolute(), LOAD_TORQUE.absolute()
STORE = get_typestore(Stores.ROS2_JAZZY)
Rows = list[tuple[float, str, bytes]]
"""(seconds, topic, bytes)"""


def float64(value: float) -> bytes:
    return b"\x00\x01\x00\x00" + struct.pack("<d", value)


def rows(dwells: Sequence[Dwell], topic: str, message: Callable[[float, float], bytes]) -> Rows:
    """Return the dwells one after the other, a second between them: speed and load at 50 Hz, the signal as it is.

    `message` takes (s, what the sensor showed).
    """
    found: Rows = []
    start = 0.0
    for dwell in dwells:
        end = start + float(dwell.time[-1])
        for t in np.arange(start, end, 0.02):
            found += [(t, SPEED, float64(dwell.speed)), (t, LOAD, float64(dwell.load))]
        found += [(start + t, topic, message(start + t, v)) for t, v in zip(dwell.time, dwell.value, strict=True)]
        start = end + 1.0
    return sorted(found, key=lambda row: row[0])


def write_bag(
    path: Path,
    system_text: str,
    dwells: Sequence[Dwell],
    *,
    kind: str = FLOAT64,
    message: Callable[[float, float], bytes] = lambda t, value: float64(value),
) -> None:
    """Write the dwells with the sensor's messages of a type that the project knows."""
    writer = BagWriter(
        path,
        system_text=system_text,
        system_hash=sha256(system_text.encode()).hexdigest(),
        software_version="0",
    )
    for name, each in ((SPEED, FLOAT64), (LOAD, FLOAT64), (FORCE, kind)):
        writer.add_topic(name, each)
    for t, name, data in rows(dwells, FORCE, message):
        now = BEGIN_NS + round(t * 1e9)
        writer.write(name, data, now, now)
    writer.close()


@pytest.fixture(scope="module")
def recorded(train: GearTrain, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A record of a machine with other damping and time scale: in kN, with a NaN, and with the description before."""
    truth = Candidate(train).with_values(["damping", "time_scale"], [0.09, 1900.0]).train
    dwells = synthetic_dwells(truth, DRIVES, Sensor(), seconds=1.6, rate=1500.0, noise=1.0)
    dwells[0].value[100] = np.nan
    path = tmp_path_factory.mktemp("bench") / "log"
    write_bag(path, train.text, dwells, message=lambda t, force: float64(1e-3 * force))
    return path


def test_a_recorded_bench_gives_a_system_that_opens(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["calibrate", str(recorded), "--force", "bench/mesh_force", "--unit", "kN", "--noise", "0.001"]
    asked += ["--free", "damping,time_scale,backlash", "--starts", "1", "--output", str(tmp_path / "out")]
    assert main([*asked, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["dwells_used"] == len(DRIVES)
    for name, truth in (("damping", 0.09), ("time_scale", 1900.0)):
        low, high = found["parameters"][name]["interval"]
        # As in test_identification: 95 % intervals, twice as wide so that one record in some thousand misses.
        assert low * (low / high) ** 0.5 < truth < high * (high / low) ** 0.5, (name, low, high)
    assert found["not_identified"] == ["backlash"]
    assert load_system(found["system"]).train.meshes[0].damping_ratio == pytest.approx(
        found["parameters"]["damping"]["value"], rel=1e-5
    )
    with Path(found["table"]).open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["dwell"] for row in rows} == {str(k + 1) for k in range(len(DRIVES))}
    assert Path(found["figure"]).read_bytes().startswith(b"\x89PNG")
    assert json.loads(Path(found["values"]).read_text(encoding="utf-8"))["parameters"] == found["parameters"]


@pytest.fixture(scope="module")
def truth(train: GearTrain) -> GearTrain:
    """A machine of more damping than the one in the logs."""
    return Candidate(train).with_values(["damping"], [0.09]).train


def damping(capsys: pytest.CaptureFixture[str], *asked: str) -> dict[str, Any]:
    """Fit the damping alone, and return what the command says when the truth of 0.09 lies where it says."""
    code = main(["calibrate", *asked, "--free", "damping", "--starts", "1", "--json"])
    said = capsys.readouterr()
    assert code == 0, said.err
    found: dict[str, Any] = json.loads(said.out)
    low, high = found["parameters"]["damping"]["interval"]
    # Twice the 95 % interval, as above.
    assert low * (low / high) ** 0.5 < 0.09 < high * (high / low) ** 0.5, (low, high)
    assert high / low < 1.2
    assert found["dwells_used"] == 4
    return found


def test_an_acceleration_of_the_second_gear_in_g(
    train: GearTrain, truth: GearTrain, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sensor = Sensor("acceleration", "s2")
    dwells = synthetic_dwells(truth, DRIVES[1:5], sensor, seconds=1.6, rate=1500.0, noise=0.1)
    write_bag(tmp_path / "log", train.text, dwells, message=lambda t, value: float64(value / 9.80665))
    found = damping(
        capsys, str(tmp_path / "log"), "--acceleration", "mesh_force", "--gear", "s2", "--unit", "g", "--noise", "0.01"
    )
    assert found["sensor"] == {"kind": "acceleration", "gear": "s2", "unit": "m/s²"}
    with Path(found["table"]).open(encoding="utf-8") as file:
        spread = next(float(row["measured [m/s²]"]) for row in csv.DictReader(file) if row["observable"] == "spread")
    # A hundredth: the command leaves out the first 0.3 s of 1.6.
    assert spread == pytest.approx(float(dwells[0].value.std()), rel=0.01)


@pytest.fixture(scope="module")
def pulled(truth: GearTrain) -> list[Dwell]:
    """Four dwells of the force of that machine."""
    return synthetic_dwells(truth, DRIVES[1:5], Sensor(), seconds=1.6, rate=1500.0, noise=1.0)


def efforts(t: float, force: float) -> bytes:
    """A stamped JointState of two joints; the second carries the force."""
    ns = BEGIN_NS + round(t * 1e9)
    stamp = STORE.types["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
    header = STORE.types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
    none = np.empty(0)
    message = STORE.types[JOINT_STATE](header, ["seat", "cell"], none, none, np.array([1e6, force]))
    return bytes(STORE.serialize_cdr(message, JOINT_STATE))


def test_the_effort_of_a_named_joint(
    train: GearTrain, pulled: list[Dwell], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log"
    write_bag(log, train.text, pulled, kind=JOINT_STATE, message=efforts)
    damping(capsys, str(log), "--force", "bench/mesh_force:cell", "--noise", "1")
    assert main(["calibrate", str(log), "--force", "bench/mesh_force:handle"]) == 1
    assert "no effort of the joint 'handle'; its joints are seat, cell" in capsys.readouterr().err


BENCH_TYPE = "my_bench/msg/Cells"
BENCH_TEXT = f"int32 number\nmy_bench/Cell[] cells\n{'=' * 80}\nMSG: my_bench/Cell\nfloat32 newton\n"


def write_foreign(path: Path, dwells: Sequence[Dwell]) -> None:
    """Write a log of another program, whose sensor has a message type that ROS 2 does not know."""
    types = get_types_from_msg(BENCH_TEXT, BENCH_TYPE)
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(types)
    cell, cells = store.types["my_bench/msg/Cell"], store.types[BENCH_TYPE]
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="another")
        known = {name: (FLOAT64, schema(FLOAT64).text) for name in (SPEED, LOAD)} | {FORCE: (BENCH_TYPE, BENCH_TEXT)}
        numbers = {
            name: writer.register_channel(name, "cdr", writer.register_schema(kind, "ros2msg", text.encode()))
            for name, (kind, text) in known.items()
        }
        for t, name, data in rows(
            dwells, FORCE, lambda t, v: bytes(store.serialize_cdr(cells(2, [cell(0.0), cell(v)]), BENCH_TYPE))
        ):
            now = BEGIN_NS + round(t * 1e9)
            writer.add_message(numbers[name], now, data, now)
        writer.finish()  # type: ignore[no-untyped-call]


def test_a_number_deep_in_a_message_of_the_benchs_own_type(
    train: GearTrain, pulled: list[Dwell], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_foreign(tmp_path / "log.mcap", pulled)
    (tmp_path / "train.yaml").write_text(train.text, encoding="utf-8")
    asked = str(tmp_path / "log.mcap"), "--system", str(tmp_path / "train.yaml"), "--output", str(tmp_path / "out")
    damping(capsys, *asked, "--force", "bench/mesh_force:cells.1.newton", "--noise", "1")
    for field in ("", ":cells", ":cells.7.newton", ":cells.1.pound"):
        assert main(["calibrate", *asked, "--force", f"bench/mesh_force{field}"]) == 1
        assert f"is {BENCH_TYPE}, which has no number {field[1:] or 'data'!r}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--force", "no/such"], "no topic 'no/such'"),
        ([], "--force TOPIC or --acceleration TOPIC"),
        (["--force", "bench/mesh_force", "--unit", "g"], "expected one of N, kN"),
        (["--force", "bench/mesh_force", "--free", "mass"], "'mass' is unknown"),
        (["--force", "bench/mesh_force", "--set", "meshes.s1_s2.nothing=1"], "no parameter"),
        (["--acceleration", "bench/mesh_force", "--gear", "s9"], "'s9', expected one of s1"),
    ],
)
def test_wrong_use_ends_in_a_sentence(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], said: str
) -> None:
    assert main(["calibrate", str(recorded), *options, "--output", str(tmp_path / "out")]) == 1
    assert said in capsys.readouterr().err


def test_a_log_without_dwells_ends_in_a_sentence(
    train: GearTrain, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    time = np.arange(0, 2.0, 0.002)
    ramp = [Dwell(float(10 + 20 * t), 300.0, time[:10], time[:10], np.ones(10)) for t in time[::10]]
    write_bag(tmp_path / "log", train.text, ramp)
    assert main(["calibrate", str(tmp_path / "log"), "--force", "bench/mesh_force"]) == 1
    assert "There are 0 dwells that can be fitted in the record, expected at least 3" in capsys.readouterr().err
