"""The monitor seen from outside: its diagnostics, its state, transitions and parameters, and inputs at any pace."""

import math
import re
from collections.abc import Callable
from time import monotonic
from typing import Any

from harness import PATIENCE, Peer


def paced(
    peer: Peer, period: Callable[[], float], send: Callable[[], None], reached: Callable[[], bool], what: str
) -> None:
    """Send, with `period` s between one and the next, until `reached`, or fail; late sends are not made up for."""
    begin = due = monotonic()
    while not reached():
        now = monotonic()
        if now >= due:
            due = now + period()
            send()
        peer._spin_once(peer.node, timeout_sec=min(max(due - monotonic(), 0.0), 0.05))
        assert now - begin < PATIENCE, f"waited {PATIENCE} s for {what}"


class Health:
    """The diagnostics of a monitor as a peer hears them."""

    def __init__(self, peer: Peer, node: str = "gear_monitor") -> None:
        self._peer, self._node = peer, node
        self._since = 0

    def statuses(self, part: str) -> list[Any]:
        """Return the statuses of a part that came since `forget` was last called."""
        arrays = self._peer.messages["/diagnostics"][self._since :]
        return [status for array in arrays for status in array.status if status.name == f"{self._node}: {part}"]

    def forget(self) -> None:
        """Look only at what comes from now on."""
        self._since = len(self._peer.messages["/diagnostics"])

    def says(self, pattern: str, level: int | None = None, part: str = "input") -> bool:
        """Return whether a text with this pattern came, at this level."""
        found = (status for status in self.statuses(part) if level is None or status.level[0] == level)
        return any(re.search(pattern, status.message) for status in found)

    def value(self, key: str, part: str = "input") -> float:
        """Return the last value of a key; NaN before one came."""
        for status in reversed(self.statuses(part)):
            for value in status.values:
                if value.key == key:
                    return math.nan if value.value == "unknown" else float(value.value)
        return math.nan


class Managed:
    """Asks one node of the test's domain; every call waits for the answer."""

    def __init__(self, peer: Peer, name: str = "/gear_monitor") -> None:
        from lifecycle_msgs.srv import ChangeState, GetState
        from rcl_interfaces.srv import GetParameters, SetParametersAtomically

        self._peer, self.name = peer, name
        self._change = (ChangeState, peer.node.create_client(ChangeState, f"{name}/change_state"))
        self._state = (GetState, peer.node.create_client(GetState, f"{name}/get_state"))
        self._set = (
            SetParametersAtomically,
            peer.node.create_client(SetParametersAtomically, f"{name}/set_parameters_atomically"),
        )
        self._get = (GetParameters, peer.node.create_client(GetParameters, f"{name}/get_parameters"))

    def _ask(self, service: tuple[Any, Any], fill: dict[str, Any]) -> Any:
        kind, client = service
        self._peer.wait(client.service_is_ready, f"a service of {self.name}")
        request = kind.Request()
        for field, value in fill.items():
            setattr(request, field, value)
        future = client.call_async(request)
        self._peer.wait(future.done, f"an answer of {self.name}")
        return future.result()

    def state(self) -> str:
        """Return the label of the node's state."""
        return str(self._ask(self._state, {}).current_state.label)

    def change(self, transition: str) -> bool:
        """Ask for a transition by its label; return whether it was made."""
        from lifecycle_msgs.msg import Transition

        numbers = {"configure": 1, "cleanup": 2, "activate": 3, "deactivate": 4, "unconfigured_shutdown": 5}
        numbers |= {"inactive_shutdown": 6, "active_shutdown": 7}
        return bool(self._ask(self._change, {"transition": Transition(id=numbers[transition])}).success)

    def set(self, **values: object) -> Any:
        """Set parameters together; return the SetParametersResult."""
        from rclpy.parameter import Parameter

        given = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        return self._ask(self._set, {"parameters": given}).result

    def get(self, name: str) -> Any:
        """Return the message of one parameter's value."""
        return self._ask(self._get, {"names": [name]}).values[0]
