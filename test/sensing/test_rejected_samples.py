"""Samples that are refused: counted, explained, and without any trace in the model."""

from math import inf, nan

import pytest

from seat_gear_dynamics.gears import GearTrain
from seat_gear_dynamics.sensing import RejectedSampleError, VirtualSensor

# (time, speed rad/s, load N·m) after samples up to t = 0.2 s, the key it is counted under, and words of its sentence.
REFUSED = {
    "NaN time": ((nan, 50.0, 100.0), "not finite", "The time is nan s, expected a finite number"),
    "infinite time": ((inf, 50.0, 100.0), "not finite", "The time is inf s"),
    "NaN speed": ((0.21, nan, 100.0), "not finite", "The speed is nan rad/s"),
    "infinite speed": ((0.21, -inf, 100.0), "not finite", "The speed is -inf rad/s"),
    "NaN load": ((0.21, 50.0, nan), "not finite", "The load is nan N·m"),
    "absurd speed": ((0.21, 12000.0, 100.0), "absurd", "The speed is 12000 rad/s, expected at most 1256.64"),
    "absurd speed backward": ((0.21, -12000.0, 100.0), "absurd", "The speed is -12000 rad/s"),
    "absurd load": ((0.21, 50.0, 5001.0), "absurd", "The load is 5001 N·m, expected at most 5000"),
    "absurd negative load": ((0.21, 50.0, -5001.0), "absurd", "The load is -5001 N·m"),
    "repeated time": ((0.2, 50.0, 100.0), "duplicate", "The sample's time is 0.2 s, expected later than 0.2 s"),
    "late": ((0.15, 50.0, 100.0), "late", "The sample's time is 0.15 s, expected later than 0.2 s"),
    "as late as the gap": ((-0.3, 50.0, 100.0), "late", "The sample's time is -0.3 s"),
}


def run_up(sensor: VirtualSensor) -> None:
    sensor.reset()
    sensor.counts.clear()
    for n in range(21):
        sensor.update(n / 100, 50.0 + n, 100.0)


@pytest.fixture(scope="module")
def sensor(train: GearTrain) -> VirtualSensor:
    return VirtualSensor(train)


@pytest.mark.parametrize("case", REFUSED)
def test_refused_sample_is_counted_under_its_reason_and_explained_in_one_sentence(
    sensor: VirtualSensor, case: str
) -> None:
    sample, reason, words = REFUSED[case]
    run_up(sensor)
    before = dict(sensor.counts)
    with pytest.raises(RejectedSampleError) as caught:
        sensor.update(*sample)
    assert caught.value.reason == reason
    assert str(caught.value).startswith(words)
    assert str(caught.value).endswith(".")
    assert dict(sensor.counts) == before | {reason: 1}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_sample_leaves_the_model_as_if_it_had_never_come(sensor: VirtualSensor, case: str) -> None:
    run_up(sensor)
    undisturbed = [sensor.update(0.22 + n / 100, 60.0, 100.0) for n in range(10)]
    run_up(sensor)
    with pytest.raises(RejectedSampleError):
        sensor.update(*REFUSED[case][0])
    disturbed = [sensor.update(0.22 + n / 100, 60.0, 100.0) for n in range(10)]
    for one, other in zip(undisturbed, disturbed, strict=True):
        assert (one.event, one.windows, one.contacts, one.regime) == (
            other.event,
            other.windows,
            other.contacts,
            other.regime,
        )
        assert one.section.tolist() == other.section.tolist()


def test_the_limits_themselves_are_accepted(sensor: VirtualSensor, train: GearTrain) -> None:
    sensor.reset()
    model = train.model
    for n, (speed, load) in enumerate([(model.max_speed, model.max_load), (-model.max_speed, -model.max_load)]):
        sensor.update(n * 1e-3, speed, load)


def test_a_refused_first_sample_starts_nothing(sensor: VirtualSensor) -> None:
    sensor.reset()
    with pytest.raises(RejectedSampleError):
        sensor.update(0.0, nan, 100.0)
    assert sensor.update(0.0, 50.0, 100.0).event == "started"


def test_counts_survive_a_reset(sensor: VirtualSensor) -> None:
    run_up(sensor)
    sensor.reset()
    assert sensor.counts == {"started": 1, "accepted": 20}
