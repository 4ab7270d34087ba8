"""DDS domains for tests: each test on one that no other uses at the moment."""

import random

_LAST = 99
"""Ports of higher domains lie where Linux takes the ports of outgoing traffic from, and may be taken."""
_used: set[int] = set()


def fresh_domain() -> int:
    """Return a domain that this run has not used, or once most were used, any."""
    if len(_used) > 80:
        _used.clear()
    number = random.SystemRandom().choice([n for n in range(1, _LAST + 1) if n not in _used])
    _used.add(number)
    return number
