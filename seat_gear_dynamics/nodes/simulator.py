"""The simulator node: a seat-ECU bench that plays a profile on the input topics."""

from collections.abc import Sequence

from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Header

from seat_gear_dynamics.bench.drive import SimulatedBench
from seat_gear_dynamics.bench.errors import BenchError
from seat_gear_dynamics.bench.profiles import DEFAULT, PROFILES, profile
from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.nodes.parameters import Parameter, declare
from seat_gear_dynamics.nodes.process import StartError, run

NAME = "bench_simulator"
JOINT = "seat_height"

PARAMETERS = (
    Parameter("profile", DEFAULT, f"what the bench plays: {', '.join(PROFILES)}"),
    Parameter("rate", 50.0, "samples a second, Hz", 1.0, 2000.0),
    Parameter("motor_time_constant", 0.08, "lag of the motor behind its command, s", 0.0, 10.0),
    Parameter("hall_pulses", 3000, "Hall-sensor increments per revolution of s1", 1, 1_000_000),
    Parameter("speed_noise_rpm", 0.5, "noise of the measured speed, r/min rms", 0.0, 1000.0),
    Parameter("load_noise", 5.0, "noise of the measured load, N·m rms", 0.0, 1000.0),
    Parameter("seed", 0, "seed of the noise", 0, 2**31 - 1),
)


class Simulator(Node):
    """Publishes one sample a tick on both topics and, stamped, as a joint state."""

    def __init__(self) -> None:
        super().__init__(NAME)
        get = declare(self, PARAMETERS).__getitem__
        self._period_ns = round(1e9 / get("rate"))
        try:
            self._bench = SimulatedBench(
                profile(get("profile")),
                sample_time=1.0 / get("rate"),
                motor_time_constant=get("motor_time_constant"),
                hall_pulses_per_revolution=get("hall_pulses"),
                speed_noise=get("speed_noise_rpm") * RPM,
                load_noise=get("load_noise"),
                seed=get("seed"),
            )
        except BenchError as error:
            raise StartError(str(error)) from error
        self._speed = self.create_publisher(Float64, topics.MOTOR_SPEED.name, QoSProfile(depth=10))
        self._load = self.create_publisher(Float64, topics.LOAD_TORQUE.name, QoSProfile(depth=10))
        self._joint_states = self.create_publisher(JointState, topics.JOINT_STATES.name, QoSProfile(depth=10))
        self._begin_ns = self.get_clock().now().nanoseconds
        self._played = 0
        self.create_timer(1.0 / get("rate"), self._on_tick)
        self.get_logger().info(f"playing {get('profile')}")

    def _on_tick(self) -> None:
        """Play every sample that is due, so that a late tick shifts no time, and publish the newest."""
        now = self.get_clock().now().nanoseconds
        due = max((now - self._begin_ns) // self._period_ns, self._played + 1)
        while self._played < due:
            sample = self._bench.step()
            self._played += 1
        # Load first: a speed is taken together with the load that came before it.
        self._load.publish(Float64(data=sample.load))
        self._speed.publish(Float64(data=sample.speed))
        self._joint_states.publish(
            JointState(
                header=Header(stamp=messages.stamp(now)), name=[JOINT], velocity=[sample.speed], effort=[sample.load]
            )
        )


def main(args: Sequence[str] | None = None) -> int:
    """Run the simulator; returns its exit code."""
    return run(Simulator, args)


if __name__ == "__main__":
    raise SystemExit(main())
