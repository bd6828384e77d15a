"""python-canopen reads and writes every entry of a TX-Driver's object dictionary.

A wrong access aborts with the code of its reason.
"""

import gc

import canopen
import pytest
from tx_driver import (
    ANSWER,
    BOOT_UP,
    COMMAND_UNKNOWN,
    GENERAL,
    HEARTBEAT,
    NO_INDEX,
    NO_SUBINDEX,
    PDO2,
    PRE_OPERATIONAL,
    RANGE_EXCEEDED,
    READ_ONLY,
    REQUEST,
    RESET,
    START,
    STOP,
    WRITE_ONLY,
    aborted,
    later,
    sdo,
)

# Entries of table 4, with the ranges of section 3.3.2 and the factory values of PROTOCOL.md: index, subindex,
# bytes, minimum, maximum, factory value.
ENTRIES = [
    (0x2000, 0, 1, 1, 127, 1),
    (0x2001, 0, 1, 0, 4, 3),
    (0x2002, 0, 1, 1, 127, 1),
    (0x2003, 0, 2, 0, 65535, 0),
    (0x2004, 0, 2, 0, 7, 0),
    (0x2005, 0, 2, 0, 6, 0),
    (0x2006, 1, 1, 0, 4, 0),
    (0x2006, 2, 1, 0, 4, 0),
    (0x2007, 1, 4, 0, 2**30, 2**29),
    (0x2007, 2, 4, 0, 2**30, 2**29),
    (0x2008, 0, 2, 1, 65535, 4096),
    (0x2009, 0, 2, 1, 65535, 100),
]
RESERVED = {0x2005: 1}
"""Bits that must stay 0 (table 8)."""
WRITE = 0x22
"""Write command of the specification, for every size (table 5)."""
SIZED = {1: 0x2F, 2: 0x2B, 3: 0x27, 4: 0x23}
"""Write commands of CANopen, by number of bytes."""
READ = 0x40
VALUE = {1: 0x4F, 2: 0x4B, 4: 0x43}
WRITTEN = 0x60

NODE = 2


def name(entry):
    return f"{entry[0]:04X}h.{entry[1]}"


def variable(node, index, subindex):
    """Returns the python-canopen object of an entry."""
    return node.sdo[index][subindex] if subindex else node.sdo[index]


def code_of(call, *arguments, **options):
    """Returns the abort code of a call."""
    with pytest.raises(canopen.SdoAbortedError) as aborted:
        call(*arguments, **options)
    return aborted.value.code


def samples(least, most, reserved):
    """Returns valid values: the ends of the range, values between, and a pattern of different bytes."""
    values = {least, least + 1, (least + most) // 2, most - 1, most, 0x01020304 & most}
    return sorted(value for value in values if least <= value <= most and not value & reserved)


def wrong(size, least, most, reserved):
    """Returns invalid values: just outside the range, the largest that fit, and with reserved bits."""
    values = {least - 1, most + 1, 256**size - 1, 1 << (8 * size - 1)}
    inside = {value for value in range(least, min(most, 16) + 1) if value & reserved}
    return sorted({value for value in values if 0 <= value < 256**size and not least <= value <= most} | inside)


@pytest.fixture
def no_stray_requests():
    """Delays the garbage collection to the end of the test.

    python-canopen sends one more request when it collects an aborted transfer. If the receiving thread
    collected it, that thread would wait for an answer that only the same thread can receive.
    """
    gc.disable()
    yield
    gc.collect()
    gc.enable()


@pytest.fixture
def bus(master):
    """A master with node 2 on its bus, and this node."""
    master = master(f"{NODE}")
    return master, master.node(NODE)


def test_the_eds_says_what_the_specification_does(bus):
    _, node = bus
    for index, subindex, size, least, most, factory in ENTRIES:
        entry = variable(node, index, subindex).od
        assert (len(entry), entry.min, entry.max, entry.default) == (8 * size, least, most, factory), hex(index)
        assert entry.access_type == "rw"


def test_every_entry_is_read_with_its_size_and_factory_value(bus):
    master, node = bus
    for index, subindex, size, _, _, factory in ENTRIES:
        # The fixture gives the node the number 2; the factory value is 1.
        expected = (NODE if index == 0x2000 else factory).to_bytes(size, "little")
        assert node.sdo.upload(index, subindex) == expected
        assert variable(node, index, subindex).raw == int.from_bytes(expected, "little")
        assert master.ask(NODE, sdo(READ, index, subindex)) == sdo(VALUE[size], index, subindex, expected)
    assert node.sdo[0x2100].raw != 0, "the release of a firmware"
    assert len(node.sdo.upload(0x2100, 0)) == 2


@pytest.mark.parametrize("entry", ENTRIES, ids=name)
def test_an_entry_takes_every_value_of_its_range_and_no_other(bus, entry):
    master, node = bus
    index, subindex, size, least, most, _ = entry
    reserved = RESERVED.get(index, 0)
    written = variable(node, index, subindex)
    for value in samples(least, most, reserved):
        written.raw = value
        assert written.raw == value
        for other in wrong(size, least, most, reserved):
            data = other.to_bytes(size, "little")
            assert code_of(node.sdo.download, index, subindex, data) == RANGE_EXCEEDED, other
            assert master.ask(NODE, sdo(WRITE, index, subindex, data)) == aborted(index, subindex, RANGE_EXCEEDED)
            assert written.raw == value, f"{other} changed something"


@pytest.mark.parametrize("entry", ENTRIES, ids=name)
def test_sized_commands_need_the_right_size_and_22h_needs_none(bus, entry):
    master, node = bus
    index, subindex, size, least, most, _ = entry
    first, second = least, min(most, 4)
    for length, command in SIZED.items():
        data = first.to_bytes(length, "little")
        if length == size:
            assert master.ask(NODE, sdo(command, index, subindex, data)) == sdo(WRITTEN, index, subindex)
            node.sdo.download(index, subindex, data)
        else:
            assert master.ask(NODE, sdo(command, index, subindex, data)) == aborted(index, subindex, GENERAL)
            assert code_of(node.sdo.download, index, subindex, data) == GENERAL
    assert variable(node, index, subindex).raw == first
    # The device takes the size of the entry, and ignores the bytes behind it.
    spare = second.to_bytes(size, "little").ljust(4, b"\xa5")
    assert master.ask(NODE, sdo(WRITE, index, subindex, spare)) == sdo(WRITTEN, index, subindex)
    assert variable(node, index, subindex).raw == second


def test_the_specifications_own_frames(bus):
    master, node = bus
    # A comparator value of 0.5 is 536870912 (section 3.3.2). Low bytes come first (section 3.3.1).
    node.sdo["Comparator"][1].raw = 0
    assert master.ask(NODE, bytes.fromhex("22 07 20 01 00 00 00 20")) == bytes.fromhex("60 07 20 01 00 00 00 00")
    assert node.sdo["Comparator"][1].raw == 536870912
    assert master.ask(NODE, bytes.fromhex("40 07 20 01 00 00 00 00")) == bytes.fromhex("43 07 20 01 00 00 00 20")
    node.sdo["Update Time"].raw = 0x1234
    assert master.ask(NODE, bytes.fromhex("40 03 20 00 00 00 00 00")) == bytes.fromhex("4b 03 20 00 34 12 00 00")


def test_channels_have_values_of_their_own(bus):
    _, node = bus
    for index, values in [(0x2006, (3, 1)), (0x2007, (0x0A0B0C0D, 0x01020304))]:
        for subindex, value in zip((1, 2), values):
            node.sdo[index][subindex].raw = value
        assert tuple(node.sdo[index][subindex].raw for subindex in (1, 2)) == values


def test_subindices(bus):
    master, node = bus
    for index in (0x2006, 0x2007):
        for subindex in (0, 3, 255):
            assert code_of(node.sdo.upload, index, subindex) == NO_SUBINDEX
            assert master.ask(NODE, sdo(WRITE, index, subindex)) == aborted(index, subindex, NO_SUBINDEX)
    # For an entry without subindices, every subindex reads and writes the entry itself (section 3.3.1).
    node.sdo["Update Time"].raw = 500
    for subindex in (1, 2, 255):
        assert node.sdo.upload(0x2003, subindex)[:2] == (500).to_bytes(2, "little")
        assert master.ask(NODE, sdo(WRITE, 0x2002, subindex, b"\x07")) == sdo(WRITTEN, 0x2002, subindex)
    assert node.sdo["Nr Of Nodes"].raw == 7


def test_indices_that_do_not_exist(bus):
    _, node = bus
    for index in (0x0000, 0x1000, 0x1017, 0x1800, 0x1FFF, 0x200B, 0x20FF, 0x2101, 0x2200, 0xFFFF):
        assert code_of(node.sdo.upload, index, 0) == NO_INDEX
        assert code_of(node.sdo.download, index, 0, b"\0") == NO_INDEX
    # The node therefore has no entries that describe PDOs: only the EDS file describes them.
    assert code_of(node.tpdo.read) == NO_INDEX


def test_what_can_only_be_read_or_only_be_written(bus):
    master, node = bus
    before = node.sdo[0x2100].raw
    assert code_of(node.sdo.download, 0x2100, 0, b"\x01\x00") == READ_ONLY
    assert master.ask(NODE, sdo(WRITE, 0x2100)) == aborted(0x2100, 0, READ_ONLY)
    assert node.sdo[0x2100].raw == before
    assert code_of(node.sdo.upload, 0x200A, 0) == WRITE_ONLY
    # A write is confirmed with any data and with none.
    node.sdo["Reset Encoder"].raw = 0
    for length in (1, 2, 3, 4):
        node.sdo.download(0x200A, 0, b"\xff" * length)
    assert master.ask(NODE, sdo(WRITE, 0x200A)) == sdo(WRITTEN, 0x200A)


def test_every_other_command_is_unknown(bus):
    master, node = bus
    known = {READ, WRITE, 0x80, *SIZED.values()}
    for command in sorted(set(range(256)) - known):
        request = sdo(command, 0x2002, 0, b"\x05")
        assert master.ask(NODE, request) == aborted(0x2002, 0, COMMAND_UNKNOWN), hex(command)
    assert node.sdo["Nr Of Nodes"].raw == 1


def test_transfers_of_canopen_that_eddycan_does_not_have(bus, no_stray_requests):
    _, node = bus
    assert code_of(node.sdo.download, 0x2003, 0, b"\x05\x00", force_segment=True) == COMMAND_UNKNOWN
    assert code_of(node.sdo.download, 0x2003, 0, b"\x05\x00\x00\x00\x00") == COMMAND_UNKNOWN
    assert code_of(node.sdo.open, 0x2003, 0, "rb", block_transfer=True) == COMMAND_UNKNOWN
    assert code_of(node.sdo.open, 0x2003, 0, "wb", size=2, block_transfer=True) == COMMAND_UNKNOWN
    assert node.sdo["Update Time"].raw == 0


def test_requests_without_a_pause_are_all_answered_in_order(bus):
    master, node = bus
    since = master.now
    values = range(1, 101)
    for value in values:
        master.send(REQUEST + NODE, sdo(WRITE, 0x2002, 0, bytes([value])))
        master.send(REQUEST + NODE, sdo(READ, 0x2002))
    expected = [answer for value in values for answer in (sdo(WRITTEN, 0x2002), sdo(VALUE[1], 0x2002, 0, bytes([value])))]
    assert master.wait(ANSWER + NODE, since, len(expected)) == expected
    assert node.sdo["Nr Of Nodes"].raw == 100


def test_what_is_no_request_has_no_answer(bus):
    master, node = bus
    since = master.now
    request = sdo(WRITE, 0x2002, 0, b"\x05")
    for length in range(8):
        master.send(REQUEST + NODE, request[:length])
    for length in range(9):
        master.send_remote(REQUEST + NODE, length)
    # An abort written by hand, one of python-canopen, requests to other nodes, and a frame with the
    # identifier of an answer.
    master.send(REQUEST + NODE, sdo(0x80, 0x2002))
    node.sdo.abort()
    master.send(REQUEST + NODE + 1, request)
    master.send(REQUEST, request)
    master.send(ANSWER + NODE, request)
    master.settle()
    assert [frame for frame in master.ears.frames[since:] if not frame.is_extended_id] == []
    assert node.sdo["Nr Of Nodes"].raw == 1


def test_the_state_decides_who_is_answered(bus):
    master, node = bus
    node.sdo["Nr Of Nodes"].raw = 5
    master.command(START, NODE)
    assert code_of(node.sdo.upload, 0x2002, 0) == GENERAL
    assert code_of(node.sdo.download, 0x2002, 0, b"\x06") == GENERAL
    master.command(STOP, NODE)
    since = master.now
    master.send(REQUEST + NODE, sdo(READ, 0x2002))
    master.send(REQUEST + NODE, sdo(WRITE, 0x2002, 0, b"\x06"))
    master.settle()
    assert master.received(ANSWER + NODE, since) == []
    node.sdo.RESPONSE_TIMEOUT = 0.3
    with pytest.raises(canopen.SdoCommunicationError):
        node.sdo.upload(0x2002, 0)
    node.sdo.RESPONSE_TIMEOUT = 30.0
    master.command(PRE_OPERATIONAL, NODE)
    assert node.sdo["Nr Of Nodes"].raw == 5


def test_a_restart_keeps_what_was_written(bus):
    master, node = bus
    written = {}
    for index, subindex, _, least, most, _ in ENTRIES[2:]:
        reserved = RESERVED.get(index, 0)
        # The value must not set "Operational after boot-up": in Operational the entries could not be read.
        written[index, subindex] = 6 if index == 0x2004 else samples(least, most, reserved)[-2]
        variable(node, index, subindex).raw = written[index, subindex]
    # A refused value is not stored.
    assert code_of(node.sdo.download, 0x2002, 0, b"\x80") == RANGE_EXCEEDED
    later(node.nmt.send_command, RESET)
    node.nmt.wait_for_bootup(30)
    assert node.nmt.state == "PRE-OPERATIONAL"
    assert {key: variable(node, *key).raw for key in written} == written


def test_a_node_id_acts_after_a_restart(bus):
    master, node = bus
    node.sdo["Node-ID"].raw = 9
    assert node.sdo["Node-ID"].raw == 9, "still answered under the old one"
    assert master.restart(NODE, 9) == [BOOT_UP]
    renamed = master.node(9)
    assert renamed.sdo["Node-ID"].raw == 9
    since = master.now
    master.send(REQUEST + NODE, sdo(READ, 0x2000))
    master.command(START, 0)
    master.network.sync.transmit()
    master.settle()
    assert master.received(ANSWER + NODE, since) == []
    assert (len(master.received(PDO2 + NODE, since)), len(master.received(PDO2 + 9, since))) == (0, 1)
    assert 9 in master.network.scanner.nodes


def test_a_bitrate_acts_after_a_restart(bus):
    master, node = bus
    node.sdo["Bitrate Index"].raw = 2
    assert node.sdo["Bitrate Index"].raw == 2
    since = master.now
    node.nmt.send_command(RESET)
    # At first the node destroys the frames of all others.
    master.let_pass(1.0)
    master.send(REQUEST + NODE, sdo(READ, 0x2001))
    master.settle()
    # At 250 kbit/s the node can neither receive nor send frames; the drive goes on.
    assert master.received(HEARTBEAT + NODE, since) == []
    assert master.received(ANSWER + NODE, since) == []
