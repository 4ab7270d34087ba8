"""Calls the recorder's services and reads what it says of itself."""

from typing import Any

from harness import Peer

STATUS = "bench_recorder: recording"


class Control:
    """A client of the recorder, through a peer's node."""

    def __init__(self, peer: Peer) -> None:
        self._peer = peer

    def call(self, name: str) -> Any:
        """Call a service and return its answer."""
        from std_srvs.srv import Trigger

        client = self._peer.node.create_client(Trigger, f"/bench_recorder/{name}")
        self._peer.wait(client.service_is_ready, f"the service {name}")
        future = client.call_async(Trigger.Request())
        self._peer.wait(future.done, f"the answer of {name}")
        return future.result()

    def wait_count(self, key: str, number: int) -> None:
        """Wait until a count of the recorder, such as `motor/speed written`, is at least so many."""
        self._peer.wait(lambda: int(self.values().get(key, "0")) >= number, f"{key} of {number}")

    def wait_received(self, number: int) -> None:
        """Wait until the recorder says that it has received so many speeds."""
        self.wait_count("motor/speed received", number)

    def wait_level(self, level: int, text: str) -> None:
        """Wait until the recorder's status has a level, and a text that contains another."""
        self._peer.wait(lambda: self.level() == level and text in self.text(), f"level {level} with {text!r}")

    def values(self) -> dict[str, str]:
        """Return the values of the last status, empty before one."""
        status = self._status()
        return {v.key: v.value for v in status.values} if status is not None else {}

    def level(self) -> int | None:
        """Return the level of the last status."""
        status = self._status()
        return status.level[0] if status is not None else None

    def text(self) -> str:
        """Return the text of the last status."""
        status = self._status()
        return str(status.message) if status is not None else ""

    def _status(self) -> Any:
        for array in reversed(self._peer.messages["/diagnostics"]):
            for status in array.status:
                if status.name == STATUS:
                    return status
        return None
