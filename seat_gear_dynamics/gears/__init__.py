"""What the machine is: tooth geometry, mesh stiffness, excitation and the typed system description."""

from seat_gear_dynamics.gears.description import load_train, packaged_description
from seat_gear_dynamics.gears.errors import DescriptionError
from seat_gear_dynamics.gears.excitation import PeriodicSeries, TransmissionErrorHarmonic
from seat_gear_dynamics.gears.stiffness import MeshStiffness, mesh_stiffness
from seat_gear_dynamics.gears.tooth import Tooth, contact_ratio
from seat_gear_dynamics.gears.train import ForbiddenBand, Gear, GearTrain, Mesh, Model, Provenance, Shaft, Variant

__all__ = [
    "DescriptionError",
    "ForbiddenBand",
    "Gear",
    "GearTrain",
    "Mesh",
    "MeshStiffness",
    "Model",
    "PeriodicSeries",
    "Provenance",
    "Shaft",
    "Tooth",
    "TransmissionErrorHarmonic",
    "Variant",
    "contact_ratio",
    "load_train",
    "mesh_stiffness",
    "packaged_description",
]
