"""Nodes as real processes on a domain of their own."""

from node_fixtures import domain_id, peer, processes

__all__ = ["domain_id", "peer", "processes"]
