"""Flash and its controller (RM0440, section 3 and DS12589, section 5.3.12), and the words of the maker's."""

import struct

from stm32g4.boards import B_G431B_ESC1, Board
from stm32g4.processor import FLASH, NMI, PAGE, SYSTEM
from stm32g4.registers import SECOND, Peripheral

WORD = 8
ERASE, PROGRAM = SECOND * 22 // 1000, SECOND * 82 // 1_000_000
"""Times of a page and of a word, typical."""
PG, PER, BKER, STRT, LOCK = 1 << 0, 1 << 1, 1 << 11, 1 << 16, 1 << 31
BUSY = 1 << 16
EOP, PROGERR, PGAERR, SIZERR, PGSERR = 1 << 0, 1 << 3, 1 << 5, 1 << 6, 1 << 7
ERRORS = 0x3FA
KEYS = [0x4567_0123, 0xCDEF_89AB]
UNIQUE = (0x0046_0030, 0x5842_5010, 0x2036_3434)
REFERENCE_AT_3V = 1655
"""Code of the internal reference at 3.0 V (DS12589, section 3.18.2)."""


class PowerCut(Exception):
    """The supply has gone."""


class Flash(Peripheral):
    """FLASH. While it erases or programs, the processor waits if its program is in the same bank."""

    def __init__(self, chip: object) -> None:
        super().__init__(chip, "FLASH", 0x4002_2000)
        self.memory = chip.processor.flash
        # These outlive a reset.
        before = getattr(chip, "flash", None)
        self.torn: dict[int, int] = before.torn if before else {}
        """Words whose check bits do not fit, by their offset."""
        self.operations: int = before.operations if before else 0
        """Pages erased and words programmed so far."""
        self.cut_at: int | None = before.cut_at if before else None
        """The supply goes in the middle of this operation."""
        self.status, self.is_locked, self.keys = 0, True, []
        self.first: tuple[int, int] | None = None
        self.register(0x00, "ACR", 0x0004_1F0F, value=0x0004_0600)
        self.write_only(0x08, "KEYR", 0xFFFF_FFFF, self._key)
        self.bank_size = chip.board.flash_size // chip.board.banks
        self.busy_until = 0
        self.register(0x10, "SR", ERRORS | EOP | BUSY, read=self._status, write=self._clear)
        second = BKER if chip.board.banks == 2 else 0
        self.register(0x14, "CR", LOCK | STRT | second | 0x3FF, read=self._control, write=self._set_control)
        self.ecc = 0
        self.register(0x18, "ECCR", 0xFFFF_FFFF, read=lambda: self.ecc, write=self._clear_ecc)
        # As it leaves the maker: two banks where there are two.
        self.read_only(0x20, "OPTR", lambda: 0xFFEF_F8AA)
        self.control = 0
        words = bytearray(0x1000)
        struct.pack_into("<3I", words, 0x590, *UNIQUE)
        struct.pack_into("<H", words, 0x5AA, REFERENCE_AT_3V)
        chip.processor.engine.mem_write(SYSTEM, bytes(words))

    def _key(self, value: int) -> None:
        self.keys = [*self.keys, value][-2:]
        if value != KEYS[len(self.keys) - 1]:
            self.undefined(f"wrong key {value:#x}: locked until the next reset, and a bus error")
        if self.keys == KEYS:
            self.is_locked, self.keys = False, []

    def _status(self) -> int:
        return self.status | (BUSY if self.chip.now < self.busy_until else 0)

    def _clear(self, value: int) -> None:
        self.status &= ~value

    def _clear_ecc(self, value: int) -> None:
        if value >> 31 & 1:
            self.ecc = 0

    def _control(self) -> int:
        return self.control | (LOCK if self.is_locked else 0)

    def _set_control(self, value: int) -> None:
        if self.is_locked:
            self.undefined("CR is written while it is locked")
        if value & LOCK:
            self.is_locked = True
        if self.chip.now < self.busy_until:
            self.undefined("CR is written while it is busy")
        self.control = value & (0x3FF | BKER)
        if value & STRT:
            if not value & PER or value & PG:
                self.status |= PGSERR
            else:
                self._erase(PAGE * (value >> 3 & 0x7F) + (self.bank_size if value & BKER else 0))

    def _erase(self, start: int) -> None:
        if start < self.chip.processor.data_start - FLASH:
            self.undefined(f"erases the page at {FLASH + start:#x}, where the program is")
        cut = self._begin()
        for word in [word for word in self.torn if start <= word < start + PAGE]:
            del self.torn[word]
        if cut:
            # Half of the charge is gone: every cell reads anything, and no check bits fit.
            for word in range(start, start + PAGE, WORD):
                self.memory[word : word + WORD] = bytes((37 * (word + place)) % 256 for place in range(WORD))
                self.torn[word] = 1
            raise PowerCut
        self.memory[start : start + PAGE] = b"\xff" * PAGE
        self._end(start, ERASE)

    def write(self, address: int, size: int, value: int) -> None:
        """A write to the memory (section 3.3.7): two words make a double word."""
        place = address - FLASH
        if self.is_locked or not self.control & PG:
            self.status |= PGSERR
            return
        if size != 4:
            self.status |= SIZERR
            return
        if self.first is None:
            if place % WORD:
                self.status |= PGAERR
                return
            self.first = (place, value)
            return
        (start, low), self.first = self.first, None
        if place != start + 4:
            self.status |= PGAERR
            return
        word = struct.pack("<II", low, value)
        old = bytes(self.memory[start : start + WORD])
        if (old != b"\xff" * WORD and word != b"\0" * WORD) or start in self.torn:
            self.status |= PROGERR
            return
        if self._begin():
            self.memory[start : start + WORD] = bytes(byte | 0xA5 for byte in word)
            self.torn[start] = 1
            raise PowerCut
        self.memory[start : start + WORD] = word
        self._end(start, PROGRAM)

    def _begin(self) -> bool:
        if self.status & ERRORS:
            self.status |= PGSERR
        self.operations += 1
        return self.operations == self.cut_at

    def _end(self, place: int, time: int) -> None:
        if place < self.bank_size:
            self.chip.stall(time)
        else:
            self.busy_until = self.chip.now + time

    def read(self, address: int, size: int) -> int:
        place = address - FLASH
        if place >= self.bank_size and self.chip.now < self.busy_until:
            self.chip.stall(self.busy_until - self.chip.now)
        if place // WORD * WORD in self.torn:
            self.ecc = 1 << 31 | place // WORD
            self.chip.interrupt_now(NMI)
        return int.from_bytes(self.memory[place : place + size], "little")


def blank(board: Board = B_G431B_ESC1) -> bytes:
    """The whole flash, erased."""
    return b"\xff" * board.flash_size
