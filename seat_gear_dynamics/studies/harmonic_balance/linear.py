"""One dense linear system, solved by one thread.

The systems of harmonic balance are small, from 60 to some hundred unknowns, and there are thousands of them. A threaded
BLAS loses more on such by waiting for its threads than it gains, many times over where other programs run beside; and
its rounding depends on the number of threads, which this elimination's does not.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


def solved(matrix: Array, right: Array) -> Array | None:
    """Return x of matrix·x = right, (n,), or None where the matrix is singular or an entry is not finite.

    Gaussian elimination with partial pivoting; neither argument is changed.
    """
    x = np.array(right, dtype=float)
    regular = eliminated(np.array(matrix, dtype=float, order="C"), x)
    return x if regular and bool(np.all(np.isfinite(x))) else None


@njit(cache=True, error_model="numpy")
def eliminated(a: Array, x: Array) -> bool:
    """Overwrite `x`, the right side, by the solution and `a` by its upper factor; return False at a pivot of zero."""
    n = len(x)
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        if not abs(a[best, k]) > 0.0:
            return False
        if best != k:
            for j in range(k, n):
                a[k, j], a[best, j] = a[best, j], a[k, j]
            x[k], x[best] = x[best], x[k]
        for i in range(k + 1, n):
            factor = a[i, k] / a[k, k]
            if factor != 0.0:
                for j in range(k + 1, n):
                    a[i, j] -= factor * a[k, j]
                x[i] -= factor * x[k]
    for k in range(n - 1, -1, -1):
        total = x[k]
        for j in range(k + 1, n):
            total -= a[k, j] * x[j]
        x[k] = total / a[k, k]
    return True
