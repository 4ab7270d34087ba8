"""Identifying the model from a measured bench: what dwells say, what the model says of them, a fit, how sure it is."""
