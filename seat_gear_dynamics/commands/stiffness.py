"""`seat-gear stiffness`: the computed mesh stiffness of both pairs."""

import argparse
import json

from seat_gear_dynamics.commands.texts import Texts

TEXTS = {"stiffness": Texts("mesh stiffness by the potential-energy method", "seat-gear stiffness")}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments: none."""


def run(arguments: argparse.Namespace) -> int:
    """Compute and print."""
    from seat_gear_dynamics.gears import load_train

    train = load_train(arguments.system)
    values = {
        mesh.name: {
            "contact_ratio": mesh.contact_ratio,
            "computed_mean": mesh.computed_stiffness.mean,
            "computed_min": float(mesh.computed_stiffness.values.min()),
            "computed_max": float(mesh.computed_stiffness.values.max()),
            "published_mean": mesh.mean_stiffness,
            "scaled_to_published_mean": mesh.scale_to_mean,
            "harmonics": mesh.stiffness_harmonics,
        }
        for mesh in train.meshes
    }
    if arguments.json:
        print(json.dumps(values))
        return 0
    print(
        f"{'mesh':8s}{'contact ratio':>14s}{'computed N/m: mean':>20s}{'min':>12s}{'max':>12s}{'published mean':>16s}"
    )
    for name, v in values.items():
        print(
            f"{name:8s}{v['contact_ratio']:14.4f}{v['computed_mean']:20.4g}{v['computed_min']:12.4g}"
            f"{v['computed_max']:12.4g}{v['published_mean']:16.4g}"
        )
    print("The model scales the computed shape to the published mean where the description says scale_to_mean.")
    return 0
