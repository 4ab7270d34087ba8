"""C14: the mesh stiffness that Table 1's geometry gives."""

from seat_gear_dynamics.gears import GearTrain, Mesh, mesh_stiffness
from seat_gear_dynamics.studies.reproduction.claim import Claim, graded

PUBLISHED_MEANS = {"s1_s2": 2.234e8, "s3_s4": 3.097e8}
"""Table 2, N/m."""


def stiffness_of(mesh: Mesh) -> dict[str, float]:
    """Return the computed means, N/m, with and without fillet foundation, the contact ratio and the two levels."""
    computed = mesh.computed_stiffness
    bare = mesh_stiffness(mesh.driver.tooth, mesh.driven.tooth, foundation=False)
    double = computed.phase < computed.contact_ratio - 1
    return {
        "mean": computed.mean,
        "mean_without_foundation": bare.mean,
        "contact_ratio": computed.contact_ratio,
        "single_contact": float(computed.values[~double].mean()),
        "double_contact": float(computed.values[double].mean()),
        "published": PUBLISHED_MEANS[mesh.name],
    }


def mesh_stiffness_claim(train: GearTrain) -> Claim:
    """C14: k(t) alternates between single and double contact, with the published means."""
    found = {mesh.name: stiffness_of(mesh) for mesh in train.meshes}
    alternates = all(f["double_contact"] > 1.2 * f["single_contact"] for f in found.values())
    near = all(abs(f["mean"] / f["published"] - 1) <= 0.05 for f in found.values())
    between = all(f["mean"] < f["published"] < f["mean_without_foundation"] for f in found.values())
    rows = "; ".join(
        f"{name}: contact ratio {f['contact_ratio']:.4f}, single {f['single_contact']:.3g} and double "
        f"{f['double_contact']:.3g} N/m, mean {f['mean']:.4g} with fillet foundation and "
        f"{f['mean_without_foundation']:.4g} without (published {f['published']:.4g})"
        for name, f in found.items()
    )
    return Claim(
        "C14",
        "Table 1 geometry",
        "k(t) alternates between single and double contact; means 2.234e8 and 3.097e8 N/m",
        rows,
        graded(alternates and near, alternates),
        ("the published means lie between those with and without the foundation: " if between else "")
        + "they depend on the bore, which is not given; the model scales the computed shape to them where the "
        "description says so",
        found,
    )
