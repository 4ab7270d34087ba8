"""The one error of this room."""


class BenchError(ValueError):
    """A bench was asked for something it cannot do; the text is a sentence with the value and what to do."""
