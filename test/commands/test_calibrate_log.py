"""`seat-gear calibrate LOG`: a bag of a bench with a force sensor goes in, a system that opens comes out."""

import csv
import json
import struct
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from seat_gear_dynamics.commands import main
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs.topics import FLOAT64, LOAD_TORQUE, MOTOR_SPEED
from seat_gear_dynamics.logs.writer import BagWriter
from seat_gear_dynamics.motion import load_system
from seat_gear_dynamics.studies.identification.observables import Dwell
from seat_gear_dynamics.studies.identification.parameters import Candidate
from seat_gear_dynamics.studies.identification.synthetic import synthetic_dwells
from seat_gear_dynamics.studies.identification.waveform import Sensor

BEGIN_NS = 1_790_000_000_000_000_000
FORCE = "/bench/mesh_force"
DRIVES = [(speed * RPM, load) for speed in (250, 400, 550) for load in (300.0, 600.0)]


def write_bag(path: Path, system_text: str, dwells: Sequence[Dwell], *, scale: float = 1.0) -> None:
    """Write the dwells one after the other, a second between them: speed and load at 50 Hz, the signal as it is."""
    writer = BagWriter(
        path,
        system_text=system_text,
        system_hash=sha256(system_text.encode()).hexdigest(),
        software_version="0",
    )
    names = [MOTOR_SPEED.absolute(), LOAD_TORQUE.absolute(), FORCE]
    for name in names:
        writer.add_topic(name, FLOAT64)
    rows: list[tuple[float, str, float]] = []
    start = 0.0
    for dwell in dwells:
        end = start + float(dwell.time[-1])
        for t in np.arange(start, end, 0.02):
            rows += [(t, names[0], dwell.speed), (t, names[1], dwell.load)]
        rows += [(start + t, FORCE, scale * v) for t, v in zip(dwell.time, dwell.value, strict=True)]
        start = end + 1.0
    for t, name, value in sorted(rows, key=lambda row: row[0]):
        now = BEGIN_NS + round(t * 1e9)
        writer.write(name, b"\x00\x01\x00\x00" + struct.pack("<d", value), now, now)
    writer.close()


@pytest.fixture(scope="module")
def recorded(train: GearTrain, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A record of a machine with other damping and time scale: in kN, with a NaN, and with the description before."""
    truth = Candidate(train).with_values(["damping", "time_scale"], [0.09, 1900.0]).train
    dwells = synthetic_dwells(truth, DRIVES, Sensor(), seconds=1.6, rate=1500.0, noise=1.0)
    dwells[0].value[100] = np.nan
    path = tmp_path_factory.mktemp("bench") / "log"
    write_bag(path, train.text, dwells, scale=1e-3)
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
