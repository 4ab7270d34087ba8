"""Endpoints on topics."""

from seat_gear_dynamics.runtime.absent import missing_from
from seat_gear_dynamics.runtime.graph_queries import TopicEndpointInfo, TopicEndpointTypeEnum

__all__ = ["TopicEndpointInfo", "TopicEndpointTypeEnum"]

__getattr__ = missing_from(__name__)
