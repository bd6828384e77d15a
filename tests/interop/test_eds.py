"""python-canopen reads the EDS files of the TX-Driver, and decodes its PDOs with them."""

import math
import struct
from pathlib import Path

import canopen
import pytest

DOCS = Path(__file__).parents[2] / "docs"
MM = 2**27

# File, values of the PDO's objects in raw units, and the bytes of the PDO (PROTOCOL.md, section 10.3).
LAYOUTS = [
    ("eddycan-single.eds", {"Position 1": MM}, struct.pack("<i", MM)),
    ("eddycan-dual.eds", {"Position 1": MM, "Position 2": -2 * MM}, struct.pack("<ii", MM, -2 * MM)),
    ("eddycan-single-encoder.eds", {"Position 1": -1, "Encoder": -7}, struct.pack("<ih", -1, -7)),
    (
        "eddycan-dual-encoder.eds",
        {"Position 1": MM >> 8, "Position 2": -2, "Encoder": 513},
        bytes.fromhex("000008") + bytes.fromhex("feffff") + bytes.fromhex("0102"),
    ),
]


@pytest.mark.parametrize("name, expected, data", LAYOUTS)
def test_pdos_decode(name, expected, data):
    network = canopen.Network()
    node = network.add_node(2, str(DOCS / name))
    node.tpdo.read(from_od=True)
    # The identifiers are those of the example in section 3.2; only PDO3 answers remote frames.
    assert [node.tpdo[number].cob_id for number in (1, 2, 3)] == [0x182, 0x282, 0x382]
    assert [node.tpdo[number].rtr_allowed for number in (1, 2, 3)] == [False, False, True]
    for number in (1, 2, 3):
        pdo = node.tpdo[number]
        assert pdo.enabled
        network.notify(pdo.cob_id, bytearray(data), 1.0)
        assert {variable.name: variable.raw for variable in pdo.map} == expected


@pytest.mark.parametrize("name", [layout[0] for layout in LAYOUTS])
def test_objects(name):
    objects = canopen.import_od(str(DOCS / name), node_id=1)
    entries = [0x2000, 0x2001, 0x2002, 0x2003, 0x2004, 0x2005, 0x2006, 0x2007, 0x2008, 0x2009, 0x200A, 0x2100]
    assert [index for index in objects if 0x2000 <= index < 0x2200] == entries
    assert objects[0x2003].default == 0 and objects[0x2003].max == 65535
    assert objects["Comparator"][2].default == 2**29 and math.isclose(objects[0x2007][1].max, 2**30)
    assert objects[0x200A].access_type == "wo" and objects[0x2100].access_type == "ro"
    assert not objects[0x2100].writable and not objects[0x200A].readable


# Requests of a master and answers of the device. tests/eddycan/eds.rs checks the device with the same frames.
EXCHANGE = [
    ("2b0320000a000000", "6003200000000000"),
    ("2307200100000010", "6007200100000000"),
    ("2f0a200000000000", "600a200000000000"),
    ("4003200000000000", "4b0320000a000000"),
]


class Device(canopen.Network):
    """A bus with a node 1 that answers from the table."""

    def __init__(self):
        super().__init__()
        self.left = list(EXCHANGE)

    def send_message(self, can_id, data, remote=False):
        request, answer = self.left.pop(0)
        assert (can_id, bytes(data).hex()) == (0x601, request)
        self.notify(0x581, bytearray.fromhex(answer), 1.0)


def test_configures_by_sdo():
    network = Device()
    node = network.add_node(1, str(DOCS / "eddycan-single.eds"))
    node.sdo[0x2003].raw = 10
    node.sdo["Comparator"][1].raw = 2**28
    node.sdo[0x200A].raw = 0
    assert node.sdo[0x2003].raw == 10
    assert network.left == []
