"""Refusals of options in one wording."""

from math import inf


def positive(name: str, value: float) -> None:
    """Raise ValueError where an option is no finite number above 0."""
    if not 0 < value < inf:
        raise ValueError(f"The {name} is {value!r}, expected a finite number above 0.")
