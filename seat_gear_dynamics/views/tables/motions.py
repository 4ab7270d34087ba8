"""Columns of one motion: time history, section, forces, order spectrum, lines of the contact verification."""

import numpy as np

from seat_gear_dynamics.logs.analysis.order_spectrum import OrderSpectrum
from seat_gear_dynamics.motion import History, Response
from seat_gear_dynamics.plotting import Column, Table
from seat_gear_dynamics.regimes.simulate import Simulation
from seat_gear_dynamics.studies.contact_verification import ConditionRun

_PAIRS = ("s1_s2", "s3_s4")


def history_table(found: History) -> Table:
    """Return a row for each step: τ, then δ, its rate, force and contact (1 or 0) of both meshes."""
    columns = [Column("tau", "1", found.tau)]
    for n, mesh in enumerate(_PAIRS):
        columns += [
            Column(f"{mesh}/delta", "b_c", found.delta[:, n]),
            Column(f"{mesh}/rate", "b_c/τ", found.rate[:, n]),
            Column(f"{mesh}/force", "N", found.force[:, n]),
            Column(f"{mesh}/contact", "", found.contact[:, n]),
        ]
    return Table(columns)


def response_table(found: Response) -> Table:
    """Return a row for each sampled mesh period: section point of s1_s2 and growth of the tangents."""
    return Table(
        (
            Column("period", "", np.arange(1, len(found.section) + 1)),
            Column("delta", "b_c", found.section[:, 0]),
            Column("rate", "b_c/τ", found.section[:, 1]),
            *(Column(f"{mesh}/growth", "", found.growth[:, n]) for n, mesh in enumerate(_PAIRS)),
        )
    )


def simulation_table(found: Simulation, *, points: bool = False) -> Table:
    """Return a row for each mesh with its forces, or with `points` the section, as `response_table`."""
    if points:
        return response_table(found.response)
    names = ("mean", "min", "max", "rms", "contact_loss", "static")
    forces = found.meshes.values()
    return Table(
        (
            Column("mesh", "", list(found.meshes)),
            *(Column(n, "" if n == "contact_loss" else "N", [getattr(force, n) for force in forces]) for n in names),
        )
    )


def order_spectrum_table(found: OrderSpectrum) -> Table:
    """Return a row for each order: events per revolution of s1, and the peak amplitude there."""
    return Table((Column("order", "", found.orders), Column("amplitude", "N", found.amplitude)))


def condition_table(found: ConditionRun) -> Table:
    """Return a row for each sample of the run."""
    run = found.history
    return Table(
        (
            Column("time", "s", run.time),
            Column("s1_s2/force", "N", run.force),
            Column("s3_s4/force", "N", run.second_force),
            Column("s1_s2/back_force", "N", run.back_force),
            Column("input_torque", "N·m", run.input_torque),
        )
    )
