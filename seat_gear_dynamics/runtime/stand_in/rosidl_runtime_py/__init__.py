"""Interface types by name."""
