"""The blocks from Python: engineering units in and out, arrays as one call, the bits of the drive."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import narx
from narx.blocks import Commutation, Hall, Pi, Ramp, Step, ZeroCrossing

LSB = 2.0**-16


def test_pi_is_its_equation_and_run_is_steps() -> None:
    def make() -> Pi:
        return Pi(proportional=0.5, integral=20.0, step_rate=1000, minimum=-10.0, maximum=10.0)

    error = np.where(np.arange(400) < 200, 1.0, -0.3)
    pi = make()
    output = pi.run(error)
    expected = 0.5 * error + np.cumsum(error) * pi.integral / 1000
    assert output == pytest.approx(expected, abs=2 * LSB)
    stepped = make()
    assert output.tolist() == [stepped.step(value) for value in error]
    assert pi.proportional == 0.5 and pi.integral == pytest.approx(20.0, rel=1e-8)
    # The controller continues from its state, and its output never exceeds its limits.
    assert pi.run([0.0])[0] == pytest.approx(output[-1] + 0.15, abs=4 * LSB)
    assert np.abs(pi.run(np.full(2000, 5.0))).max() == 10.0
    pi.hold(3.0)
    assert pi.step(0.0) == 3.0
    for _ in range(200):
        pi.track(1.0, 0.0)
    assert pi.step(0.0) == pytest.approx(1.0, abs=2 * LSB)


def test_ramp() -> None:
    ramp = Ramp(rate=100.0, step_rate=1000, value=-1.0)
    values = ramp.run(np.ones(30))
    assert values == pytest.approx(np.minimum(-1.0 + 0.1 * np.arange(1, 31), 1.0), abs=2 * LSB)
    assert ramp.value == ramp.step(1.0) == 1.0 and ramp.rate == pytest.approx(100.0, rel=1e-6)
    ramp.value = 0.0
    assert ramp.step(-1.0) == pytest.approx(-0.1, abs=2 * LSB)


def test_commutation_is_the_table() -> None:
    forward = [Step.AB, Step.AC, Step.BC, Step.BA, Step.CA, Step.CB]
    assert [Commutation.for_sector(sector) for sector in range(6)] == forward
    assert Commutation.for_sector(0, reverse=True) is Step.BA
    assert Commutation.legs(Step.AB) == ("switched", "low", "floating")
    # One electrical revolution at 20 rev/s, from 30.3 degrees on: 500 ticks, 83.3 in a sector.
    angle = 30.3 + np.arange(500) * 360.0 * 20.0 / 10_000
    steps = Commutation().run(angle, np.full(500, 20.0))
    ends = (angle + 0.72 - 30.0) // 60.0 % 6
    assert steps.tolist() == [forward[int(sector)] for sector in ends]
    step, [(instant, following)] = Commutation(advance=10.0).step(79.7, 20.0)
    assert (step, following) == (Step.AB, Step.AC) and instant == pytest.approx(0.3 / 0.72, abs=1e-3)


def hall_code(turns: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Returns the code of sensors that are high for half a revolution from 330 degrees on."""
    lines = [((turns + 30 / 360 - phase / 3) % 1.0 < 0.5).astype(np.uint8) << phase for phase in range(3)]
    return (lines[0] | lines[1] | lines[2]).astype(np.uint8)


@pytest.mark.parametrize(("captured", "degrees"), [(False, 6.0), (True, 0.1)])
def test_hall_follows_a_rotor(captured: bool, degrees: float) -> None:
    rate, speed = 10_000, -130.0
    turns = 0.3 + np.arange(2000) / rate * speed
    # The edges lie at 30 + 60 k degrees.
    k = np.arange(int(turns[0] * 6 - 0.5), np.floor(turns[-1] * 6 - 0.5), -1)
    times = ((k + 0.5) / 6 - turns[0]) / speed
    edges = {"edge_time": times, "edge_code": hall_code((k + 0.5) / 6 - 1e-9)} if captured else {}
    found = Hall(captured=captured).run(hall_code(turns), **edges)
    late = slice(500, None)
    assert found["speed"][late] == pytest.approx(speed, rel=1e-4 if captured else 0.05)
    error = (found["angle"] - turns * 360.0 + 180.0) % 360.0 - 180.0
    assert np.abs(error[late]).max() < degrees
    assert not found["doubtful"].any() and not found["stopped"][late].any()


def test_hall_by_steps_tells_glitches() -> None:
    hall = Hall(timeout=0.02)
    assert hall.step(1).sector == 0
    reading = [hall.step(7) for _ in range(3)][-1]
    assert reading.invalid and reading.doubtful and hall.glitches == (1, 0)
    assert [hall.step(1) for _ in range(250)][-1].stopped


def test_two_blocks_turn_a_motor_without_sensors() -> None:
    rate, speed, bus, peak = 10_000, 90.0, 24.0, 5.0
    crossing, commutation = ZeroCrossing(timeout=0.03), Commutation()
    crossing.start(120.0)
    turns, step, changes = 1 / 3, Step.COAST, list[tuple[float, Step]]()
    volts = np.zeros((1500, 3))
    force = np.zeros(1500, dtype=np.uint8)
    for tick in range(1500):
        turns += speed / rate
        last = changes[-1][1] if changes else step
        for phase, leg in enumerate(Commutation.legs(last)):
            emf = peak * np.sin(2 * np.pi * (turns - phase / 3))
            volts[tick, phase] = {"switched": bus, "low": 0.0, "floating": np.clip(bus / 2 + 1.5 * emf, 0, bus)}[leg]
        reading = crossing.step(volts[tick].tolist(), bus, step, changes)
        step, changes = commutation.step(reading.angle, reading.speed)
        force[tick] = last
        if tick > 400:
            assert reading.running and reading.why == "accepted" and reading.lost is None
            assert reading.speed == pytest.approx(speed, rel=0.02)
            assert abs((reading.angle - turns * 360.0 + 180.0) % 360.0 - 180.0) < 4.0
            assert reading.commutation is not None and 0.0 <= reading.commutation < 1.2 / (6 * speed)
    # Terminal voltages of the run as arrays; the changes of the step are rounded to whole periods.
    again = ZeroCrossing(timeout=0.03)
    again.start(120.0)
    found = again.run(volts, np.full(1500, bus), force)
    assert found["running"][400:].all() and found["speed"][400:] == pytest.approx(speed, rel=0.05)
    assert np.isfinite(found["crossing"]).sum() == pytest.approx(0.15 * speed * 6, abs=6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Pi(-1.0, 1.0, 1000, 0.0, 1.0), "proportional -1: must be from 0 to 1073741823"),
        (lambda: Pi(1.0, 1.0, 0, 0.0, 1.0), "step_rate 0 Hz: must be a whole number from 1 to 1000000 Hz"),
        (lambda: Pi(1.0, 1.0, 1000, 1.0, 0.5), "minimum 1: must be from -32768 to 0.5"),
        (lambda: Pi(1.0, 1.0, 1000, 0.0, 1.0).run([0.0, np.nan]), r"error\[1\] NaN: must be from -32768 to"),
        (lambda: Ramp(0.0, 1000), "rate 0: must be from 0.0000152588 to 32768"),
        (lambda: Ramp(1.0, 1000).step(40_000.0), "target 40000: must be from -32768 to 32768"),
        (lambda: Commutation(advance=31.0), "advance 31 degrees: must be from 0 to 30"),
        (lambda: Commutation().run([0.0, 1.0], [1.0]), "speed of 1 rows: must have 2, as angle has"),
        (lambda: Commutation.for_sector(6), "sector 6: must be a whole number from 0 to 5"),
        (lambda: Commutation.legs(13), "step 13: must be a whole number from 0 to 12"),
        (lambda: Hall(order=6), "order 6: must be a whole number from 0 to 5"),
        (lambda: Hall(timeout=7.0), "timeout 7 s: must be from 0.001 to 6.553"),
        (lambda: Hall().run([1], [0.0]), "edge_time and edge_code: one without the other"),
        (lambda: Hall().run([1], [0.1, 0.0], [1, 2]), r"edge_time\[1\] 0 s: must be a finite number, not before"),
        (lambda: ZeroCrossing(volts_per_code=0.1), "volts_per_code 0.1 V: must be from 0.000001 to 0.0625"),
        (lambda: ZeroCrossing(blanking=-1.0), "blanking -1 s: must be from 0 to 0.1"),
        (lambda: ZeroCrossing(timeout=4.0), "timeout 4 s: must be from 0.0001 to 3.2767"),
        (lambda: Hall(offset=181.0), "offset 181 degrees: must be from -180 to 180"),
        (lambda: ZeroCrossing().run(np.zeros((2, 2)), [1.0, 1.0], [0, 0]), "phase_voltage of 2 columns: must have 3"),
        (lambda: ZeroCrossing().step([0.0, 0.0, np.nan], 1.0, 0), "phase_voltage NaN V: must be a finite number"),
    ],
)
def test_bad_settings_are_named(make: Any, message: str) -> None:
    with pytest.raises(narx.ParameterError, match=message):
        make()


def test_settings_reach_the_ends_of_their_ranges() -> None:
    for advance in (0.0, 30.0):
        Commutation(advance=advance)
    for offset, timeout in ((-180.0, 0.001), (180.0, 6.553)):
        Hall(offset=offset, timeout=timeout)
    ZeroCrossing(volts_per_code=1e-6, blanking=0.0, back_emf=0.0, timeout=0.0001)
    ZeroCrossing(volts_per_code=0.0625, blanking=0.1, back_emf=1.0, timeout=3.2767)


def test_coefficients_are_constants_in_c() -> None:
    pi = Pi(proportional=0.5, integral=5.0, step_rate=1000, minimum=0.0, maximum=6.0)
    text = pi.to_c("speed_loop")
    assert text.startswith("static const narx_pi_ready_t speed_loop = {") and text.endswith("};\n")
    assert ".minimum = 0,\n    .maximum = 393216," in text
    for text, kind in [
        (Ramp(rate=10.0, step_rate=1000).to_c(), "narx_ramp_ready_t ramp"),
        (Hall().to_c(), "narx_hall_ready_t hall"),
        (Commutation(advance=5.0).to_c(), "narx_commutator_coefficients_t commutation"),
        (ZeroCrossing().to_c(), "narx_zero_crossing_ready_t zero_crossing"),
    ]:
        assert f"static const {kind} = {{" in text
    with pytest.raises(narx.ParameterError, match='name "a-b": is not a name in C'):
        pi.to_c("a-b")
