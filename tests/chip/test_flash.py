"""Parameters in the chip's own flash, and a supply that goes while they are written."""

import narx
import pytest
from conftest import Bench, forked
from narx import State
from stm32g4.flash import PowerCut

NAME, NEW = "Winding resistance", 0.9


class Cells:
    """What the flash's cells hold while there is no power."""

    def __init__(self, chip):
        self.data, self.torn = bytes(chip.processor.flash), dict(chip.flash.torn)


def power_up(image, cells):
    bench = Bench(image, cells.data)
    bench.chip.flash.torn.update(cells.torn)
    assert bench.wait(lambda: bench.drive.state not in (None, State.INITIALIZATION), 1.5)
    assert bench.chip.resets == []
    return bench


def cells_after_cut(bench, operation):
    """Changes a parameter, and cuts the supply in this operation of its store; None if it has fewer."""
    flash = bench.chip.flash
    flash.cut_at = flash.operations + operation
    bench.drive.parameters[NAME] = NEW
    try:
        bench.drive.parameters.store()
    except PowerCut:
        return Cells(bench.chip)
    return None


@forked
def test_what_is_stored_is_there_after_the_power_was_off(image, standing):
    standing.drive.parameters[NAME] = NEW
    standing.drive.parameters.store()
    again = power_up(image, Cells(standing.chip))
    assert again.drive.parameters[NAME] == pytest.approx(NEW) and again.drive.faults == set()


@pytest.mark.parametrize("operation", [1, 2, 3, 4])
@forked
def test_a_power_cut_in_a_word_leaves_the_old_value_or_the_new_one(image, standing, operation):
    old = standing.drive.parameters[NAME]
    cells = cells_after_cut(standing, operation)
    again = power_up(image, cells)
    # Two words a copy: the first one is whole from the third on.
    assert again.drive.parameters[NAME] == pytest.approx(NEW if operation > 2 else old)
    assert again.drive.faults == set(), "nothing that was stored is lost"


@forked
def test_a_power_cut_while_the_next_boot_repairs_the_page_loses_nothing(image, standing):
    old = standing.drive.parameters[NAME]
    cells = cells_after_cut(standing, 1)
    boot = Bench(image, cells.data)
    boot.chip.flash.torn.update(cells.torn)
    boot.chip.flash.cut_at = 1
    with pytest.raises(PowerCut):
        boot.chip.run(1.0)
    cells = Cells(boot.chip)
    assert len(cells.torn) >= 256, "a page of cells with any charge, and none of its words whole"
    again = power_up(image, cells)
    assert again.drive.parameters[NAME] == pytest.approx(old) and again.drive.faults == set()


@forked
def test_a_store_is_refused_while_the_motor_turns(turning):
    with pytest.raises(narx.RefusedError):
        turning.drive.parameters.store()
    assert turning.drive.state is State.HALL_CLOSED_LOOP
