"""`seat-gear simulate`: one operating point, forces and regime."""

import argparse
import json

from seat_gear_dynamics.commands.texts import Texts

TEXTS = {
    "simulate": Texts(
        "simulate one operating point: mesh forces, contact loss, regime",
        "seat-gear simulate --speed-rpm 1800 --load 600",
    )
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    drive = parser.add_mutually_exclusive_group(required=True)
    drive.add_argument("--speed-rpm", type=float, metavar="N", help="speed of s1, r/min")
    drive.add_argument("--frequency", type=float, metavar="Ω", help="dimensionless mesh frequency of s1_s2")
    parser.add_argument("--load", type=float, required=True, metavar="T4", help="load torque on s4, N·m")
    parser.add_argument("--damping", type=float, metavar="ξ", help="mesh damping ratio (default: the system's)")
    parser.add_argument("--backlash-um", type=float, metavar="B", help="backlash, µm (default: the system's)")
    parser.add_argument("--transient", type=int, default=600, metavar="N", help="mesh periods run in (default 600)")
    parser.add_argument("--periods", type=int, default=400, metavar="N", help="mesh periods sampled (default 400)")


def run(arguments: argparse.Namespace) -> int:
    """Simulate and print."""
    from seat_gear_dynamics.commands.errors import CommandError
    from seat_gear_dynamics.commands.progress import progress
    from seat_gear_dynamics.gears.units import RPM
    from seat_gear_dynamics.motion import load_system
    from seat_gear_dynamics.motion.march import DivergedError
    from seat_gear_dynamics.regimes import simulate

    rpm, micrometres = arguments.speed_rpm, arguments.backlash_um
    try:
        with progress("mesh periods", quiet=arguments.json) as tell:
            result = simulate(
                load_system(arguments.system),
                frequency=arguments.frequency,
                speed=None if rpm is None else rpm * RPM,
                load=arguments.load,
                damping=arguments.damping,
                backlash=None if micrometres is None else micrometres * 1e-6,
                transient=arguments.transient,
                periods=arguments.periods,
                progress=tell,
            )
    except (ValueError, DivergedError) as error:
        raise CommandError(str(error)) from error
    values = result.as_dict()
    if arguments.json:
        print(json.dumps(values))
        return 0
    print(f"Ω = {result.frequency:.4f} ({result.speed_rpm:.1f} r/min of s1), T4 = {result.load:g} N·m")
    print(f"motion of s1_s2: {result.regime.label}; {result.regime.reason}")
    print(f"mesh forces in N, at load scale {result.load_scale:.4g} of the static force:")
    print(f"{'mesh':8s}{'mean':>10s}{'min':>10s}{'max':>10s}{'rms':>10s}{'contact loss':>14s}{'static':>10s}")
    for mesh, f in result.meshes.items():
        print(f"{mesh:8s}{f.mean:10.1f}{f.min:10.1f}{f.max:10.1f}{f.rms:10.1f}{f.contact_loss:14.1%}{f.static:10.0f}")
    return 0
