"""The fixtures that a project of somebody else gets from the package."""

import pytest

pytest_plugins = ["pytester"]

TESTS = """
import can
import pytest
import narx


def test_bench(narx_bench):
    bench = narx_bench()
    assert repr(bench) == "<narx.Bench of ec45-flat-50w-18v, 18 V, hall: Initialization, 0.000 s>"
    assert "bly172s-24v, 30 V, sensorless" in repr(narx_bench("bly172s-24v", 30.0, mode="sensorless"))
    assert "24 V, hall" in repr(narx_bench(narx.Motor.preset("bly172s-24v"), supply_voltage=24.0))


def test_running(narx_running):
    bench = narx_running(rpm=-1500, load=narx.Load(constant=0.02))
    assert bench.drive.state is narx.State.HALL_CLOSED_LOOP
    assert abs(bench.run(0.1)["speed"] + 1500).max() < 30


def test_the_same_bits(narx_running):
    assert narx_running().digest == narx_running().digest


def test_never_settles(narx_running):
    with pytest.raises(narx.StartError, match="after 30 s, with"):
        narx_running("bly172s-24v", rpm=3500, load=narx.Load(constant=0.1), parameters={"Phase current limit": 1.5})


@pytest.mark.parametrize("time", range(2))
def test_bus(narx_bus, time):
    bus, other = narx_bus(), narx_bus()
    assert bus.time == 0.0
    frame = bus.recv(1.0)
    assert narx.decode(frame).from_drive and other.recv(0.0) is not None


def test_a_drive_on_the_bus(narx_bus):
    with narx.Drive(narx_bus()) as drive:
        drive.start(2000)
        drive.wait(1.0)
        assert abs(drive.measurements.speed - 2000) < 50


def test_options(narx_bus):
    assert narx_bus(motor="bly172s-24v", supply_voltage=24.0, tx_drivers=[2]).time == 0.0
"""


def test_the_package_registers_its_fixtures(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(TESTS)
    pytester.runpytest_subprocess("-p", "no:cacheprovider", "-q").assert_outcomes(passed=8)


def test_the_fixtures_are_listed_with_what_they_give(pytester: pytest.Pytester) -> None:
    shown = pytester.runpytest_subprocess("--fixtures", "-q")
    for name in ("narx_bench", "narx_running", "narx_bus"):
        shown.stdout.fnmatch_lines(f"{name} -- *narx/testing.py:*")
