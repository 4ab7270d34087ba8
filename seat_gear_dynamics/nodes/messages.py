"""The contract's messages from the core's values: the one place that knows their fields."""

from collections.abc import Mapping, Sequence

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from numpy.typing import NDArray
from sensor_msgs.msg import JointState, PointCloud2, PointField
from std_msgs.msg import Header

from seat_gear_dynamics.gears.units import RPM
from seat_gear_dynamics.sensing import Accepted, Contact, ForceWindow, Level, Verdict

LEVELS = {
    Level.OK: DiagnosticStatus.OK,
    Level.WARN: DiagnosticStatus.WARN,
    Level.ERROR: DiagnosticStatus.ERROR,
    Level.STALE: DiagnosticStatus.STALE,
}
MESHES = ("s1_s2", "s3_s4")
_STATISTICS = ("mean", "min", "max", "rms")


def stamp(nanoseconds: int) -> Time:
    """Return `nanoseconds` since the epoch as a message."""
    return Time(sec=nanoseconds // 1_000_000_000, nanosec=nanoseconds % 1_000_000_000)


def nanoseconds(time: Time) -> int:
    """Return a message's time in ns since the epoch."""
    return int(time.sec) * 1_000_000_000 + int(time.nanosec)


def model_input(stamp_ns: int, speed: float, load: float) -> JointState:
    """Return what the model was fed: speed of s1, rad/s, and load T4, N·m."""
    return JointState(header=Header(stamp=stamp(stamp_ns)), name=["s1"], velocity=[speed], effort=[load])


def mesh_state(stamp_ns: int, contacts: Sequence[Contact]) -> JointState:
    """Return both meshes as prismatic joints on the line of action (m, m/s, N)."""
    return JointState(
        header=Header(stamp=stamp(stamp_ns)),
        name=list(MESHES),
        position=[c.deflection for c in contacts],
        velocity=[c.rate for c in contacts],
        effort=[c.force for c in contacts],
    )


def mesh_force(stamp_ns: int, windows: Sequence[ForceWindow]) -> JointState:
    """Return the force statistics of both meshes since the last message, N."""
    return JointState(
        header=Header(stamp=stamp(stamp_ns)),
        name=[f"{mesh}/{statistic}" for mesh in MESHES for statistic in _STATISTICS],
        effort=[value for w in windows for value in (w.mean, w.min, w.max, w.rms)],
    )


def poincare(stamp_ns: int, section: NDArray[np.float64], origin_ns: int) -> PointCloud2:
    """Return section points, (n, 3) of δ/b_c, dimensionless rate and time in s since `origin_ns`, as a cloud.

    x, y and z are float32, as viewers expect; `t` is float64, s since the epoch as the header's stamp, good to 0.3 µs.
    """
    layout = np.dtype({"names": ["x", "y", "z", "t"], "formats": ["<f4", "<f4", "<f4", "<f8"], "itemsize": 20})
    cloud = np.zeros(len(section), dtype=layout)
    cloud["x"], cloud["y"], cloud["t"] = section[:, 0], section[:, 1], section[:, 2] + origin_ns * 1e-9
    kinds = (PointField.FLOAT32, PointField.FLOAT32, PointField.FLOAT32, PointField.FLOAT64)
    fields = [
        PointField(name=name, offset=4 * i, datatype=kind, count=1)
        for i, (name, kind) in enumerate(zip("xyzt", kinds, strict=True))
    ]
    return PointCloud2(
        header=Header(stamp=stamp(stamp_ns), frame_id="s1_s2"),
        height=1,
        width=len(section),
        fields=fields,
        is_bigendian=False,
        point_step=layout.itemsize,
        row_step=layout.itemsize * len(section),
        data=cloud.tobytes(),
        is_dense=True,
    )


def status(level: Level, name: str, text: str, values: Mapping[str, object]) -> DiagnosticStatus:
    """Return a diagnostic status; `values` become key and text in their order."""
    return DiagnosticStatus(
        level=LEVELS[level],
        name=name,
        message=text,
        hardware_id="seat_gear_dynamics",
        values=[KeyValue(key=key, value=_text(value)) for key, value in values.items()],
    )


def chaos_warning(name: str, verdict: Verdict, sample: Accepted | None) -> DiagnosticStatus:
    """Return the warning with speed, load, band, distance, regime, evidence and the nearest calm speed."""
    return status(verdict.level, name, verdict.reason, warning_values(verdict, sample))


def warning_values(verdict: Verdict, sample: Accepted | None) -> dict[str, object]:
    """Return what a verdict rests on, by keys with units; `sample` is the last that was judged."""
    band = verdict.band
    return {
        "speed (r/min)": sample.speed / RPM if sample else None,
        "load (N·m)": sample.load if sample else None,
        "bands": verdict.bands,
        "band (r/min)": f"{band.low / RPM:.0f}-{band.high / RPM:.0f}" if band else None,
        "distance to band (r/min)": _rpm(verdict.distance),
        "time to band (s)": verdict.time_to_band,
        "regime": sample.regime.name if sample else "undecided",
        "period": sample.regime.period if sample else None,
        "lyapunov": sample.regime.lyapunov if sample else None,
        "evidence": sample.regime.reason if sample else "no input yet",
        "nearest calm speed (r/min)": _rpm(verdict.calm_speed),
        "probability of danger": verdict.danger,
        "probability of chaos by the map": verdict.probability,
        "signs": "; ".join(f"{each.kind} {each.probability:.0%}" for each in verdict.evidence) or "none",
        "motion (log-odds)": verdict.odds or "not seen",
    }


def _rpm(speed: float | None) -> float | None:
    return None if speed is None else speed / RPM


def _text(value: object) -> str:
    if value is None:
        return "unknown"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
