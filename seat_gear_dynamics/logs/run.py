"""A recorded run as arrays: what a report needs of a log, and whether the log is complete."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seat_gear_dynamics.logs import topics
from seat_gear_dynamics.logs.errors import LogError
from seat_gear_dynamics.logs.flows import Flow as Flow
from seat_gear_dynamics.logs.flows import Flows
from seat_gear_dynamics.logs.reader import Bag
from seat_gear_dynamics.logs.series import JointSeries, Status

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """A log's contents over time in s since its start; SI units throughout."""

    path: Path
    duration: float
    speed: tuple[Array, Array]
    """time, rad/s of s1"""
    load: tuple[Array, Array]
    """time, N·m"""
    force: JointSeries | None
    """`gear_monitor/mesh_force`, or None where the log has none."""
    warnings: list[Status]
    section: Array
    """Section points of P12, shape (n, 3): δ/b_c, dimensionless rate, time in s; each point once."""
    flows: list[Flow]
    damage: str | None
    software_version: str | None
    system_text: str | None
    """The description the bench ran with, as the log keeps it."""


def read_run(path: Path | str) -> Run:
    """Read a run from a log of ours, or from any bag with speed and load; raises LogError for what is no log.

    Limit: it holds every sample (some 16 bytes a number), and every warning and section point. A log of hours is for
    `analysis.analyse`, whose memory does not grow.
    """
    bag = Bag(path)
    metadata = bag.metadata or {}
    speed, load = bag.scalars(topics.MOTOR_SPEED.name), bag.scalars(topics.LOAD_TORQUE.name)
    force = bag.joint(topics.MESH_FORCE.name) if _has(bag, topics.MESH_FORCE) else None
    warnings = bag.statuses(topics.CHAOS_WARNING.name) if _has(bag, topics.CHAOS_WARNING) else []
    section = _section(bag) if _has(bag, topics.POINCARE) else np.empty((0, 3))
    return Run(
        path=bag.path,
        duration=(bag.end_ns - bag.start_ns) * 1e-9,
        speed=speed,
        load=load,
        force=force,
        warnings=warnings,
        section=section,
        flows=_flows(bag),
        damage=bag.damage,
        software_version=metadata.get("software_version"),
        system_text=metadata.get("system"),
    )


def _has(bag: Bag, topic: topics.Topic) -> bool:
    try:
        return bag.topics[bag.resolve(topic.name)].count > 0
    except LogError:
        return False


class CloudPoints:
    """Takes each section point of overlapping clouds once, by its time."""

    _LAYOUT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("t", "<f8")])

    def __init__(self) -> None:
        self._last = -np.inf

    def fresh(self, cloud: Any, path: Path) -> Array:
        """Return the points not met before, shape (n, 3): δ/b_c, dimensionless rate, time in s since the epoch.

        A cloud that ends before the last one did is of another clock or another start, and is taken whole. Raises
        LogError, naming the log at `path`, where the cloud's fields are not x, y, z, t.
        """
        names = [field.name for field in cloud.fields]
        if names != list(self._LAYOUT.names or ()) or cloud.point_step != self._LAYOUT.itemsize:
            raise LogError(f"A cloud in {path} has fields {names}; expected x, y, z, t of 20 bytes a point.")
        points = np.frombuffer(bytes(cloud.data), dtype=self._LAYOUT)
        if not len(points):
            return np.empty((0, 3))
        fresh = points[points["t"] > self._last] if points["t"][-1] >= self._last else points
        self._last = float(points["t"][-1])
        columns: Array = np.column_stack([fresh["x"], fresh["y"], fresh["t"]]).astype(np.float64)
        return columns


def _section(bag: Bag) -> Array:
    """Return the section points of all clouds; clouds overlap, so each point is taken once, by its time."""
    seen = CloudPoints()
    clouds = [seen.fresh(cloud, bag.path) for _, _, _, cloud in bag.decoded(topics.POINCARE.name)]
    points = np.concatenate(clouds) if clouds else np.empty((0, 3))
    return np.asarray(points - np.array([0.0, 0.0, bag.start_ns * 1e-9]))


def _flows(bag: Bag) -> list[Flow]:
    flows = Flows(bag.topics)
    for message in bag.messages():
        flows.add(message.topic, message.publish_time_ns)
    return flows.found()
