"""What a log says of a drive: streaming reductions, warnings against danger, and the model beside it."""

from seat_gear_dynamics.logs.analysis.analyse import Analysis, Provenance, analyse
from seat_gear_dynamics.logs.analysis.model import ModelSettings
from seat_gear_dynamics.logs.analysis.order_spectrum import OrderSpectrum, mesh_orders, order_spectrum
from seat_gear_dynamics.logs.analysis.sources import Source

__all__ = [
    "Analysis",
    "ModelSettings",
    "OrderSpectrum",
    "Provenance",
    "Source",
    "analyse",
    "mesh_orders",
    "order_spectrum",
]
