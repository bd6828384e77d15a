"""Fixtures of pytest for tests of your own project: a bench, a drive at speed, a virtual bus. pytest finds them
once the package is installed.

    def test_the_pump_survives_a_step(narx_bench):
        bench = narx_bench("bly172s-24v", mode="hall")
        bench.drive.start(2000)
        bench.set_load(0.05)
        assert bench.run(0.5)["speed"].min() > 1800
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeAlias

import pytest

import narx
from narx.extras import need

if TYPE_CHECKING:
    import can

MOTOR = "ec45-flat-50w-18v"
"""Motor of a bench for which no other is named."""
SPEED = 2000
"""Set-point of a drive for which no other is named, rpm."""
SETTLED = 0.02
"""Largest difference of a settled speed from the set-point, share of it."""
LONGEST = 30.0
"""Longest simulated time to a settled speed, s."""

BenchMaker: TypeAlias = Callable[..., narx.Bench]
BusMaker: TypeAlias = Callable[..., "can.BusABC"]

_channels = itertools.count(1)


@pytest.fixture
def narx_bench() -> BenchMaker:
    """Returns a function that makes a bench: its arguments are those of `narx.Bench`, by default a small motor
    with hall sensors. The seed is always the same, so that a test gives the same bits every time."""

    def make(motor: narx.Motor | str = MOTOR, *arguments: Any, **options: Any) -> narx.Bench:
        if len(arguments) < 3:
            options.setdefault("mode", "hall")
        return narx.Bench(motor, *arguments, **options)

    return make


@pytest.fixture
def narx_running(narx_bench: BenchMaker) -> BenchMaker:
    """Returns a function that makes a bench whose motor runs at `rpm` (2000), settled within 2 %. Its other
    arguments are those of `narx.Bench`. Raises StartError if the speed does not settle within 30 s."""

    def make(*arguments: Any, rpm: int = SPEED, **options: Any) -> narx.Bench:
        bench = narx_bench(*arguments, **options)
        bench.drive.start(rpm)
        settle(bench, rpm)
        return bench

    return make


@pytest.fixture
def narx_bus(request: pytest.FixtureRequest) -> Iterator[BusMaker]:
    """Returns a function that opens a bus of python-can with a virtual drive: its arguments are those of
    `library.Bus(interface="narx")`, by default a small motor with hall sensors and `realtime=False`. All calls of one
    test open the same bus, and the end of the test closes it."""
    library = need("can")
    channel = f"{request.node.nodeid} {next(_channels)}"
    opened: list[can.BusABC] = []

    def make(**options: Any) -> can.BusABC:
        if not opened:
            options = {"motor": MOTOR, "supply_voltage": 18.0, "mode": "hall", "realtime": False} | options
        bus: can.BusABC = library.Bus(interface="narx", **{"channel": channel} | options)
        opened.append(bus)
        return bus

    yield make
    for bus in opened:
        bus.shutdown()


def settle(bench: narx.Bench, rpm: float) -> None:
    """Runs a bench until its speed stays within 2 % of a set-point, rpm, for 0.1 s. Raises StartError if it does
    not within 30 s."""
    end = bench.time + LONGEST
    while bench.time < end:
        speed = bench.run(0.1, signals=["speed"])["speed"]
        if (abs(speed - rpm) <= SETTLED * abs(rpm)).all():
            return
    faults = ", ".join(sorted(bench.drive.faults)) or "no fault"
    raise narx.StartError(f"{rpm:g} rpm: the speed is {speed[-1]:.0f} rpm after {LONGEST:g} s, with {faults}")
