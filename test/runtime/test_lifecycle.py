"""Managed nodes: the state machine, its callbacks, what is silent when, and the services others drive it with."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from programs import SpinUntil

from seat_gear_dynamics.runtime.context import Context
from seat_gear_dynamics.runtime.exceptions import RCLError
from seat_gear_dynamics.runtime.lifecycle.managed_entity import ManagedEntity, SimpleManagedEntity
from seat_gear_dynamics.runtime.lifecycle.node import LifecycleNode
from seat_gear_dynamics.runtime.lifecycle.state_machine import (
    STATES,
    TRANSITIONS,
    LifecycleState,
    StateMachine,
    Transition,
    TransitionCallbackReturn,
)
from seat_gear_dynamics.runtime.messages import get_message

Float64 = get_message("std_msgs/msg/Float64")
SUCCESS, FAILURE, ERROR = TransitionCallbackReturn
PRIMARY = {"unconfigured", "inactive", "active", "finalized"}


class Worker(LifecycleNode):
    """A node whose callbacks do what they are told."""

    def __init__(self, context: Context, plan: dict[str, Any] | None = None, **options: Any) -> None:
        self.plan, self.seen = plan or {}, list[tuple[str, str]]()
        super().__init__("worker", context=context, start_parameter_services=False, **options)

    def do(self, name: str, state: LifecycleState) -> Any:
        self.seen.append((name, state.label))
        said = self.plan.get(name)
        if isinstance(said, Exception):
            raise said
        return getattr(super(), f"on_{name}")(state) if said is None else said

    def on_configure(self, state: LifecycleState) -> Any:
        return self.do("configure", state)

    def on_cleanup(self, state: LifecycleState) -> Any:
        return self.do("cleanup", state)

    def on_activate(self, state: LifecycleState) -> Any:
        return self.do("activate", state)

    def on_deactivate(self, state: LifecycleState) -> Any:
        return self.do("deactivate", state)

    def on_shutdown(self, state: LifecycleState) -> Any:
        return self.do("shutdown", state)

    def on_error(self, state: LifecycleState) -> Any:
        return self.do("error", state)

    @property
    def state(self) -> str:
        return self._state_machine.current_state[1]


@pytest.fixture
def worker(context: Context) -> Iterator[Worker]:
    node = Worker(context)
    yield node
    node.destroy_node()


def bring(node: Worker, *steps: str) -> list[TransitionCallbackReturn]:
    return [getattr(node, f"trigger_{step}")() for step in steps]


# The machine alone ----------------------------------------------------------------------------------------------------


def test_numbers_are_those_of_the_messages() -> None:
    state, transition = get_message("lifecycle_msgs/msg/State"), get_message("lifecycle_msgs/msg/Transition")
    named = {name.rpartition("_STATE_")[2].lower(): getattr(state, name) for name in dir(state) if "_STATE_" in name}
    assert {s.label: s.state_id for s in STATES} == named
    assert [outcome.value for outcome in TransitionCallbackReturn] == [
        transition.TRANSITION_CALLBACK_SUCCESS,
        transition.TRANSITION_CALLBACK_FAILURE,
        transition.TRANSITION_CALLBACK_ERROR,
    ]
    gerunds = {"configure": "configuring", "cleanup": "cleaningup", "activate": "activating"}
    gerunds |= {"deactivate": "deactivating", "shutdown": "shuttingdown", "error": "errorprocessing"}
    for request, through in gerunds.items():
        for outcome in TransitionCallbackReturn:
            number = getattr(transition, f"TRANSITION_ON_{request.upper()}_{outcome.name}")
            (way,) = (t for t in TRANSITIONS if t.transition_id == number)
            assert (way.start.label, way.label) == (through, outcome.to_label())
    for way in TRANSITIONS:
        if way.transition_id < 10:
            start = f"{way.start.label}_" if way.label == "shutdown" else ""
            assert getattr(transition, f"TRANSITION_{start}{way.label}".upper()) == way.transition_id


@given(st.lists(st.tuples(st.integers(0, 8), st.sampled_from(list(TransitionCallbackReturn))), max_size=30))
def test_every_walk_is_a_chain_that_rests_in_primary_states(steps: list[tuple[int, TransitionCallbackReturn]]) -> None:
    taken: list[Transition] = []
    machine = StateMachine(taken.append)
    for number, said in steps:
        before = machine.current_state
        if number not in (way[0] for way in machine.available_transitions):
            with pytest.raises(RCLError, match="is not possible in state"):
                machine.trigger_transition_by_id(number)
            assert machine.current_state == before
            continue
        machine.trigger_transition_by_id(number)
        machine.trigger_transition_by_label(said.to_label())
        if said is ERROR:
            machine.trigger_transition_by_label(said.to_label())
        assert machine.state.label in PRIMARY
    states = ["unconfigured", *(way.goal.label for way in taken)]
    assert [way.start.label for way in taken] == states[:-1]
    assert "finalized" not in states[:-1]


# The node -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("steps", "plan", "state", "last"),
    [
        (["configure"], {}, "inactive", SUCCESS),
        (["configure"], {"configure": FAILURE}, "unconfigured", FAILURE),
        (["configure"], {"configure": ERROR}, "unconfigured", ERROR),
        (["configure"], {"configure": ERROR, "error": FAILURE}, "finalized", ERROR),
        (["configure"], {"configure": ERROR, "error": ERROR}, "finalized", ERROR),
        (["configure"], {"configure": ERROR, "error": ValueError("x")}, "finalized", ERROR),
        (["configure", "cleanup"], {}, "unconfigured", SUCCESS),
        (["configure", "cleanup"], {"cleanup": FAILURE}, "inactive", FAILURE),
        (["configure", "activate"], {}, "active", SUCCESS),
        (["configure", "activate"], {"activate": FAILURE}, "inactive", FAILURE),
        (["configure", "activate", "deactivate"], {}, "inactive", SUCCESS),
        (["configure", "activate", "deactivate"], {"deactivate": FAILURE}, "active", FAILURE),
        (["configure", "activate", "deactivate"], {"deactivate": ValueError("x")}, "unconfigured", ERROR),
        (["shutdown"], {}, "finalized", SUCCESS),
        (["configure", "shutdown"], {"shutdown": FAILURE}, "finalized", FAILURE),
        (["configure", "activate", "shutdown"], {"shutdown": ERROR}, "unconfigured", ERROR),
    ],
)
def test_where_callbacks_lead(
    context: Context, steps: list[str], plan: dict[str, Any], state: str, last: TransitionCallbackReturn
) -> None:
    node = Worker(context, plan)
    assert bring(node, *steps)[-1] is last
    assert node.state == state
    node.destroy_node()


def test_callbacks_are_told_the_state_before(worker: Worker) -> None:
    worker.plan["deactivate"] = ERROR
    bring(worker, "configure", "activate", "deactivate")
    assert worker.seen == [
        ("configure", "unconfigured"),
        ("activate", "inactive"),
        ("deactivate", "active"),
        ("error", "active"),
    ]


def test_what_is_not_possible_is_an_error_that_says_what_is(worker: Worker) -> None:
    with pytest.raises(RuntimeError, match=r"3 is not possible in state 'unconfigured'; possible are: configure \(1\)"):
        worker.trigger_activate()
    worker.trigger_shutdown()
    with pytest.raises(RCLError, match="not possible in state 'finalized'"):
        worker.trigger_shutdown()
    assert worker.state == "finalized"


def test_a_callback_that_raises_is_an_error_and_is_logged(worker: Worker, capsys: pytest.CaptureFixture[str]) -> None:
    worker.plan["configure"] = ValueError("no map")
    assert worker.trigger_configure() is ERROR
    assert worker.state == "unconfigured"
    said = capsys.readouterr().err
    assert "The callback of state 'configuring' raised:" in said
    assert "ValueError: no map" in said


def test_a_callback_that_forgets_to_answer_is_named(worker: Worker) -> None:
    worker.plan["configure"] = 0
    with pytest.raises(TypeError, match=r"Worker\.on_configure returned 0, expected a TransitionCallbackReturn"):
        worker.trigger_configure()


# Publishers and other entities ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("steps", "plan", "speaks"),
    [
        ([], {}, False),
        (["configure"], {}, False),
        (["configure", "activate"], {}, True),
        (["configure", "activate"], {"activate": FAILURE}, False),
        (["configure", "activate", "deactivate"], {}, False),
        (["configure", "activate", "deactivate"], {"deactivate": ERROR}, False),
        (["configure", "activate", "deactivate"], {"deactivate": SUCCESS}, False),
        (["configure", "activate", "deactivate"], {"deactivate": FAILURE}, True),
        (["configure", "activate", "shutdown"], {}, False),
    ],
)
def test_publishers_speak_only_while_active(
    worker: Worker, executor: Any, spin_until: SpinUntil, steps: list[str], plan: dict[str, Any], speaks: bool
) -> None:
    worker.plan = plan
    got: list[float] = []
    plain = worker.create_publisher(Float64, "x", 10)
    managed = worker.create_lifecycle_publisher(Float64, "x", 10)
    worker.create_subscription(Float64, "x", lambda message: got.append(message.data), 10)
    executor.add_node(worker)
    bring(worker, *steps)
    managed.publish(Float64(data=1.0))
    # Within one program publishing delivers, so whatever the first one says is there before the second one's message.
    plain.publish(Float64(data=2.0))
    spin_until(lambda: 2.0 in got)
    assert managed.is_activated is speaks
    assert (1.0 in got) is speaks


def test_entities_hear_of_transitions_up_to_one_that_fails(worker: Worker) -> None:
    told: list[str] = []

    class Entity(ManagedEntity):
        def __init__(self, name: str, said: Any = SUCCESS) -> None:
            self.name, self.said = name, said

        def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
            told.append(f"{self.name} from {state.label}")
            result: TransitionCallbackReturn = self.said
            return result

    for entity in (Entity("a"), Entity("b", FAILURE), Entity("c")):
        worker.add_managed_entity(entity)
    assert worker.trigger_configure() is FAILURE
    assert told == ["a from unconfigured", "b from unconfigured"]
    with pytest.raises(TypeError, match=r"Expected a rclpy\.lifecycle\.ManagedEntity"):
        worker.add_managed_entity("x")  # type: ignore[arg-type]


def test_an_entity_that_forgets_to_answer_is_an_error(worker: Worker, capsys: pytest.CaptureFixture[str]) -> None:
    class Forgetful(ManagedEntity):
        def on_configure(self, state: LifecycleState) -> Any:
            return None

    worker.add_managed_entity(Forgetful())
    assert worker.trigger_configure() is ERROR
    assert "should be `TransitionCallbackReturn`" in capsys.readouterr().err


def test_methods_for_active_entities_only(worker: Worker) -> None:
    calls: list[str] = []

    class Lamp(SimpleManagedEntity):
        @SimpleManagedEntity.when_enabled
        def shine(self) -> None:
            calls.append("shine")

        @SimpleManagedEntity.when_enabled(when_not_enabled=lambda: calls.append("dark"))
        def blink(self) -> None:
            calls.append("blink")

    lamp = Lamp()
    worker.add_managed_entity(lamp)
    for steps in ((), ("configure", "activate"), ("deactivate",)):
        bring(worker, *steps)
        lamp.shine()
        lamp.blink()
    assert calls == ["dark", "shine", "blink", "dark"]


def test_a_publisher_comes_and_goes(worker: Worker) -> None:
    publisher = worker.create_lifecycle_publisher(Float64, "x", 10)
    bring(worker, "configure", "activate")
    assert worker.destroy_lifecycle_publisher(publisher)
    assert not worker.destroy_lifecycle_publisher(publisher)
    # Deactivating does not reach the one that is gone.
    bring(worker, "deactivate")
    with pytest.raises(TypeError, match="publisher_class"):
        worker.create_lifecycle_publisher(Float64, "x", 10, publisher_class=object)
