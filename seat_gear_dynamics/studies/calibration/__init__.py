"""Identifying what the paper leaves open from its claims C1-C5 and C7-C10: a repeatable search, and how firm it is."""
