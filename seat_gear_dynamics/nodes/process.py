"""Running one node as a process: arguments in, clean end on SIGINT and SIGTERM, an exit code out."""

import sys
from collections.abc import Callable, Sequence

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class StartError(RuntimeError):
    """A node that cannot start; its text is one sentence for the person who started it."""


def run(make: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Make a node, spin it until it is told to end, close it, and return 0, or 1 when it could not start.

    A node may have a method `close`, which is called once, also after an error.
    """
    node: Node | None = None
    try:
        # Inside the try: a signal may come at any moment from here on.
        rclpy.init(args=list(args) if args is not None else None)
        node = make()
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except StartError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    finally:
        if node is not None:
            close = getattr(type(node), "close", None)
            if close is not None:
                close(node)
            node.destroy_node()
        rclpy.try_shutdown()
    return 0
