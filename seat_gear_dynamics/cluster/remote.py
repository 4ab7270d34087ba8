"""What runs on a worker of a cluster: one block, by a worker that computes as the others do."""

import pickle
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from seat_gear_dynamics.cluster.build import CODE, MACHINE, Build, build, difference
from seat_gear_dynamics.cluster.errors import ClusterError


def compute_block(work: bytes, block: Any, expected: Build) -> Any:
    """Return what the pickled function `work` gives for `block`.

    Raises ClusterError where this worker's build is not `expected`: one that joined after the others were asked.
    """
    if (differs := difference(expected, build(), (*CODE, *MACHINE))) is not None:
        raise ClusterError(f"a worker that joined later has {differs}; give all workers the same installation")
    return _unpickled(work)(block)


@lru_cache(maxsize=8)
def _unpickled(work: bytes) -> Callable[[Any], Any]:
    """Return the function; kept, because a gear train computes its tooth stiffness when it is first used."""
    found: Callable[[Any], Any] = pickle.loads(work)
    return found
