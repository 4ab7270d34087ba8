"""Nodes."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.graph_queries import NodeNameNonExistentError
from seat_gear_dynamics.runtime.node import Node

__all__ = ["Node", "NodeNameNonExistentError"]

__getattr__ = missing_from(__name__)
