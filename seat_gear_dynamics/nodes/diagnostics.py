"""Diagnostics as tasks: each has a name and fills in a status; levels merge by maximum, and keys carry their units."""

from collections.abc import Callable, Iterable, Mapping
from typing import Protocol

from diagnostic_msgs.msg import DiagnosticStatus

from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.sensing import Level


class Status:
    """What tasks say: a level, a text and values. One that nobody filled in is an error of the node itself."""

    def __init__(self) -> None:
        self.level = Level.ERROR
        self.text = "no message was set"
        self.values: dict[str, object] = {}
        self._said = False

    def say(self, level: Level, text: str, values: Mapping[str, object] | None = None) -> None:
        """Merge in a level and its text: the worst level keeps its texts, in the order they came."""
        self.values.update(values or {})
        if not self._said or level > self.level:
            self.level, self.text, self._said = level, text, True
        elif level == self.level and level != Level.OK:
            self.text = f"{self.text}; {text}"


class Task(Protocol):
    """One part of a node's health."""

    name: str

    def run(self, status: Status) -> None:
        """Say how the part does, since this was last called."""
        ...


class Composite:
    """Several tasks that are one status."""

    def __init__(self, name: str, tasks: Iterable[Task]) -> None:
        self.name = name
        self._tasks = tuple(tasks)

    def run(self, status: Status) -> None:
        """Let each task have its say."""
        for task in self._tasks:
            task.run(status)


class Updater:
    """Runs tasks and makes their messages; `prefix` names the node, which has to be unique on the network."""

    def __init__(self, prefix: str, tasks: Iterable[Task]) -> None:
        self._prefix, self._tasks = prefix, tuple(tasks)

    def update(self) -> list[DiagnosticStatus]:
        """Return a status of each task."""
        return [self._status(task.name, task.run) for task in self._tasks]

    def _status(self, name: str, run: Callable[[Status], None]) -> DiagnosticStatus:
        status = Status()
        run(status)
        return messages.status(status.level, f"{self._prefix}: {name}", status.text, status.values)
