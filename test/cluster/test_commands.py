"""`seat-gear sweep` and `map` with --scheduler: the files of a local run, to the byte, and errors in one line."""

import json
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from dask_cluster import Cluster
from interrupted import ended_amid

from seat_gear_dynamics.cluster import dask_workers
from seat_gear_dynamics.cluster.build import build
from seat_gear_dynamics.commands import main
from seat_gear_dynamics.commands.journal import Journal
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.regimes.workers import Threads

SWEEP = "sweep --over load --start 100 --stop 300 --points 100 --transient 2 --periods 48"
BOTH = "sweep --over load --start 100 --stop 300 --points 20 --direction both --transient 2 --periods 48"
MAP = "map --speed-rpm 600 1100 20 --load 100 200 2 --transient 2 --periods 48 --samples 2"


@pytest.fixture
def run(train: GearTrain, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    """Run `seat-gear` on the train of fixed parameters in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    Path("fixed.yaml").write_text(train.text, encoding="utf-8")
    return lambda words, *more: main([*words.split(), "--system", "fixed.yaml", *more])


def contents(stem: str) -> dict[str, bytes]:
    return {path.name.removeprefix(stem): path.read_bytes() for path in Path().glob(f"{stem}[._]*")}


@pytest.mark.parametrize("words", [SWEEP, BOTH, MAP])
def test_the_files_are_those_of_a_local_run(cluster: Cluster, run: Callable[..., int], words: str) -> None:
    ending = "npz" if words.startswith("map") else "csv"
    assert run(words, "--output", f"local.{ending}") == 0
    assert run(words, "--output", f"far.{ending}", "--scheduler", cluster.address) == 0
    assert contents("far") == contents("local")
    assert contents("far")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_run_that_was_ended_on_the_cluster_goes_on_at_home(
    cluster: Cluster, run: Callable[..., int], number: int
) -> None:
    where = ["--system", "fixed.yaml", "--output", "far.csv", "--scheduler", cluster.address]
    # Notes come often, so that a short sweep leaves one.
    done = ended_amid([*SWEEP.split(), *where], number, 40, note_interval=0.0)
    if number == signal.SIGINT:
        assert done.stderr == "interrupted at row 40 of 100; the same command goes on from there\n"
    assert json.loads(Path("far.csv.part").read_text())["reached"]["rows"] == 40
    run(SWEEP, "--output", "far.csv")
    run(SWEEP, "--output", "local.csv")
    assert contents("far") == contents("local")


def test_a_run_that_was_begun_at_home_goes_on_by_a_cluster_with_another_processor_only_anew(
    run: Callable[..., int], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    @contextmanager
    def elsewhere(_: str) -> Iterator[Threads]:
        threads: Any = Threads()
        threads.build = {**build(), "processor": "other"}
        yield threads

    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as change:
        change.setattr(Journal, "add", stopped)
        assert run(SWEEP, "--output", "far.csv") == 130
    monkeypatch.setattr(dask_workers, "connected", elsewhere)
    assert run(SWEEP, "--output", "far.csv", "--scheduler", "tcp://a:1") == 1
    assert "the program's processor was" in capsys.readouterr().err
    assert run(SWEEP, "--output", "far.csv", "--scheduler", "tcp://a:1", "--restart") == 0


def test_a_scheduler_out_of_reach_is_one_line_and_leaves_no_file(
    run: Callable[..., int], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
    monkeypatch.setattr(dask_workers, "connected", partial(dask_workers.connected, timeout=0.3))
    for words, output in ((SWEEP, "f.csv"), (MAP, "f.npz")):
        assert run(words, "--output", output, "--scheduler", address) == 1
        printed = capsys.readouterr()
        assert printed.out == ""
        assert printed.err.startswith(f"error: No Dask scheduler answered at '{address}' within 0.3 s; ")
        assert printed.err.count("\n") == 1
    assert [path.name for path in Path().iterdir()] == ["fixed.yaml"]


def test_the_whole_process_says_one_line_to_a_listener_that_never_answers(run: Callable[..., int]) -> None:
    # In a process of its own: what Dask leaves behind would speak when that ends.
    program = (
        "import sys; from functools import partial; from seat_gear_dynamics.commands import main;"
        "from seat_gear_dynamics.cluster import dask_workers as d; d.connected = partial(d.connected, timeout=0.5);"
        "sys.exit(main())"
    )
    with socket.create_server(("127.0.0.1", 0)) as server:
        where = ["--output", "f.csv", "--scheduler", f"tcp://127.0.0.1:{server.getsockname()[1]}"]
        done = subprocess.run(
            [sys.executable, "-c", program, *SWEEP.split(), *where], capture_output=True, text=True, check=False
        )
    assert done.returncode == 1
    assert done.stderr.startswith("error: No Dask scheduler answered at")
    assert done.stderr.count("\n") == 1


def test_without_dask_the_remedy_is_one_line(
    run: Callable[..., int], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert run(SWEEP, "--output", "f.csv", "--scheduler", "tcp://127.0.0.1:1") == 1
    err = capsys.readouterr().err
    assert "pip install 'seat_gear_dynamics[cluster]'" in err
    assert err.count("\n") == 1
    assert run(SWEEP, "--output", "f.csv") == 0  # local cores need none of it


def certificates(folder: Path) -> dict[str, str]:
    """Return Dask's settings for a certificate of the folder's own, which vouches for itself."""
    certificate, key = folder / "cert.pem", folder / "key.pem"
    made = "req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=seat-gear-test"
    command = ["openssl", *made.split(), "-keyout", str(key), "-out", str(certificate)]
    subprocess.run(command, check=True, capture_output=True)
    settings = {"ca-file": certificate}
    for role in ("scheduler", "worker", "client"):
        settings |= {f"{role}.cert": certificate, f"{role}.key": key}
    return {f"distributed.comm.tls.{name}": str(value) for name, value in settings.items()}


@pytest.mark.skipif(shutil.which("openssl") is None, reason="needs the program openssl to make a certificate")
def test_a_scheduler_with_certificates_is_reached_by_dasks_own_configuration(
    make_cluster: Callable[..., Cluster],
    run: Callable[..., int],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    import dask

    settings = certificates(tmp_path)
    for name, value in settings.items():
        monkeypatch.setenv("DASK_" + name.upper().replace(".", "__").replace("-", "_"), value)
    own = make_cluster(1, protocol="tls")
    assert own.address.startswith("tls://")
    assert run(SWEEP, "--output", "far.csv", "--scheduler", own.address) == 1
    assert "check your TLS configuration" in capsys.readouterr().err
    with dask.config.set(settings):
        assert run(SWEEP, "--output", "far.csv", "--scheduler", own.address) == 0
    run(SWEEP, "--output", "local.csv")
    assert contents("far") == contents("local")
