"""Sweeps and maps by a real Dask cluster: bit for bit those of this machine, whatever happens to workers."""

import math
import re
import shutil
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dask_cluster import Cluster

import seat_gear_dynamics
from seat_gear_dynamics.cluster.build import build
from seat_gear_dynamics.cluster.dask_workers import BLOCK, DaskWorkers, connected
from seat_gear_dynamics.cluster.errors import ClusterError
from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.motion import System
from seat_gear_dynamics.regimes import RegimeMap, with_tolerances
from seat_gear_dynamics.regimes.sweep import sweep_each
from seat_gear_dynamics.regimes.sweep_plan import Begun, Plan
from seat_gear_dynamics.regimes.sweep_table import Lines, lines

PACKAGE = Path(seat_gear_dynamics.__file__).parent
COLD = Plan("frequency", 0.5, 1.9, 400, transient=30, periods=48)
BOTH = Plan("frequency", 0.5, 1.9, 40, "both", transient=30, periods=48)
MakeCluster = Callable[..., Cluster]


@pytest.fixture(scope="module")
def system(train: GearTrain) -> System:
    return System(train).at(load=100.0)


def content(found: Lines) -> tuple[object, ...]:
    return found.table, found.points, found.direction, found.state


def rows(system: System, plan: Plan, **options: Any) -> list[tuple[object, ...]]:
    return [content(found) for found in sweep_each(system, plan, lines, **options)]


@pytest.fixture(scope="module")
def cold(system: System) -> list[tuple[object, ...]]:
    """The rows of COLD by the threads of this machine."""
    return rows(system, COLD)


@pytest.mark.parametrize("block", [16, 50, BLOCK])
def test_a_cold_sweep_is_the_local_one_to_the_bit(
    cluster: Cluster, system: System, cold: list[tuple[object, ...]], block: int
) -> None:
    with connected(cluster.address) as found:
        assert rows(system, COLD, workers=DaskWorkers(found._client, cluster.address, block=block)) == cold
    assert len({row[0] for row in cold}) == COLD.points


@pytest.mark.parametrize("direction", ["up", "both"])
def test_a_following_sweep_is_the_local_one_to_the_bit(cluster: Cluster, system: System, direction: Any) -> None:
    plan = Plan("frequency", 0.5, 1.9, 40, direction, transient=30, periods=48)
    with connected(cluster.address) as workers:
        assert rows(system, plan, workers=workers) == rows(system, plan)


def test_a_map_and_its_machines_are_the_local_ones_to_the_bit(cluster: Cluster, system: System) -> None:
    asked: Any = {"speeds": np.linspace(60.0, 150.0, 20), "loads": [100.0, 300.0], "transient": 30, "periods": 48}
    with connected(cluster.address) as workers:
        nominal = RegimeMap.compute(system, **asked, workers=workers)
        drawn = with_tolerances(nominal, system, samples=2, seed=5, workers=workers)
    expected = RegimeMap.compute(system, **asked)
    for name in ("codes", "period", "lyapunov", "contact_loss", "force_max", "chaos"):
        assert np.array_equal(getattr(nominal, name), getattr(expected, name), equal_nan=True), name
    assert np.array_equal(drawn.chaos, with_tolerances(expected, system, samples=2, seed=5).chaos)


def test_the_loss_of_a_worker_in_mid_sweep_changes_nothing(
    cluster: Cluster, system: System, cold: list[tuple[object, ...]]
) -> None:
    with connected(cluster.address) as found:
        workers = DaskWorkers(found._client, cluster.address, block=16)
        with closing(sweep_each(system, COLD, lines, workers=workers)) as sweep:
            got = [content(next(sweep))]
            # 25 blocks, of which no more than 3 for each of two threads have been handed over and one was given back.
            cluster.kill(cluster.workers[0])
            got += [content(each) for each in sweep]
        assert list(found._client.nthreads().values()) == [1]
    assert got == cold


def test_the_loss_of_a_worker_in_mid_chain_changes_nothing(cluster: Cluster, system: System) -> None:
    with (
        connected(cluster.address) as workers,
        closing(sweep_each(system, BOTH, lines, workers=workers)) as sweep,
    ):
        got = [content(next(sweep))]
        cluster.kill(cluster.workers[1])
        got += [content(each) for each in sweep]
    assert got == rows(system, BOTH)


def test_when_all_workers_stay_away_it_says_so_and_goes_on_later(
    cluster: Cluster, system: System, cold: list[tuple[object, ...]]
) -> None:
    got = []
    with connected(cluster.address) as found:
        workers = DaskWorkers(found._client, cluster.address, block=16, patience=0.1)
        with closing(sweep_each(system, COLD, lines, workers=workers)) as sweep:
            got.append(content(next(sweep)))
            for worker in list(cluster.workers):
                cluster.kill(worker)
            with pytest.raises(ClusterError, match=r"has had no worker for 0.1 s; start workers .* goes on where"):
                got.extend(content(each) for each in sweep)
    cluster.start()
    with connected(cluster.address) as again:
        got += rows(system, COLD, workers=again, begun=Begun(len(got)))
    assert got == cold


def test_a_worker_that_comes_while_there_is_none_is_waited_for(
    cluster: Cluster, system: System, cold: list[tuple[object, ...]]
) -> None:
    with connected(cluster.address) as workers, closing(sweep_each(system, COLD, lines, workers=workers)) as sweep:
        got = [content(next(sweep))]
        for worker in list(cluster.workers):
            cluster.kill(worker)
        cluster.start()
        assert got + [content(each) for each in sweep] == cold


def test_the_loss_of_the_scheduler_is_one_sentence(make_cluster: MakeCluster, system: System) -> None:
    own = make_cluster(1)
    with (
        connected(own.address) as workers,
        closing(sweep_each(system, COLD, lines, workers=workers)) as sweep,
    ):
        next(sweep)
        own.scheduler.kill()
        with pytest.raises(ClusterError, match=rf"^The scheduler at {own.address} was lost; start it"):
            list(sweep)


@pytest.fixture(scope="module")
def edited(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A copy of the package, one file of which has been edited, as a path for Python to look at first."""
    folder = tmp_path_factory.mktemp("edited")
    shutil.copytree(PACKAGE, folder / "seat_gear_dynamics", ignore=shutil.ignore_patterns("__pycache__"))
    with (folder / "seat_gear_dynamics" / "regimes" / "exponent.py").open("a") as file:
        file.write("# another exponent\n")
    return str(folder)


def test_a_worker_with_other_code_is_refused(cluster: Cluster, edited: str) -> None:
    cluster.start(PYTHONPATH=edited)
    sentence = r"^The worker tcp://.* has sources \w{12}, expected \w{12}: its numbers may differ; install the same"
    with pytest.raises(ClusterError, match=sentence), connected(cluster.address):
        pytest.fail("connected")


def test_a_worker_with_other_code_that_joins_later_is_refused(cluster: Cluster, system: System, edited: str) -> None:
    with connected(cluster.address) as workers:
        cluster.start(PYTHONPATH=edited)
        for worker in cluster.workers[:2]:  # so that every block goes to the third
            cluster.kill(worker)
        sentence = rf"^In the cluster at {cluster.address} a worker that joined later has sources \w+, expected \w+;"
        with pytest.raises(ClusterError, match=sentence):
            rows(system, COLD, workers=workers)


def test_a_worker_without_the_package_is_refused(cluster: Cluster, tmp_path: Path) -> None:
    (tmp_path / "seat_gear_dynamics").mkdir()
    (tmp_path / "seat_gear_dynamics" / "__init__.py").write_text("")
    cluster.start(PYTHONPATH=str(tmp_path))
    sentence = r"^The worker tcp://.* cannot load seat_gear_dynamics \(.*\); install the same version"
    with pytest.raises(ClusterError, match=sentence), connected(cluster.address):
        pytest.fail("connected")


class Told:
    """A Dask client that tells of workers that are not there."""

    status = "running"

    def __init__(self, *builds: object) -> None:
        self._builds = builds

    def wait_for_workers(self, count: int, timeout: float) -> None:
        if len(self._builds) < count:
            raise TimeoutError

    def run(self, *_: object, **__: object) -> dict[str, object]:
        return {f"tcp://{number}": found for number, found in enumerate(self._builds)}


class Slow:
    """A block that is not there when it is first waited for, and is a moment later."""

    def __init__(self, status: str, ended: Callable[[], object]) -> None:
        self.status, self._ended, self._asked = status, ended, 0

    def result(self, timeout: float | None = None) -> object:
        self._asked += 1
        if timeout is not None and self._asked == 1:
            raise TimeoutError
        return self._ended()


def raising(error: Exception) -> Callable[[], object]:
    def ended() -> object:
        raise error

    return ended


class Submitting(Told):
    """A Dask client that gives out the block it was made with."""

    def __init__(self, block: Slow) -> None:
        super().__init__(build())
        self._block = block

    def submit(self, *_: object, **__: object) -> Slow:
        return self._block

    def nthreads(self) -> dict[str, int]:
        return {"tcp://0": 1}


def test_a_block_that_is_done_just_after_it_was_waited_for_is_read() -> None:
    workers = DaskWorkers(Submitting(Slow("finished", lambda: 7)), "tcp://a:1")
    assert list(workers.compute(math.sqrt, [4.0])) == [7]


@pytest.mark.parametrize("error", [ValueError("wrong"), TimeoutError("its own")])
def test_a_block_that_fails_just_after_it_was_waited_for_says_why(error: Exception) -> None:
    workers = DaskWorkers(Submitting(Slow("error", raising(error))), "tcp://a:1")
    with pytest.raises(type(error), match=str(error)):
        list(workers.compute(math.sqrt, [4.0]))


def test_workers_may_all_be_of_another_processor_than_this_machine() -> None:
    other = {**build(), "processor": "other", "C library": "another"}
    assert DaskWorkers(Told(other, dict(other)), "tcp://a:1").build == other


@pytest.mark.parametrize(
    ("builds", "sentence"),
    [
        ((build(), {**build(), "processor": "other"}), r"^The worker tcp://1 has processor other, expected "),
        ((build(), {**build(), "C library": "other"}), r"^The worker tcp://1 has C library other, expected "),
        (({**build(), "numpy": "0.1"},), r"^The worker tcp://0 has numpy 0.1, expected "),
        (({**build(), "package": "9.9"},), r"^The worker tcp://0 has package 9.9, expected "),
        ((ModuleNotFoundError("No module named 'x'"),), r"^The worker tcp://0 cannot load .*No module named 'x'"),
        (
            (),
            r"^The scheduler at tcp://a:1 has no worker, and none came within 0.2 s; start one: dask worker tcp://a:1$",
        ),
    ],
)
def test_workers_that_may_give_other_numbers_are_refused(builds: tuple[object, ...], sentence: str) -> None:
    with pytest.raises(ClusterError, match=sentence):
        DaskWorkers(Told(*builds), "tcp://a:1", patience=0.2)


@pytest.fixture
def mute() -> Iterator[str]:
    """The address of something that listens and never answers."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}"


def test_an_address_where_nobody_is_or_answers_is_one_sentence(mute: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        closed = f"tcp://127.0.0.1:{server.getsockname()[1]}"
    for address in (mute, closed):
        sentence = f"No Dask scheduler answered at '{address}' within 0.5 s; check the address"
        with pytest.raises(ClusterError, match=re.escape(sentence)), connected(address, timeout=0.5):
            pytest.fail("connected")


@pytest.mark.parametrize("address", ["nowhere", "127.0.0.1", "carrier-pigeon://127.0.0.1:8786", ""])
def test_what_is_no_address_is_one_sentence(address: str) -> None:
    with pytest.raises(ClusterError, match=r"expected one as tcp://HOST:8786") as refused, connected(address):
        pytest.fail("connected")
    assert "\n" not in str(refused.value)


def test_without_the_package_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    remedy = r"needs the package distributed, which is not installed; .* pip install 'seat_gear_dynamics\[cluster\]'"
    with pytest.raises(ClusterError, match=remedy), connected("tcp://127.0.0.1:1"):
        pytest.fail("connected")


def test_blocks_are_whole_lanes_and_leave_no_thread_of_a_short_study_idle(cluster: Cluster) -> None:
    with connected(cluster.address) as workers:
        assert [workers.share(points) for points in (1, 17, 400, 10**9)] == [16, 16, 64, BLOCK]


def test_few_blocks_are_taken_ahead_of_what_is_read(cluster: Cluster) -> None:
    taken = []

    def endless() -> Iterator[float]:
        for number in count():
            taken.append(number)
            yield float(number)

    with connected(cluster.address) as workers:
        with closing(workers.compute(math.sqrt, endless())) as found:
            assert [next(found) for _ in range(20)] == [math.sqrt(number) for number in range(20)]
        assert len(taken) <= 20 + 3 * 2
        # What was read or called off is held nowhere in the cluster.
        assert not workers._client.futures


def test_an_error_of_the_work_reaches_the_reader(cluster: Cluster) -> None:
    with (
        connected(cluster.address) as workers,
        closing(workers.compute(math.sqrt, [4.0, -1.0, 9.0])) as found,
    ):
        assert next(found) == 2.0
        with pytest.raises(ValueError, match="math domain error"):
            next(found)
