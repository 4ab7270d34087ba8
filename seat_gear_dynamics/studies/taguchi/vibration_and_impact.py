"""The study of vibration and impact: which excitation and design quantities make the gears vibrate and rattle.

The paper announces it (claim C15) and prints no response, array or result.
"""

from collections.abc import Sequence
from math import copysign, sqrt

from seat_gear_dynamics.motion import Response, System, integrate
from seat_gear_dynamics.studies.taguchi.result import Setting, Study
from seat_gear_dynamics.studies.taguchi.study import Evaluate, run_study
from seat_gear_dynamics.studies.taguchi.variations import BACKED_OFF, CONTROLS, NOISE, Variation

RESPONSES = ("vibration", "impact")


def responses_of(response: Response) -> dict[str, float]:
    """Return vibration, impact and what they are made of, for the force F of P12 over the sampled periods.

    `vibration` = rms(F − mean F)/|mean F|: the dynamic force that bearings and seat feel, per unit of the force that
    does the work, so that load does not count as vibration by itself.

    `impact` = (peak F/mean F − 1)·(1 + s), s the share of time out of contact. The overshoot alone does not tell a blow
    from a load that swells in contact; the share alone is 0 for every motion in contact, where a signal-to-noise ratio
    would be infinite, and does not tell how hard teeth come back. Their product, at most twice the overshoot, has its
    ideal at 0, as smaller-the-better wants it. It is a convention; both parts are returned as `overshoot` and
    `contact_loss`, and any other weight can be made of them. The peak is that of the force which carries the load.

    Raises ValueError where the mean force is 0 and ratios to it mean nothing. Limit: forces are those of the model's
    scaled load (`load_scale`), and the damping force acts out of contact too.
    """
    window = response.windows[0]
    if window.mean == 0:
        raise ValueError("The mean force of P12 is 0, so that vibration and impact have no scale; give a load.")
    peak = window.maximum if window.mean > 0 else window.minimum
    overshoot = peak / window.mean - 1
    return {
        "vibration": sqrt(max(window.rms**2 - window.mean**2, 0.0)) / abs(window.mean),
        "impact": overshoot * (1 + window.contact_loss),
        "overshoot": overshoot,
        "contact_loss": window.contact_loss,
    }


def experiment(
    system: System, variations: Sequence[Variation], *, transient: int = 300, periods: int = 280
) -> Evaluate:
    """Return the experiment of `run_study` on this system: values of factors by name in, responses out.

    Each setting is put into the system in the order of `variations`, and P12 integrated over `transient` mesh periods
    and sampled over `periods`, from static deflection moved apart by BACKED_OFF times the backlash. In 280 periods
    s2 turns seven times. Raises DivergedError where the solution blows up, ValueError at a frequency of 0. Limit: the
    peak of a chaotic motion grows with the number of periods.
    """

    def evaluate(setting: Setting) -> dict[str, float]:
        varied = system
        for variation in variations:
            if variation.name in setting:
                varied = variation.apply(varied, setting[variation.name])
        state = varied.static_state()
        gap = setting.get(BACKED_OFF, 0.0) * varied.train.meshes[0].backlash
        state[2] -= copysign(gap, varied.operating_point.load) / varied.train.model.displacement_scale
        return responses_of(integrate(varied, transient=transient, periods=periods, state=state))

    return evaluate


def vibration_and_impact(
    system: System,
    *,
    controls: Sequence[Variation] | None = None,
    noise: Sequence[Variation] | None = None,
    responses: Sequence[str] = RESPONSES,
    array: str | None = None,
    pooled: Sequence[str] | None = None,
    confidence: float = 0.95,
    transient: int = 300,
    periods: int = 280,
    workers: int = 2,
    evaluate: Evaluate | None = None,
) -> Study:
    """Return the Taguchi study of vibration and impact of P12 around the operating point of `system`.

    `controls` and `noise` default to CONTROLS and NOISE; a factor that the system cannot vary is left out. Both
    responses are smaller-the-better, see `responses_of`; the other arguments are those of `run_study` and `experiment`.
    `evaluate` replaces the experiment. Raises ValueError as `run_study` does, and for a frequency or a load of 0.

    Limits: P12 alone. Load and speed are drives, not design; they stand among the controls because the question is
    which excitation matters most, and their best level is advice on where to operate. Gear motion knows bifurcations: a
    level mean then averages over different motions, and the confirmation run decides. An L18 spreads interactions over
    its columns: for the packaged train at Ω = 0.5 and 600 N·m shares below a tenth change with the order of `controls`
    and in an L27 (eccentricity in impact: 8.5 %, in reversed order 0.6 %, in an L27 0.4 %), and so do best levels of
    such factors, but for damping's. Only larger shares are findings.
    """
    if system.operating_point.load == 0:
        raise ValueError("The load is 0 N·m, where vibration and impact have no mean force for a scale; give a load.")
    varied, disturbed = CONTROLS if controls is None else controls, NOISE if noise is None else noise
    factors, disturbances = (
        [factor for variation in variations if (factor := variation.factor(system)) is not None]
        for variations in (varied, disturbed)
    )
    return run_study(
        factors,
        evaluate or experiment(system, [*varied, *disturbed], transient=transient, periods=periods),
        responses,
        noise=disturbances,
        array=array,
        pooled=pooled,
        confidence=confidence,
        workers=workers,
    )
