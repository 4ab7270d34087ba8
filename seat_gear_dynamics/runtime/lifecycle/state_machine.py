"""The state machine of a managed node: primary states, transition states, and the ways between them.

States, transitions and their numbers are those of lifecycle_msgs and of ROS 2's rcl_lifecycle; the picture is in
the design article "Managed nodes", https://design.ros2.org/articles/node_lifecycle.html.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import NamedTuple

from seat_gear_dynamics.runtime.exceptions import RCLError

SHUTDOWN = "shutdown"
"""Label of the three transitions that end a node, one from each primary state but the last."""


class LifecycleState(NamedTuple):
    """A state by its label and its number in lifecycle_msgs/State."""

    label: str
    state_id: int


class Transition(NamedTuple):
    """A way from one state to another, numbered as in lifecycle_msgs/Transition."""

    transition_id: int
    label: str
    start: LifecycleState
    goal: LifecycleState


class TransitionCallbackReturn(Enum):
    """What a transition callback says of its work, numbered as in lifecycle_msgs/Transition."""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99

    def to_label(self) -> str:
        """Return the label of the transition that follows."""
        return f"transition_{self.name.lower()}"

    def __int__(self) -> int:
        return self.value


_STATES = {
    state.label: state
    for state in (
        LifecycleState("unknown", 0),
        LifecycleState("unconfigured", 1),
        LifecycleState("inactive", 2),
        LifecycleState("active", 3),
        LifecycleState("finalized", 4),
        LifecycleState("configuring", 10),
        LifecycleState("cleaningup", 11),
        LifecycleState("shuttingdown", 12),
        LifecycleState("activating", 13),
        LifecycleState("deactivating", 14),
        LifecycleState("errorprocessing", 15),
    )
}

_ERROR = "errorprocessing"
_REQUESTS: tuple[tuple[str, dict[str, int], str, tuple[str, str, str], int], ...] = (
    # Label, the primary states it may come in with its number there, the state it leads through, and where success,
    # failure and error lead from that one, numbered from the last value on.
    ("configure", {"unconfigured": 1}, "configuring", ("inactive", "unconfigured", _ERROR), 10),
    ("cleanup", {"inactive": 2}, "cleaningup", ("unconfigured", "inactive", _ERROR), 20),
    ("activate", {"inactive": 3}, "activating", ("active", "inactive", _ERROR), 30),
    ("deactivate", {"active": 4}, "deactivating", ("inactive", "active", _ERROR), 40),
    (SHUTDOWN, {"unconfigured": 5, "inactive": 6, "active": 7}, "shuttingdown", ("finalized", "finalized", _ERROR), 50),
    ("", {}, _ERROR, ("unconfigured", "finalized", "finalized"), 60),
)


def _all_transitions() -> tuple[Transition, ...]:
    """Return every transition, in the order rcl_lifecycle registers them."""
    found: list[Transition] = []
    for label, starts, through, goals, first in _REQUESTS:
        found.extend(Transition(number, label, _STATES[s], _STATES[through]) for s, number in starts.items())
        outcomes = zip(TransitionCallbackReturn, goals, strict=True)
        found.extend(
            Transition(first + index, outcome.to_label(), _STATES[through], _STATES[goal])
            for index, (outcome, goal) in enumerate(outcomes)
        )
    return tuple(found)


STATES = tuple(_STATES.values())
"""Every state there is."""

TRANSITIONS = _all_transitions()
"""Every transition there is."""

Row = tuple[int, str, int, str, int, str]
"""A transition as rclpy gives it: its number and label, those of its start, those of its goal."""


def row(transition: Transition) -> Row:
    """Return a transition as rclpy gives it."""
    start, goal = transition.start, transition.goal
    return transition.transition_id, transition.label, start.state_id, start.label, goal.state_id, goal.label


class StateMachine:
    """Where one node stands, and what may come next; it starts unconfigured.

    The properties have the names and forms of the one rclpy's lifecycle node keeps as `_state_machine`, since rclpy
    has no other way to ask a node for its own state.
    """

    initialized = True

    def __init__(self, announce: Callable[[Transition], None] | None = None) -> None:
        self._state = _STATES["unconfigured"]
        self._announce = announce

    @property
    def state(self) -> LifecycleState:
        """Where the node stands."""
        return self._state

    @property
    def current_state(self) -> tuple[int, str]:
        """Number and label of the state the node is in."""
        return self._state.state_id, self._state.label

    @property
    def available_states(self) -> list[tuple[int, str]]:
        """Number and label of every state there is."""
        return [(state.state_id, state.label) for state in STATES]

    @property
    def available_transitions(self) -> list[Row]:
        """Every transition out of the present state."""
        return [row(transition) for transition in TRANSITIONS if transition.start == self._state]

    @property
    def transition_graph(self) -> list[Row]:
        """Every transition there is."""
        return [row(transition) for transition in TRANSITIONS]

    def get_transition_by_label(self, label: str) -> int:
        """Return the number of the transition with a label out of the present state.

        Raises:
            RCLError: there is none.
        """
        return self._find(label).transition_id

    def require(self, transition_id: int) -> None:
        """Refuse a transition that is not possible in the present state.

        Raises:
            RCLError: it is not; what is possible is in the text.
        """
        self._find(transition_id)

    def trigger_transition_by_id(self, transition_id: int, publish_update: bool = True) -> None:
        """Take a transition out of the present state, and announce it unless told not to.

        Raises:
            RCLError: there is no such transition; the state stays.
        """
        self._take(self._find(transition_id), publish_update)

    def trigger_transition_by_label(self, label: str, publish_update: bool = True) -> None:
        """Take a transition by its label; see `trigger_transition_by_id`."""
        self._take(self._find(label), publish_update)

    def _find(self, wanted: int | str) -> Transition:
        ways = [transition for transition in TRANSITIONS if transition.start == self._state]
        for transition in ways:
            if wanted in (transition.transition_id, transition.label):
                return transition
        possible = ", ".join(f"{way.label} ({way.transition_id})" for way in ways) or "none"
        raise RCLError(
            f"Failed to trigger lifecycle state machine transition: {wanted!r} is not possible in state "
            f"{self._state.label!r}; possible are: {possible}."
        )

    def _take(self, transition: Transition, publish_update: bool) -> None:
        self._state = transition.goal
        if publish_update and self._announce is not None:
            self._announce(transition)
