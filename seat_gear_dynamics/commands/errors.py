"""What a command says when it cannot do what was asked."""


class CommandError(Exception):
    """A command that failed; its text is one sentence."""
