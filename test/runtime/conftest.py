"""What the tests of the bundled runtime share: domains of their own, nodes, spinning, and other processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from domains import fresh_domain
from programs import PATIENCE, MakeNode, Program, Run, SpinUntil

from seat_gear_dynamics.runtime.context import Context
from seat_gear_dynamics.runtime.executor import SingleThreadedExecutor
from seat_gear_dynamics.runtime.node import Node


@pytest.fixture
def domain_id() -> int:
    """The test's DDS domain."""
    return fresh_domain()


@pytest.fixture
def context(domain_id: int) -> Iterator[Context]:
    """A started context in a domain of its own."""
    made = Context()
    made.init([], domain_id=domain_id)
    yield made
    made.try_shutdown()
    made.destroy()


@pytest.fixture
def make_node(context: Context) -> Iterator[MakeNode]:
    """Makes nodes, without parameter services unless asked for, and destroys them."""
    made: list[Node] = []

    def make(name: str = "node", **options: Any) -> Node:
        options = {"context": context, "start_parameter_services": False, **options}
        made.append(Node(name, **options))
        return made[-1]

    yield make
    for node in made:
        node.destroy_node()


@pytest.fixture
def executor(context: Context) -> Iterator[SingleThreadedExecutor]:
    """An executor in the test's context."""
    with SingleThreadedExecutor(context=context) as made:
        yield made  # type: ignore[misc]


@pytest.fixture
def spin_until(executor: SingleThreadedExecutor) -> SpinUntil:
    """Spins until something is true."""

    def spin(condition: Callable[[], Any]) -> None:
        end = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > end:
                pytest.fail("what the test waits for did not happen")
            executor.spin_once(timeout_sec=0.02)

    return spin


@pytest.fixture
def run(domain_id: int) -> Iterator[Run]:
    """Starts programs in the test's domain and ends those still running."""
    programs: list[Program] = []

    def start(text: str, *arguments: str, **environment: str) -> Program:
        programs.append(Program(text, domain_id, *arguments, **environment))
        return programs[-1]

    yield start
    for program in programs:
        if program.process.poll() is None:
            program.process.kill()
            program.process.wait()
