"""What an integration gives: the motion, its changes of contact and what it cost."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class StepRefusedError(ArithmeticError):
    """No step that was allowed met the tolerance, or contact changed too often; the text says what to change."""


@dataclass(frozen=True)
class ContactChanges:
    """Changes of contact in the order of time; k of them. Branches are -1 and 1 in contact on a flank, 0 apart."""

    times: Array
    """τ, (k,)."""
    meshes: Index
    """0 for P12, 1 for P34, (k,)."""
    before: Index
    """Branch that was left, (k,)."""
    after: Index
    """Branch that was met, (k,)."""
    rates: Array
    """δ′ at the change, b_c per unit of τ, (k,); near 0 where the flank was grazed."""

    def __len__(self) -> int:
        return len(self.times)


@dataclass(frozen=True)
class Counts:
    """What an integration cost."""

    steps: int
    """Accepted steps, pieces of steps cut at a change of contact among them."""
    evaluations: int
    """Right-hand sides of the state; a tangent's are not counted."""
    rejected: int
    """Steps that were tried and made shorter for the tolerance."""
    events: int
    """Changes of contact; located ones with a locating method, else those seen at the ends of steps."""
    smallest_step: float
    """Shortest step that a tolerance or the grid asked for (not one cut at a change of contact), units of τ."""


@dataclass(frozen=True)
class Trajectory:
    """A motion over a span of time, step by step."""

    times: Array
    """τ at the ends of steps, (n,), from the start to the end of the span."""
    states: Array
    """(n, 24) in the order of STATE_NAMES."""
    tangent: Array
    """What became of the tangent given, (24, m); m = 0 without one."""
    contact: Index
    """Branch of each mesh at the start, (2,)."""
    changes: ContactChanges
    counts: Counts

    @property
    def state(self) -> Array:
        """The final state, (24,)."""
        return np.asarray(self.states[-1].copy())

    def contact_share(self) -> Array:
        """Return the share of the time that each mesh was in contact, (2,), as exact as its changes were located."""
        begin, end = self.times[0], self.times[-1]
        shares = np.empty(2)
        for j in range(2):
            own = self.changes.meshes == j
            marks = np.concatenate([[begin], self.changes.times[own], [end]])
            touching = np.concatenate([[self.contact[j]], self.changes.after[own]]) != 0
            shares[j] = np.diff(marks) @ touching / (end - begin)
        return shares
