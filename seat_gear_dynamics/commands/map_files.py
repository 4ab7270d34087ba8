"""A regime map while it is computed: nodes and drawn machines on disk as they are found, and the map made of them."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from seat_gear_dynamics.commands.journal import Journal
    from seat_gear_dynamics.gears import GearTrain
    from seat_gear_dynamics.regimes.map_nodes import MapGrid
    from seat_gear_dynamics.regimes.regime_map import RegimeMap
    from seat_gear_dynamics.regimes.workers import Workers

    Tell = Callable[[int, int], None]


class MapFiles:
    """The nodes of a map, and what `samples` machines add to each.

    A node takes `NODE.itemsize` bytes, a machine's node one byte: twice its weight of chaos, a whole number.
    """

    def __init__(self, output: Path, train: "GearTrain", grid: "MapGrid") -> None:
        """Take where the map goes, and what it is of."""
        self.nodes, self.machines = (output.with_name(f"{output.name}.{name}.part") for name in ("nodes", "machines"))
        self._train, self.grid = train, grid

    def find_nodes(self, journal: "Journal", by: "Workers", tell: "Tell") -> None:
        """Write the nodes that the journal does not hold yet, each block as it is found."""
        from seat_gear_dynamics.regimes.map_nodes import map_nodes

        done = int(journal.reached.get("nodes", 0))
        tell(done, self.grid.nodes)
        for block in map_nodes(self._train, self.grid, workers=by, begin=done):
            done += len(block)
            journal.add((block.tobytes(), b""), {"nodes": done, "weights": 0})
            tell(done, self.grid.nodes)

    def find_machines(self, journal: "Journal", by: "Workers", samples: int, seed: int, tell: "Tell") -> None:
        """Write what machines drawn within tolerances add, as far as the journal does not hold it yet."""
        from seat_gear_dynamics.regimes.map_nodes import map_weights
        from seat_gear_dynamics.regimes.tolerance import machines

        done = int(journal.reached["weights"])
        tell(done, samples * self.grid.nodes)
        complete, begin = divmod(done, self.grid.nodes)
        for number, train in enumerate(machines(self._train, samples, seed)):
            if number < complete:
                continue  # it had to be drawn, for the next to be the next
            for weights in map_weights(train, self.grid, workers=by, begin=begin):
                done += len(weights)
                journal.add((b"", (2 * weights).astype("u1").tobytes()), {"nodes": self.grid.nodes, "weights": done})
                tell(done, samples * self.grid.nodes)
            begin = 0

    def regime_map(self, samples: int) -> "RegimeMap":
        """Return the map of all nodes, which stay on disk and are read as they are needed.

        With `samples` the probability of chaos is held in memory, eight bytes a node.
        """
        import numpy as np

        from seat_gear_dynamics.regimes.map_nodes import NODE
        from seat_gear_dynamics.regimes.regime_map import RegimeMap

        found = RegimeMap.of_nodes(self._train, self.grid, np.memmap(self.nodes, NODE, "r"))
        if not samples:
            return found
        weights = np.memmap(self.machines, np.uint8, "r", shape=(samples, self.grid.nodes))
        chaos = weights.sum(axis=0, dtype=np.int64) / 2 / samples
        return found.with_chaos(chaos.reshape(found.chaos.shape), samples)

    def remove(self) -> None:
        """Remove the files: the map stands where it was asked for."""
        self.nodes.unlink()
        self.machines.unlink()
