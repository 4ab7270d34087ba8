"""The peak of a study's memory is its own, not that of whoever started it."""

import numpy as np

from benchmarks.memory import _PEAK, peak_megabytes


def test_a_small_process_of_a_large_one_is_small() -> None:
    large = np.ones(40_000_000)  # 320 MB that are really there
    assert peak_megabytes(_PEAK, 1) < 100 < large.nbytes / 2**20
