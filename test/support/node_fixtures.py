"""Fixtures of tests with nodes as real processes: a domain of their own, processes, and a peer that talks to them."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from domains import fresh_domain
from harness import Peer, Processes

import seat_gear_dynamics.nodes  # noqa: F401  (makes rclpy importable)


@pytest.fixture
def domain_id(monkeypatch: pytest.MonkeyPatch) -> int:
    """The test's DDS domain, which the processes that it starts inherit."""
    number = fresh_domain()
    monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
    return number


@pytest.fixture
def processes(domain_id: int, tmp_path: Path) -> Iterator[Processes]:
    """Start nodes as processes on the test's domain."""
    folder = tmp_path / "words"
    folder.mkdir()
    started = Processes(folder)
    yield started
    started.close()


@pytest.fixture
def peer(domain_id: int) -> Iterator[Peer]:
    """A node in this process on the test's domain."""
    import rclpy

    rclpy.init(args=[], domain_id=domain_id)
    try:
        made = Peer()
        yield made
        made.node.destroy_node()
    finally:
        rclpy.try_shutdown()
