"""The monitor node, managed: measured speed and load in; forces, section, warning and trip signal out."""

import traceback
from collections.abc import Sequence
from typing import Any

from rclpy.clock import JumpThreshold
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, State, TransitionCallbackReturn
from std_srvs.srv import Trigger

from seat_gear_dynamics.nodes.monitor_parameters import PARAMETERS
from seat_gear_dynamics.nodes.monitor_watch import Watch
from seat_gear_dynamics.nodes.parameters import Parameters
from seat_gear_dynamics.nodes.process import StartError, run

NAME = "gear_monitor"

_SUCCESS, _FAILURE, _ERROR = (
    TransitionCallbackReturn.SUCCESS,
    TransitionCallbackReturn.FAILURE,
    TransitionCallbackReturn.ERROR,
)


class Monitor(LifecycleNode):
    """Configures, starts and stops a `Watch`, by itself at first where `autostart` says so.

    Raises StartError from its constructor for a parameter that cannot be, and where it configures itself and cannot.
    """

    def __init__(self, **options: Any) -> None:
        """Take options of rclpy's Node, such as namespace and context."""
        super().__init__(NAME, **options)
        self._watch: Watch | None = None
        self._active = False
        self._refusal = ""
        self._settings = Parameters(self, PARAMETERS, locked=self._locked, applied=self._on_parameters)
        self.create_service(Trigger, "~/reset", self._on_reset)
        backward = JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1), on_clock_change=True)
        self._jumps = self.get_clock().create_jump_callback(backward, post_callback=self._on_jump)
        if self._settings["autostart"]:
            self._start()

    def _start(self) -> None:
        if self.trigger_configure() != _SUCCESS or self.trigger_activate() != _SUCCESS:
            raise StartError(self._refusal or "The monitor could not be started; its log says why.")

    def on_configure(self, state: State) -> TransitionCallbackReturn:
        """Load system and map, compile, and take the topics; a sentence in the log says why that cannot be."""
        try:
            self._watch = Watch(self, self._settings)
        except StartError as error:
            self._refusal = str(error)
            if not self._settings["autostart"]:  # else the one who started the node is told by its end
                self.get_logger().error(self._refusal)
            return _FAILURE
        except Exception:
            self.get_logger().error(f"configuring failed:\n{traceback.format_exc()}")  # rclpy would not tell
            return _ERROR
        self.get_logger().info("configured")
        return super().on_configure(state)

    def on_activate(self, state: State) -> TransitionCallbackReturn:
        """Let the publishers speak and begin to watch."""
        said = super().on_activate(state)
        if self._watch is not None and said == _SUCCESS:
            self._watch.start()
            self._active = True
            self.get_logger().info("ready")
        return said

    def on_deactivate(self, state: State) -> TransitionCallbackReturn:
        """Say the last words and fall silent."""
        self._fall_silent()
        return super().on_deactivate(state)

    def on_cleanup(self, state: State) -> TransitionCallbackReturn:
        """Give model, topics and timers back."""
        said = super().on_cleanup(state)
        self._give_back()
        return said

    def on_shutdown(self, state: State) -> TransitionCallbackReturn:
        """Fall silent and give everything back, from whatever state."""
        self._fall_silent()
        super().on_deactivate(state)  # rclpy's publishers would go on
        said = super().on_shutdown(state)
        self._give_back()
        return said

    def on_error(self, state: State) -> TransitionCallbackReturn:
        """Give everything back after a transition that failed halfway: the node is then unconfigured."""
        super().on_deactivate(state)
        self._active = False
        self._give_back()
        return _SUCCESS

    def _fall_silent(self) -> None:
        if self._watch is not None and self._active:
            self._watch.stop()
        self._active = False

    def _give_back(self) -> None:
        if self._watch is not None:
            self._watch.close()
        self._watch = None

    def _locked(self) -> str | None:
        if self._watch is None:
            return None
        return "it is active, deactivate it and clean it up first" if self._active else "clean it up first"

    def _on_parameters(self) -> None:
        if self._watch is not None:
            self._watch.adopt()

    def _on_jump(self, jump: Any) -> None:
        if self._watch is not None and self._active:
            self._watch.stepped_back()

    def _on_reset(self, request: Any, response: Any) -> Any:
        if self._watch is None:
            response.success, response.message = False, "there is no model: the node is not configured"
            return response
        self._watch.reset()
        response.success, response.message = True, "the model restarts with the next sample"
        return response


def main(args: Sequence[str] | None = None) -> int:
    """Run the monitor; returns its exit code."""
    return run(Monitor, args)


if __name__ == "__main__":
    raise SystemExit(main())
