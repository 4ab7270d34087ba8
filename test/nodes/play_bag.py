"""Publishes a bag's speed and load over DDS at their recorded pace, byte for byte, once somebody listens to both."""

import sys
from time import monotonic, sleep

import seat_gear_dynamics.nodes  # noqa: F401  (makes rclpy importable)

# isort: split
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from seat_gear_dynamics.logs.reader import Bag


def main(path: str) -> None:
    rclpy.init(args=[])
    node = Node("bag_player")
    bag = Bag(path)
    publishers = {
        bag.resolve(name): node.create_publisher(Float64, name, QoSProfile(depth=100))
        for name in ("motor/speed", "load/torque")
    }
    begin = monotonic()
    while any(p.get_subscription_count() < 2 for p in publishers.values()):  # the monitor and the recorder
        if monotonic() - begin > 60:
            sys.exit("nobody listened within 60 s")
        rclpy.spin_once(node, timeout_sec=0.05)
    begin = monotonic()
    for message in bag.messages(list(publishers)):
        due = begin + (message.publish_time_ns - bag.start_ns) * 1e-9
        sleep(max(0.0, due - monotonic()))
        publishers[message.topic].publish(message.data)
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main(sys.argv[1])
