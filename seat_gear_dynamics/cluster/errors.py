"""What is said when a cluster cannot compute what was asked."""


class ClusterError(Exception):
    """A cluster that cannot be used; its text is one sentence."""
