"""Dask clusters for tests: one of two workers for all, and own ones whose scheduler may be killed."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from dask_cluster import Cluster


@pytest.fixture(scope="session")
def two_workers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """A cluster of two workers; see `cluster`."""
    made = Cluster(tmp_path_factory.mktemp("cluster"))
    try:
        made.start(2)
        yield made
    finally:
        made.close()


@pytest.fixture
def cluster(two_workers: Cluster) -> Iterator[Cluster]:
    """A cluster of two workers, which a test may kill, and add others to."""
    before = list(two_workers.workers)
    yield two_workers
    added = [worker for worker in two_workers.workers if worker not in before]
    for worker in added:
        two_workers.kill(worker)
    two_workers.start(len(before) - len(two_workers.workers))
    two_workers.wait()


@pytest.fixture
def make_cluster(tmp_path: Path) -> Iterator[Callable[..., Cluster]]:
    """Make a cluster of the test's own, whose scheduler it may kill."""
    made: list[Cluster] = []

    def make(workers: int, *options: str, protocol: str = "tcp") -> Cluster:
        made.append(Cluster(tmp_path, *options, protocol=protocol))
        made[-1].start(workers)
        return made[-1]

    yield make
    for each in made:
        each.close()
