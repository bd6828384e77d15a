"""What turns the gates off without the processor, and what the drive makes of it."""

import pytest
from conftest import OFF, Bench, forked
from faults import without, writes
from narx import State
from stm32g4 import SECOND, Stopped

HARDWARE = 0.2e-6
"""Break: the comparator's delay, and eight clocks of the filter (docs/B-G431B-ESC1.md: within 0.1 us)."""
TRIP = 25.0
RESET_CAUSE, PROGRAM = 302, 5


@forked
def test_a_shunts_over_current_turns_the_gates_off_without_the_processor(turning):
    # Shunts A and C: the examination of test_faults.py.
    chip, place = turning.chip, 1
    # In the middle of a critical section, as far as anybody knows: the processor does nothing meanwhile.
    instructions = chip.processor.clock.instructions
    assert chip.gates != OFF
    chip.set_foreign_current(place, TRIP + 2.0)
    chip.processor.clock.time += round(HARDWARE * SECOND)
    chip.follow_plant()
    assert chip.gates == OFF and chip.processor.clock.instructions == instructions
    turning.run(0.01)
    assert turning.wait(lambda: turning.drive.state is State.FAULT, 0.2)
    assert "emergency_shutdown" in turning.drive.faults and chip.gates == OFF

    # Coast for 0.1 s, the cause gone: the outputs may come back.
    chip.set_foreign_current(place, 0.0)
    turning.run(0.3)
    turning.drive.stop()
    turning.reach(State.STANDBY)
    assert turning.turns_at(1500)


@forked
def test_a_current_below_the_threshold_does_not_trip(turning):
    turning.chip.set_foreign_current(0, TRIP - 7.0)
    turning.chip.run(50e-6)
    assert not turning.chip.is_tripped(0)


@forked
def test_the_button_as_shutdown_input_coasts(standing):
    standing.drive.parameters[270] = 2
    standing.drive.start(1500)
    standing.run(0.2)
    assert standing.chip.gates != OFF
    standing.chip.button_pressed = True
    standing.chip.run(0.003)
    assert standing.chip.gates == OFF


@forked
def test_a_master_that_falls_silent_stops_the_motor(turning):
    turning.chip.bus.is_there = False
    turning.chip.run(0.2)
    assert turning.chip.gates != OFF
    turning.chip.run(0.15)
    assert turning.chip.gates == OFF
    turning.chip.bus.is_there = True
    turning.reach(State.FAULT, 2.0)


@forked
def test_a_crystal_that_stops_turns_the_gates_off_and_resets_the_drive(turning):
    chip = turning.chip
    chip.clocks.set_crystal(runs=False)
    assert chip.gates == OFF, "without the processor"
    chip.run(0.01)
    assert chip.resets == ["software"] and chip.gates == OFF
    assert chip.clocks.rate == 16e6, "it waits for its crystal"
    chip.clocks.set_crystal(runs=True)
    assert turning.wait(lambda: turning.drive.state is State.STANDBY, 1.5)
    assert turning.drive.parameters[RESET_CAUSE] == PROGRAM
    assert turning.turns_at(1500)


@forked
def test_a_crystal_that_nobody_watches_is_found(image, hall_flash):
    bench = Bench(image, hall_flash, mutation=writes("RCC.CR", without(19)))
    bench.stand_by()
    with pytest.raises(Stopped, match="the crystal has stopped, and nobody watches it"):
        bench.chip.clocks.set_crystal(runs=False)
