"""The one error of this room, and what the system says turned into part of its sentence."""


class LogError(Exception):
    """A log cannot be written or read; the text is a sentence with the path, the cause and what to do."""


def reason(cause: OSError) -> str:
    """Return what the system said, with the path if it named one."""
    where = f" ({cause.filename})" if cause.filename else ""
    return f"{(cause.strerror or str(cause)).rstrip('.')}{where}"
