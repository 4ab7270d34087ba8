"""Services and clients in one program and between two."""

from __future__ import annotations

from typing import Any

import pytest
from programs import PREAMBLE, MakeNode, Run, SpinUntil

from seat_gear_dynamics.runtime.messages import encoder, get_service
from seat_gear_dynamics.runtime.qos import QoSProfile
from seat_gear_dynamics.runtime.services import unwrap, wrap
from seat_gear_dynamics.runtime.wire.qos import dds_qos

Trigger = get_service("std_srvs/srv/Trigger")
SetBool = get_service("std_srvs/srv/SetBool")


def test_request_and_response(make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node()
    executor.add_node(node)
    service = node.create_service(SetBool, "~/switch", lambda request, response: answer(request, response))
    assert service.service_name == "/node/switch"
    client = node.create_client(SetBool, "/node/switch")
    spin_until(client.service_is_ready)
    futures = [client.call_async(SetBool.Request(data=value)) for value in (True, False)]
    done: list[Any] = []
    futures[0].add_done_callback(done.append)
    spin_until(lambda: all(future.done() for future in futures))
    assert [future.result().success for future in futures] == [True, False]
    assert done == [futures[0]]
    assert node.count_services("/node/switch") == node.count_clients("/node/switch") == 1
    assert ("/node/switch", ["std_srvs/srv/SetBool"]) in node.get_service_names_and_types()


def answer(request: Any, response: Any) -> Any:
    response.success = request.data
    return response


def test_each_client_gets_its_own_responses(make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node()
    executor.add_node(node)
    node.create_service(SetBool, "switch", answer)
    clients = [node.create_client(SetBool, "switch") for _ in range(2)]
    spin_until(lambda: all(client.service_is_ready() for client in clients))
    futures = [client.call_async(SetBool.Request(data=n == 0)) for n, client in enumerate(clients)]
    spin_until(lambda: all(future.done() for future in futures))
    assert [future.result().success for future in futures] == [True, False]


def test_coroutine_awaits_another_service(make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node()
    executor.add_node(node)
    node.create_service(SetBool, "inner", answer)
    inner = node.create_client(SetBool, "inner")

    async def outer_answer(_: Any, response: Any) -> Any:
        response.success = (await inner.call_async(SetBool.Request(data=True))).success
        return response

    node.create_service(Trigger, "outer", outer_answer)
    outer = node.create_client(Trigger, "outer")
    spin_until(lambda: outer.service_is_ready() and inner.service_is_ready())
    future = outer.call_async(Trigger.Request())
    spin_until(future.done)
    assert future.result().success


def test_wrong_uses_are_sentences(make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    node = make_node()
    executor.add_node(node)
    node.create_service(Trigger, "x", lambda request, response: None)
    client = node.create_client(Trigger, "x")
    assert not node.create_client(Trigger, "nobody").wait_for_service(timeout_sec=0.0)
    with pytest.raises(TypeError, match="Expected"):
        client.call_async(SetBool.Request())
    with pytest.raises(TypeError, match="is not a service class"):
        node.create_service(Trigger.Request, "y", answer)
    spin_until(client.service_is_ready)
    client.call_async(Trigger.Request())
    with pytest.raises(TypeError, match="return the response it is given"):
        executor.spin()


def test_identity_travels_before_the_content() -> None:
    identity = bytes(range(16))
    assert unwrap(wrap(identity, b"\0\1\0\0abcd")) == (identity, b"\0\1\0\0abcd")
    with pytest.raises(ValueError, match="too short"):
        unwrap(b"\0\1\0\0")


def test_between_processes(run: Run, make_node: MakeNode, executor: Any, spin_until: SpinUntil) -> None:
    server = run(
        PREAMBLE
        + """
from std_srvs.srv import Trigger
rclpy.init()
node = Node("server")
def answer(request, response):
    response.success, response.message = True, "ready"
    return response
node.create_service(Trigger, "~/start", answer)
print("up")
rclpy.spin(node)
"""
    )
    server.expect("up")
    node = make_node("client")
    executor.add_node(node)
    client = node.create_client(Trigger, "/server/start")
    assert client.wait_for_service(timeout_sec=10.0)
    future = client.call_async(Trigger.Request())
    executor.spin_until_future_complete(future, timeout_sec=10.0)
    assert future.result().message == "ready"
    server.stop()
    spin_until(lambda: not client.service_is_ready())


def test_a_malformed_request_is_left_out(
    make_node: MakeNode, executor: Any, spin_until: SpinUntil, capsys: pytest.CaptureFixture[str]
) -> None:
    node = make_node()
    executor.add_node(node)
    kind = get_service("lifecycle_msgs/srv/ChangeState")
    node.create_service(kind, "change", lambda _, response: response)
    client = node.create_client(kind, "change")
    spin_until(client.service_is_ready)
    # DDS refuses bytes that are too short, not a text that is no UTF-8.
    client._writer.write(wrap(bytes(16), bytes.fromhex("00010000 01000000 02000000 ff00")))
    future = client.call_async(kind.Request())
    spin_until(future.done)
    assert "A request to /change is left out: " in capsys.readouterr().err


def test_a_reply_waits_for_a_client_that_is_half_discovered(
    make_node: MakeNode, executor: Any, spin_until: SpinUntil
) -> None:
    node = make_node()
    executor.add_node(node)
    asked: list[bool] = []
    ticks: list[None] = []

    def reply(request: Any, response: Any) -> Any:
        asked.append(request.data)
        return answer(request, response)

    service = node.create_service(SetBool, "switch", reply)
    node.create_timer(0.001, lambda: ticks.append(None))
    participant = node.context._participant
    policies = dds_qos(QoSProfile(depth=10), "clientid=half;")
    # First the endpoint that asks, as on a network that is slow to tell of the other one.
    writer = participant.writer("rq/switchRequest", SetBool.Request.FULL_NAME, policies, request_header=True)
    spin_until(lambda: writer.matched() == 1)
    identity = bytes(range(16))
    writer.write(wrap(identity, encoder(SetBool.Request)(SetBool.Request(data=True))))
    spin_until(lambda: asked)
    begun = len(ticks)
    spin_until(lambda: len(ticks) > begun)
    reader = participant.reader("rr/switchReply", SetBool.Response.FULL_NAME, policies, request_header=True)
    got: list[tuple[bytes, Any]] = []

    def heard() -> bool:
        got.extend(reader.take(1))
        return bool(got)

    spin_until(heard)
    assert unwrap(got[0][0])[0] == identity
    assert service._known
