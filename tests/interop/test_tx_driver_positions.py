"""Positions of TX-Drivers: PDOs of each layout, decoded by python-canopen with the EDS, and their times."""

import pytest
from tx_driver import PATIENCE, PDO1, PDO2, PDO3, PRE_OPERATIONAL, START, STATUS, STOP, SYNC, later
from virtual_drive import BROADCAST_SECONDS

NODE = 2
MM = 2**27
"""Raw value of 1 mm in a position of 4 bytes. In a position of 3 bytes it is 2^19 (section 3.1)."""
ENCODER = 2
"""Bit of the Can Config Register: PDOs carry the encoder (table 7)."""
BITRATE = 500_000


def signed(data):
    return int.from_bytes(data, "little", signed=True)


# By the name of the EDS: the driver on the command line, and the objects of figures 2 to 5. Of each object:
# name, first byte, byte behind the last, raw value of 1 mm.
LAYOUTS = {
    "single": ("2", [("Position 1", 0, 4, MM)]),
    "dual": ("2:dual", [("Position 1", 0, 4, MM), ("Position 2", 4, 8, MM)]),
    "single-encoder": ("2", [("Position 1", 0, 4, MM), ("Encoder", 4, 6, None)]),
    "dual-encoder": ("2:dual", [("Position 1", 0, 3, MM >> 8), ("Position 2", 3, 6, MM >> 8), ("Encoder", 6, 8, None)]),
}


@pytest.fixture(params=LAYOUTS)
def operational(request, master):
    """A node of each layout in Operational: master, node and layout."""
    return begin(master, request.param)


def begin(master, name, speed="10", registers=()):
    tx_driver, fields = LAYOUTS[name]
    master = master(tx_driver, speed)
    node = master.node(NODE, name)
    node.sdo["Can Config Register"].raw = ENCODER if name.endswith("encoder") else 0
    for register, value in registers:
        node.sdo[register].raw = value
    master.command(START, NODE)
    return master, node, fields


def by_the_figures(data, fields):
    assert len(data) == fields[-1][2]
    return {name: signed(data[first:end]) for name, first, end, _ in fields}


def decoded(pdo):
    return {variable.name: variable.raw for variable in pdo.map}


def read(master, node, number, ask):
    """Triggers a PDO, and returns its bytes and the values that python-canopen decodes."""
    pdo, seen, since = node.tpdo[number], [], master.now
    pdo.add_callback(lambda pdo: seen.append(decoded(pdo)))
    later(ask)
    assert pdo.wait_for_reception(PATIENCE) is not None
    return master.wait(pdo.cob_id, since)[0], seen[0]


def test_all_three_pdos_carry_the_positions_of_the_layout(operational):
    master, node, fields = operational
    length = fields[-1][2]
    asked = [
        (2, lambda: master.network.sync.transmit()),
        (3, lambda: master.send_remote(PDO3 + NODE, length)),
    ]
    values = []
    for number, ask in asked:
        data, value = read(master, node, number, ask)
        assert value == by_the_figures(data, fields)
        values.append(value)
    master.command(PRE_OPERATIONAL, NODE)
    node.sdo["Update Time"].raw = 10
    data, value = read(master, node, 1, lambda: node.nmt.send_command(START))
    values.append(value)
    for name, _, _, per_mm in fields:
        shown = [value[name] for value in values]
        if name == "Encoder":
            assert shown == [0, 0, 0], "the shaft stands"
        else:
            # The shaft is 1 mm away and slightly out of round. It stands, so the three readings differ only
            # by noise.
            assert all(abs(raw / per_mm - 1.0) < 0.05 for raw in shown), shown
            assert max(shown) - min(shown) < 0.002 * per_mm, shown


def test_a_sync_asks_all_nodes_and_must_be_empty(master):
    master = master("2,3:dual,4")
    nodes = [master.node(2), master.node(3, "dual"), master.node(4)]
    master.command(START, 0)
    master.command(STOP, 4)
    since = master.now
    for length in range(1, 9):
        master.send(SYNC, bytes(length))
    for length in range(9):
        master.send_remote(SYNC, length)
    master.settle()
    assert [master.received(PDO2 + node.id, since) for node in nodes] == [[], [], []]
    master.network.sync.transmit()
    master.settle()
    assert [[len(data) for data in master.received(PDO2 + node.id, since)] for node in nodes] == [[4], [8], []]


def test_only_a_remote_frame_of_the_exact_length_is_answered(operational):
    master, _, fields = operational
    length = fields[-1][2]
    for dlc in range(9):
        since = master.now
        master.send_remote(PDO3 + NODE, dlc)
        master.settle()
        assert [len(data) for data in master.received(PDO3 + NODE, since)] == ([length] if dlc == length else []), dlc
    # Data frames with the identifier trigger nothing; remote frames for other PDOs or nodes neither.
    since = master.now
    master.send(PDO3 + NODE, bytes(length))
    master.send(PDO3 + NODE, b"")
    for identifier in (PDO1 + NODE, PDO2 + NODE, PDO3 + NODE + 1, PDO3):
        master.send_remote(identifier, length)
    master.settle()
    assert [frame for frame in master.ears.frames[since:] if not frame.is_extended_id] == []


def test_nothing_comes_but_in_operational(master):
    master, node, _ = begin(master, "single", registers=[("Update Time", 1)])
    for command in (PRE_OPERATIONAL, STOP):
        master.command(command, NODE)
        since = master.now
        master.network.sync.transmit()
        master.send_remote(PDO3 + NODE, 4)
        master.settle()
        master.let_pass(0.1)
        assert [frame for frame in master.ears.frames[since:] if not frame.is_extended_id] == []
        master.command(START, NODE)
        assert len(master.received(PDO1 + NODE, since)) > 1


def count(master, identifier, words):
    """Counts the frames with an identifier during `words` periods of the status word."""
    since = master.now
    master.wait(STATUS, since, words + 1)
    places = [since + place for place, frame in enumerate(master.ears.frames[since:]) if frame.arbitration_id == STATUS]
    return len(master.received(identifier, places[0], places[words]))


@pytest.mark.parametrize("milliseconds, words", [(1, 10), (7, 40), (50, 40), (1000, 100)])
def test_the_update_time_is_the_period_of_pdo1(master, milliseconds, words):
    master, _, _ = begin(master, "single", registers=[("Update Time", milliseconds)])
    expected = words * BROADCAST_SECONDS / (milliseconds / 1000)
    assert abs(count(master, PDO1 + NODE, words) - expected) <= 1


def test_an_update_time_of_0_sends_no_pdo1(master):
    master, _, _ = begin(master, "single")
    assert count(master, PDO1 + NODE, 20) == 0


def half_of_the_bus(nodes, length):
    """Returns the period of a node's PDO1 at update time 65535, in seconds.

    All nodes together take half of the bits of the bus, each frame at its greatest length (PROTOCOL.md,
    10.1).
    """
    bits = 47 + 8 * length + (33 + 8 * length) // 4
    return nodes * bits / (0.5 * BITRATE)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("nodes, words", [(1, 4), (10, 20), (127, 100)])
def test_half_of_the_bus_is_shared_by_the_number_of_nodes(master, layout, nodes, words):
    master, _, fields = begin(master, layout, registers=[("Nr Of Nodes", nodes), ("Update Time", 65535)])
    expected = words * BROADCAST_SECONDS / half_of_the_bus(nodes, fields[-1][2])
    # Frames of the drive sometimes delay a PDO by less than a period.
    assert abs(count(master, PDO1 + NODE, words) - expected) <= 2
