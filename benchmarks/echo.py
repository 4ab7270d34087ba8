"""The least that a node can do: answer each Float64 on `ping` with the same on `pong`. `benchmarks.latency` asks it."""

import seat_gear_dynamics.nodes  # noqa: F401  (makes rclpy importable)

# isort: split
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

PING, PONG = "ping", "pong"
DEPTH = 10


def main() -> None:
    """Echo until interrupted."""
    rclpy.init()
    node = Node("echo")
    answers = node.create_publisher(Float64, PONG, QoSProfile(depth=DEPTH))
    node.create_subscription(Float64, PING, answers.publish, QoSProfile(depth=DEPTH))
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
