"""The board's image on the model of its chip, with a motor and a master on its bus."""

import functools
import os
import pathlib
import traceback
import warnings

import narx
import pytest
from narx import Load, State
from stm32g4 import Chip
from stm32g4.boards import B_G431B_ESC1
from stm32g4.can_bus import ChipBus
from stm32g4.chip import Image

warnings.filterwarnings("ignore", category=narx.NarxWarning)

MOTOR = narx.Motor.preset("bly172s-24v")
SUPPLY, CAPACITANCE = 24.0, 470e-6
"""Supply, V, with a capacitor beside it, F: the board's own 100 uF rise above the threshold of 27 V when currents end."""
RUNNING = {"hall": State.HALL_CLOSED_LOOP, "sensorless": State.SENSORLESS_CLOSED_LOOP}
OFF = ("off", "off", "off")
SPEED = 2000


class Bench:
    """A board with its motor, and the master."""

    def __init__(self, image, flash=None, motor=MOTOR, mutation=None, boot=None, board=B_G431B_ESC1, **plant):
        self.plant = narx.Plant(motor, supply_voltage=SUPPLY, **{"capacitance": CAPACITANCE} | plant)
        self.chip = Chip(image, self.plant, flash, boot, board)
        if mutation is not None:
            self.chip.mutate(mutation)
        self.bus = ChipBus(self.chip)
        self.drive = narx.Drive(self.bus, read_parameters=False)
        # The board has no description of itself; asking for it takes a second of its time.
        self.drive._link.is_described = True

    def wait(self, condition, seconds):
        """Waits in the board's time."""
        return self.drive.wait_for(condition, seconds)

    def run(self, seconds):
        self.drive.wait_for(lambda: False, seconds)

    def reach(self, state, seconds=1.0):
        assert self.wait(lambda: self.drive.state is state, seconds), f"{self.drive.state!r} with {self.drive.faults}, no {state!r}"

    def stand_by(self):
        """Waits for Standby after power-up; the master acknowledges faults that are over."""
        assert self.wait(lambda: self.drive.state not in (None, State.INITIALIZATION), 1.5), "the drive does not answer"
        self.drive.stop()
        self.reach(State.STANDBY, 0.3)

    def turns_at(self, speed):
        """Starts the motor, and looks whether it reaches its speed."""
        self.drive.start(speed)
        self.run(0.3)
        return self.mean_speed() == pytest.approx(speed, rel=5e-3)

    def spin(self, mode):
        """From Standby: starts the motor, loads it, stops it, and turns it the other way."""
        self.drive.start(SPEED)
        assert self.drive.state is RUNNING[mode]
        self.run(0.4)
        assert self.mean_speed() == pytest.approx(SPEED, rel=5e-3)
        assert self.drive.measurements.speed == pytest.approx(SPEED, rel=1e-2)

        self.plant.set_load(Load(constant=0.08))
        self.run(0.3)
        assert self.mean_speed() == pytest.approx(SPEED, rel=5e-3)
        flows, shown = self.bus_currents()
        # A sample in the on-time does not show the current that returns to the bus in the off-time.
        assert flows > 0.5 and flows < shown < 1.1 * flows
        self.plant.set_load(Load())

        self.drive.stop()
        self.reach(State.STANDBY)
        assert self.chip.gates == OFF
        assert self.wait(lambda: abs(self.plant.speed) < 50, 3.0), "it comes to rest by itself"
        self.drive.start(-1500)
        self.run(0.3)
        assert self.mean_speed() == pytest.approx(-1500, rel=5e-3)
        assert self.drive.faults == set() and self.chip.resets == []

    def mean_speed(self, seconds=0.05):
        """True speed over some time, rpm."""
        angle, time = self.plant.angle_deg, self.plant.time
        self.run(seconds)
        return (self.plant.angle_deg - angle) / 360.0 / (self.plant.time - time) * 60.0

    def bus_currents(self, seconds=0.2):
        """Mean current out of the supply, and what the drive shows of it, A."""
        charge, time, shown = self.plant.charge, self.plant.time, []
        while self.plant.time < time + seconds:
            self.run(0.02)
            shown.append(self.drive.measurements["HV Current"])
        return (self.plant.charge - charge) / (self.plant.time - time), sum(shown) / len(shown)

    def commission(self, mode):
        """Writes the parameters that differ, and stores them."""
        board = self.chip.board
        for name, value in (MOTOR.commission(SUPPLY, mode=mode, pwm_rate=board.pwm_rate) | board.parameters).items():
            if self.drive.parameters[name] != pytest.approx(value):
                self.drive.parameters[name] = value
        self.drive.parameters.store()


def forked(test):
    """Runs a test in a copy of this process, so that it may do anything to the bench that others go on with."""

    @functools.wraps(test)
    def in_copy(*arguments, **named):
        receive, send = os.pipe()
        child = os.fork()
        if child == 0:
            problem = b""
            try:
                test(*arguments, **named)
            except BaseException:
                problem = traceback.format_exc().encode()
            os.write(send, problem[:60_000])
            os._exit(0)
        os.close(send)
        with os.fdopen(receive, "rb") as pipe:
            problem = pipe.read()
        os.waitpid(child, 0)
        if problem:
            pytest.fail(problem.decode(), pytrace=False)

    return in_copy


@pytest.fixture(scope="session")
def image():
    """The drive's image; `cargo xtask test firmware` says where it is."""
    return Image(pathlib.Path(os.environ["NARX_BOARD_IMAGE"]))


@pytest.fixture(scope="session")
def boot():
    """The bootloader's image."""
    return Image(pathlib.Path(os.environ["NARX_BOARD_BOOTLOADER"]))


def stored(image, mode, board=B_G431B_ESC1):
    bench = Bench(image, board=board)
    assert bench.wait(lambda: bench.drive.state is State.FAULT, 1.0)
    bench.commission(mode)
    return bytes(bench.chip.processor.flash)


@pytest.fixture(scope="session")
def hall_flash(image):
    """Flash of a board that is set up for the motor with its hall sensors."""
    return stored(image, "hall")


@pytest.fixture(scope="session")
def sensorless_flash(image):
    """Flash of a board that is set up for the motor without sensors."""
    return stored(image, "sensorless")


@pytest.fixture(scope="session")
def standing(image, hall_flash):
    """A board in Standby. Use it in a forked test."""
    bench = Bench(image, hall_flash)
    bench.stand_by()
    return bench


@pytest.fixture(scope="session")
def turning(image, hall_flash):
    """A board whose motor turns at 2000 rpm. Use it in a forked test."""
    bench = Bench(image, hall_flash)
    bench.stand_by()
    bench.drive.start(2000)
    bench.run(0.35)
    return bench
