"""States, heartbeats and error messages of TX-Drivers, seen by python-canopen and python-can."""

import pytest
from tx_driver import (
    ANSWER,
    BOOT_UP,
    ERROR,
    GENERAL,
    HEARTBEAT,
    IS_OPERATIONAL,
    IS_PRE_OPERATIONAL,
    IS_STOPPED,
    NMT,
    PDO1,
    PDO2,
    PRE_OPERATIONAL,
    REQUEST,
    RESET,
    START,
    STATUS,
    STOP,
    aborted,
    later,
    sdo,
)
from virtual_drive import BROADCAST_SECONDS

HEARTBEAT_SECONDS = 2.0
"""Period of the heartbeat (section 3.4.1)."""
AUTOSTART, HEARTBEATS = 1, 4
"""Bits of the Can Config Register (table 7)."""
READ = sdo(0x40, 0x2002)


def state(master, node):
    """Returns the state of a node, concluded from its behaviour (section 3.4).

    In Pre-Operational the node answers an SDO request. In Operational it refuses the request and answers a
    SYNC. In Stopped it answers nothing.
    """
    since = master.now
    master.network.sync.transmit()
    master.send(REQUEST + node, READ)
    master.settle()
    answers, positions = master.received(ANSWER + node, since), master.received(PDO2 + node, since)
    if not positions and answers == [sdo(0x4F, 0x2002, 0, b"\x01")]:
        return PRE_OPERATIONAL
    if len(positions) == 1 and answers == [aborted(0x2002, 0, GENERAL)]:
        return START
    assert (positions, answers) == ([], [])
    return STOP


def test_every_command_from_every_state(master):
    master = master("2")
    node = master.node(2)
    assert state(master, 2) == PRE_OPERATIONAL, "the default after the boot-up"
    names = {START: "OPERATIONAL", STOP: "STOPPED", PRE_OPERATIONAL: "PRE-OPERATIONAL"}
    for before in names:
        for command in [*names, RESET]:
            node.nmt.state = names[before]
            if command == RESET:
                assert master.restart(2) == [BOOT_UP]
                assert state(master, 2) == PRE_OPERATIONAL
            else:
                node.nmt.state = names[command]
                assert state(master, 2) == command, f"{command:02X}h from {before:02X}h"


def test_a_command_goes_to_one_node_or_to_all(master):
    master = master("2,3,77")
    nodes = [2, 3, 77]
    for number in nodes:
        master.node(number)
    master.command(START, 3)
    assert [state(master, number) for number in nodes] == [PRE_OPERATIONAL, START, PRE_OPERATIONAL]
    master.command(STOP, 0)
    assert [state(master, number) for number in nodes] == [STOP] * 3
    master.command(PRE_OPERATIONAL, 77)
    assert [state(master, number) for number in nodes] == [STOP, STOP, PRE_OPERATIONAL]
    since = master.now
    master.network.nmt.send_command(RESET)
    for number in nodes:
        assert master.wait(HEARTBEAT + number, since) == [BOOT_UP]
    assert set(nodes) <= set(master.network.scanner.nodes)


def test_canopen_finds_the_nodes_of_a_bus(master):
    master = master("2,3:dual,127")
    # The search requests an entry that these nodes do not have. Each node that exists answers with an abort.
    master.network.scanner.search()
    master.settle()
    # The scanner lists the nodes in the order of their answers.
    assert sorted(master.network.scanner.nodes) == [2, 3, 127]


def test_what_is_no_command_changes_nothing(master):
    master = master("2")
    since = master.now
    for data in (b"", b"\x01", b"\x01\x02\x00", b"\x01\x02" + bytes(6), b"\x81\x02\x00", b"\x01\x03", b"\x01\x80", b"\x01\xff"):
        master.send(NMT, data)
    for length in range(9):
        master.send_remote(NMT, length)
    # A request of CANopen's node guarding.
    master.send_remote(HEARTBEAT + 2, 1)
    assert state(master, 2) == PRE_OPERATIONAL
    assert master.received(HEARTBEAT + 2, since) == [] and master.received(ERROR + 2, since) == []


def test_without_its_bit_there_is_no_heartbeat_but_the_boot_up(master):
    master = master("2")
    master.node(2)
    since = master.now
    assert master.restart(2) == [BOOT_UP]
    master.let_pass(2 * HEARTBEAT_SECONDS + 0.2)
    assert master.received(HEARTBEAT + 2, since) == [BOOT_UP]


def test_a_heartbeat_tells_the_state_every_two_seconds(master):
    master = master("2")
    node = master.node(2)
    node.sdo["Can Config Register"].raw = HEARTBEATS
    for name, state, byte in [
        ("PRE-OPERATIONAL", 127, IS_PRE_OPERATIONAL),
        ("OPERATIONAL", 5, IS_OPERATIONAL),
        ("STOPPED", 4, IS_STOPPED),
    ]:
        node.nmt.state = name
        told = []
        node.nmt.add_heartbeat_callback(told.append)
        assert node.nmt.wait_for_heartbeat(60) == name
        since = master.now
        assert master.wait(HEARTBEAT + 2, since, 3) == [byte] * 3
        assert set(told) == {state}
        places = [place for place, frame in enumerate(master.ears.frames) if frame.arbitration_id == HEARTBEAT + 2][-3:]
        for first, second in zip(places, places[1:]):
            words = len(master.received(STATUS, first, second))
            assert abs(words - HEARTBEAT_SECONDS / BROADCAST_SECONDS) <= 1, f"{words * BROADCAST_SECONDS:.2f} s"
    node.nmt.state = "PRE-OPERATIONAL"
    master.settle()
    node.sdo["Can Config Register"].raw = 0
    since = master.now
    master.let_pass(HEARTBEAT_SECONDS + 0.2)
    assert master.received(HEARTBEAT + 2, since) == []


def test_a_node_becomes_operational_by_itself(master):
    master = master("2")
    node = master.node(2)
    for register, told in [(AUTOSTART, [BOOT_UP]), (AUTOSTART | HEARTBEATS, [BOOT_UP, IS_OPERATIONAL])]:
        node.sdo["Can Config Register"].raw = register
        assert state(master, 2) == PRE_OPERATIONAL, "only after a boot-up"
        assert master.restart(2) == told
        assert state(master, 2) == START
        master.command(PRE_OPERATIONAL, 2)
        assert node.sdo["Can Config Register"].raw == register


def test_canopen_waits_for_the_boot_up(master):
    master = master("2")
    node = master.node(2)
    node.nmt.state = "STOPPED"
    later(node.nmt.send_command, RESET)
    node.nmt.wait_for_bootup(60)
    assert node.nmt.state == "PRE-OPERATIONAL"


def test_an_unknown_command_is_a_protocol_error_low_byte_first(master):
    master = master("2,3")
    node = master.node(2)
    master.node(3)
    # An unknown command is error 8200h (table 13). Command 130 is CANopen's reset communication; table 11
    # does not list it.
    since = master.now
    master.command(130, 2)
    assert master.received(ERROR + 2, since) == [b"\x00\x82"]
    assert master.received(ERROR + 3, since) == [], "it was not meant"
    assert state(master, 2) == PRE_OPERATIONAL and master.received(HEARTBEAT + 2, since) == []
    # An unknown command to all nodes causes no error message: otherwise one command would fill the bus.
    master.let_pass(1.0)
    since = master.now
    master.command(130, 0)
    assert master.received(ERROR + 2, since) + master.received(ERROR + 3, since) == []
    # An error message has two bytes, but python-canopen's consumer expects eight. Therefore python-can reads
    # it above.
    assert node.emcy.log == []


def test_errors_are_told_once_a_second_at_most(master):
    master = master("2")
    master.node(2)
    since = master.now
    for command in range(3, 0x80):
        master.send(NMT, bytes([command, 2]))
    master.settle()
    assert master.received(ERROR + 2, since) == [b"\x00\x82"]
    for command in (0x00, 0x82, 0xFF):
        master.let_pass(1.0)
        since = master.now
        master.command(command, 2)
        assert master.received(ERROR + 2, since) == [b"\x00\x82"], f"{command:02X}h"


@pytest.mark.parametrize("name", ["SLEEP", "STANDBY", "RESET COMMUNICATION"])
def test_states_that_only_canopen_has(master, name):
    master = master("2")
    node = master.node(2)
    since = master.now
    node.nmt.state = name
    assert state(master, 2) == PRE_OPERATIONAL
    assert master.received(ERROR + 2, since) == [b"\x00\x82"]


def test_a_neighbour_at_another_bitrate_makes_a_node_error_passive(master):
    master = master("2,3")
    node, neighbour = master.node(2), master.node(3)
    node.sdo["Update Time"].raw = 1
    neighbour.sdo["Bitrate Index"].raw = 2
    master.command(START, 2)
    since = master.now
    # The neighbour at 250 kbit/s sees an error in every frame, and sends error flags until it is error
    # passive.
    neighbour.nmt.send_command(RESET)
    # Error 8120h (table 13) is sent as soon as frames pass again. If the node went off the bus before the
    # message was sent, it sends the message again a second later.
    master.wait(ERROR + 2, since)
    master.let_pass(2.0)
    assert set(master.received(ERROR + 2, since)) == {b"\x20\x81"}
    assert len(master.received(ERROR + 2, since)) <= 3, "once a second"
    peace = master.now
    master.let_pass(1.5)
    assert master.received(ERROR + 2, peace) == []
    assert len(master.received(PDO1 + 2, master.now - 100)) > 50, "and it goes on"
    assert master.received(HEARTBEAT + 3, since) == []
