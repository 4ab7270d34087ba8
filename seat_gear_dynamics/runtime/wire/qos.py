"""Translate quality-of-service profiles to DDS policies and back."""

from __future__ import annotations

from typing import Any

from seat_gear_dynamics.runtime.absent import unsupported
from seat_gear_dynamics.runtime.qos import (
    UNSPECIFIED,
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from seat_gear_dynamics.runtime.time import Duration, Infinite


def dds_qos(profile: QoSProfile, user_data: str = "") -> Any:
    """Return the DDS policies of a profile for a reader or writer, as the ROS middleware sets them.

    Raises:
        NotImplementedError: a policy ROS resolves by looking at the peers (BEST_AVAILABLE).
        ValueError: a policy is UNKNOWN, or the depth is negative.
    """
    from cyclonedds.core import Policy, Qos

    _refuse_unknown(profile)
    depth = profile.depth or 1
    keep_all = profile.history is HistoryPolicy.KEEP_ALL
    history = Policy.History.KeepAll if keep_all else Policy.History.KeepLast(depth)
    policies: list[Any] = [
        history,
        Policy.WriterDataLifecycle(autodispose=False),
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
        Policy.TypeConsistency.AllowTypeCoercion(ignore_member_names=True),
    ]
    best_effort = profile.reliability is ReliabilityPolicy.BEST_EFFORT
    policies.append(Policy.Reliability.BestEffort if best_effort else Policy.Reliability.Reliable(_FOREVER))
    if profile.durability is DurabilityPolicy.TRANSIENT_LOCAL:
        policies.append(Policy.Durability.TransientLocal)
        policies.append(Policy.DurabilityService(0, history, -1, -1, -1))
    else:
        policies.append(Policy.Durability.Volatile)
    policies.extend(_timing(profile))
    if user_data:
        policies.append(Policy.Userdata(user_data.encode()))
    return Qos(*policies)


_FOREVER = Infinite.nanoseconds


def _timing(profile: QoSProfile) -> list[Any]:
    from cyclonedds.core import Policy

    policies: list[Any] = []
    if profile.lifespan != UNSPECIFIED:
        policies.append(Policy.Lifespan(profile.lifespan.nanoseconds))
    if profile.deadline != UNSPECIFIED:
        policies.append(Policy.Deadline(profile.deadline.nanoseconds))
    lease = profile.liveliness_lease_duration
    manual = profile.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC
    kind = Policy.Liveliness.ManualByTopic if manual else Policy.Liveliness.Automatic
    policies.append(kind(_FOREVER if lease == UNSPECIFIED else lease.nanoseconds))
    return policies


def _refuse_unknown(profile: QoSProfile) -> None:
    supported = {
        "reliability": ReliabilityPolicy.RELIABLE,
        "durability": DurabilityPolicy.VOLATILE,
        "liveliness": LivelinessPolicy.AUTOMATIC,
        "history": HistoryPolicy.KEEP_LAST,
    }
    for field, instead in supported.items():
        value = getattr(profile, field)
        if value.name == "BEST_AVAILABLE":
            raise unsupported(f"QoS {field}", value.name, instead.name)
        if value.name == "UNKNOWN":
            raise ValueError(f"QoS {field} is UNKNOWN, expected a setting such as {instead.name}.")
    if profile.depth < 0:
        raise ValueError(f"QoS depth is {profile.depth}, expected 0 or more.")


def profile_of(qos: Any) -> QoSProfile:
    """Return the ROS profile of DDS policies found in discovery; history is UNKNOWN where it is not announced."""
    from cyclonedds.core import Policy

    profile = QoSProfile(history=HistoryPolicy.UNKNOWN, depth=0)
    for policy in qos:
        scope = policy.__scope__
        if scope == "Reliability":
            best_effort = policy == Policy.Reliability.BestEffort
            profile.reliability = ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE
        elif scope == "Durability":
            late = policy == Policy.Durability.TransientLocal
            profile.durability = DurabilityPolicy.TRANSIENT_LOCAL if late else DurabilityPolicy.VOLATILE
        elif scope == "History":
            keep_all = policy == Policy.History.KeepAll
            profile.depth = 0 if keep_all else policy.depth
            profile.history = HistoryPolicy.KEEP_ALL if keep_all else HistoryPolicy.KEEP_LAST
        elif scope == "Lifespan":
            profile.lifespan = Duration(nanoseconds=policy.lifespan)
        elif scope == "Deadline":
            profile.deadline = Duration(nanoseconds=policy.deadline)
        elif scope == "Liveliness":
            manual = isinstance(policy, Policy.Liveliness.ManualByTopic)
            profile.liveliness = LivelinessPolicy.MANUAL_BY_TOPIC if manual else LivelinessPolicy.AUTOMATIC
            profile.liveliness_lease_duration = Duration(nanoseconds=policy.lease_duration)
    return profile
