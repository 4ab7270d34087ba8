"""Many operating points of gear trains marched together, several to an instruction: the engine of sweeps and maps."""

from seat_gear_dynamics.motion.lanes.excitation import in_reach
from seat_gear_dynamics.motion.lanes.kernel import WIDTH
from seat_gear_dynamics.motion.lanes.march import respond_lanes, respond_trains
from seat_gear_dynamics.motion.lanes.points import LanePoints, LaneResponse
from seat_gear_dynamics.motion.lanes.structure import supports

__all__ = ["WIDTH", "LanePoints", "LaneResponse", "in_reach", "respond_lanes", "respond_trains", "supports"]
