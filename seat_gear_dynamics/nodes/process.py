"""Running one node as a process: arguments in, clean end on SIGINT and SIGTERM, an exit code out."""

import signal
import sys
from collections.abc import Callable, Sequence

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node


class StartError(RuntimeError):
    """A node that cannot start; its text is one sentence for the person who started it."""


def run(make: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Make a node, spin it until it is told to end, close it, and return 0, or 1 when it could not start.

    A node may have a method `close`, which is called once, also after an error.
    """
    node: Node | None = None
    # rclpy shuts its context down on SIGINT as on SIGTERM and then calls the handler that was there before. Python's
    # would raise KeyboardInterrupt at any line, also amid a compilation or a write to the log; this one lets that line
    # finish, and the end comes through the context alone.
    signal.signal(signal.SIGINT, lambda number, frame: None)
    try:
        rclpy.init(args=list(args) if args is not None else None)
        executor = SingleThreadedExecutor()  # before the node speaks: rclpy cannot make one amid a shutdown
        node = make()
        rclpy.spin(node, executor)
    except ExternalShutdownException:
        pass
    except StartError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except Exception:
        # The context may go amid a callback, whose next publish then fails: that is the end that was asked for.
        # Anything raised while the context stands is a fault.
        if rclpy.ok():
            raise
    finally:
        if node is not None:
            close = getattr(type(node), "close", None)
            if close is not None:
                close(node)
            node.destroy_node()
        rclpy.try_shutdown()
    return 0
