"""The error that a wrong gear train raises."""


class DescriptionError(ValueError):
    """A system description that cannot be used; its text is one sentence with key, value and what was expected."""
