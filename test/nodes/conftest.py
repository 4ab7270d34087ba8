"""Nodes as real processes on a domain of their own."""

import random
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import Peer, Processes

import seat_gear_dynamics.nodes  # noqa: F401  (makes rclpy importable)

_USED: set[int] = set()


@pytest.fixture
def domain_id(monkeypatch: pytest.MonkeyPatch) -> int:
    """A DDS domain that no test of this run has used, or once all were used, that none has used of late."""
    if len(_USED) > 80:
        _USED.clear()
    # Up to 99: the ports of those above lie where Linux takes the ports of outgoing traffic from, and may be taken.
    number = random.SystemRandom().choice([n for n in range(1, 100) if n not in _USED])
    _USED.add(number)
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
