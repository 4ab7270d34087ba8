"""Error against cost of every integrator: `python benchmarks/work_precision.py [--picture FILE.png]` prints JSON.

`costs` are evaluations and milliseconds that each solver needs for errors of 1e-3, 1e-6 and 1e-9 b_c in the final
state; null where its settings do not reach that, or the coarsest is better already. Milliseconds are processor time,
which others at work on the machine disturb less than wall time; the shortest of three runs.
"""

import argparse
import json
import sys
from math import isnan
from pathlib import Path
from time import process_time

from seat_gear_dynamics import load_system
from seat_gear_dynamics.studies.work_precision import SOLVERS, WorkPrecision, study
from seat_gear_dynamics.views.figures.style import save
from seat_gear_dynamics.views.figures.work_precision import work_precision_figure

ERRORS = (1e-3, 1e-6, 1e-9)


def costs(found: WorkPrecision, case: str, solver: str) -> dict[str, list[float | None]]:
    evaluations = [found.cost(case, solver, e) for e in ERRORS]
    times = [1e3 * found.cost(case, solver, e, seconds=True) for e in ERRORS]
    return {
        "evaluations": [None if isnan(x) else round(x) for x in evaluations],
        "milliseconds": [None if isnan(x) else round(x, 3) for x in times],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--picture", type=Path, help="draw the diagram into this file")
    arguments = parser.parse_args()
    found = study(load_system().train, clock=process_time, progress=lambda line: print(line, file=sys.stderr))
    if arguments.picture is not None:
        save(work_precision_figure(found), arguments.picture)
    cases = {
        case.name: {
            "frequency": case.system.operating_point.frequency,
            "load": case.system.operating_point.load,
            "periods": case.periods,
            "contact_changes": end.changes,
            "reference_uncertainty": end.uncertainty,
            "costs": {solver: costs(found, case.name, solver) for solver in SOLVERS},
        }
        for case, end in zip(found.cases, found.references, strict=True)
    }
    print(json.dumps({"errors": ERRORS, "cases": cases}, indent=1))


if __name__ == "__main__":
    main()
