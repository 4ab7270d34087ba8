"""The model's state as a message: what lets a replay begin amid a run."""

from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from seat_gear_dynamics.logs.topics import ORIGIN_NAMES
from seat_gear_dynamics.nodes import messages
from seat_gear_dynamics.sensing import Session
from seat_gear_dynamics.sensing.virtual_sensor import SENSOR_STATE_NAMES

_NAMES = [*SENSOR_STATE_NAMES, *ORIGIN_NAMES]


class StateTicker:
    """Says when the model's state is due, by the samples' own stamps, and makes its message."""

    def __init__(self, period: float) -> None:
        self._last_ns: int | None = None
        self.pace(period)

    def pace(self, period: float) -> None:
        """Let so many seconds lie between two states from now on."""
        self._period_ns = int(period * 1e9)

    def due(self, stamp_ns: int) -> bool:
        """Return whether a state of this stamp is due: after a period, or when stamps have stepped back."""
        if self._last_ns is not None and abs(stamp_ns - self._last_ns) < self._period_ns:
            return False
        self._last_ns = stamp_ns
        return True


def model_state(stamp_ns: int, origin_ns: int, session: Session) -> JointState:
    """Return the state of `session` after the sample of `stamp_ns`.

    `origin_ns` is the stamp of t = 0. Take the force windows first: the message does not carry them.
    """
    state = session.sensor.state
    assert state is not None, "a stamp means that there was a sample"
    positions = [*state.tolist(), float(origin_ns // 1_000_000_000), float(origin_ns % 1_000_000_000)]
    return JointState(header=Header(stamp=messages.stamp(stamp_ns)), name=_NAMES, position=positions)
