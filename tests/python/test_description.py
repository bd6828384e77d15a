"""A drive with another description than this package's is shown by its own description."""

import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest
from peer import M2, Peer, peer

import narx
from narx import description


def changed(text: str, pattern: str, replacement: str) -> str:
    """Returns the text with one place changed."""
    fresh, count = re.subn(pattern, replacement, text)
    assert count == 1, (pattern, count)
    return fresh


def other() -> str:
    """Returns a description with other scales, one more parameter and one signal less."""
    text = narx.xml()
    text = changed(text, r'(name="Phase current limit" unit="A" type=")[a-z0-9]+(" scale=")0.001"', r'\1uint32\g<2>0.01"')
    text = changed(
        text,
        "</parameters>",
        '<parameter number="400" category="04" name="Coffee temperature" unit="°C" type="int32" scale="0.1" min="-5" max="98.5" '
        'factory="65.5" access="live">Of the cup.</parameter>\n</parameters>',
    )
    text = changed(text, r'(<field name="HV Voltage" bit="0" bits="16" type="int" unit=")V(" scale=")0.01"', r'\1mV\g<2>10"')
    text = changed(text, r'<field name="\+6V_MEAS"', '<field name="+5V_MEAS"')
    text = changed(text, r'<signal bit="\d+" name="Hall code" base="1"/>\n', "")
    return changed(text, r'(<signal bit="\d+" name="VoltagePhaseA" unit="V" base=")16"', r'\g<1>32"')


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for descriptions, with none of the earlier ones kept in memory."""
    monkeypatch.setattr(description, "folder", lambda: tmp_path)
    monkeypatch.setattr(description, "_known", dict(description._known))
    return tmp_path


@pytest.fixture
def drive(request: pytest.FixtureRequest) -> Iterator[tuple[narx.Drive, Peer]]:
    with peer(request.node.name, other()) as (device, bus), narx.Drive(bus) as drive:
        yield drive, device


def test_parameters_are_the_drives(drive: tuple[narx.Drive, Peer]) -> None:
    parameters, device = drive[0].parameters, drive[1]
    row = parameters.row("Phase current limit")
    assert (row.scale, row.type) == (0.01, "uint32")
    device.raw[269] = 450
    assert parameters[269] == 4.5
    parameters["phase current limit"] = 5.25
    assert device.raw[269] == 525
    row = parameters.row("coffee temperature")
    assert (row.number, row.unit, row.min, row.max, row.factory) == (400, "°C", -5.0, 98.5, 65.5)
    assert (row.category, row.description) == (narx.Parameters.rows[84].category, "Of the cup.")
    assert parameters["Coffee temperature"] == 65.5
    parameters[400] = -4.9
    assert device.raw[400] == -49 and parameters[400] == -4.9
    with pytest.raises(narx.ParameterError, match='parameter 400 "Coffee temperature": 98.6 °C is outside -5 to 98.5 °C'):
        parameters[400] = 98.6
    device.rows[400] |= {"max": "50"}
    with pytest.raises(narx.ParameterError, match='parameter 400 "Coffee temperature": out of range'):
        parameters[400] = 60
    assert len(parameters) == len(narx.Parameters.rows) + 1 and 400 in parameters and 400 not in narx.Parameters.rows
    assert "Coffee temperature" in parameters.to_dict()
    assert device.downloads == 1


def test_measurements_are_the_drives(drive: tuple[narx.Drive, Peer]) -> None:
    assert drive[0].parameters[400] == 65.5
    drive[1].measured[M2] = (48, 1000, 5012, 14_000)
    assert drive[0].wait_for(lambda: "HV Voltage" in drive[0].measurements)
    measured = drive[0].measurements
    assert (measured["HV Voltage"], measured.full("HV Voltage").unit) == (480.0, "mV")
    assert measured["+5V_MEAS"] == 5.012 and "+6V_MEAS" not in measured


def test_scope_signals_are_the_drives(drive: tuple[narx.Drive, Peer]) -> None:
    scope, device = drive[0].scope, drive[1]
    own = narx.Bench(narx.Motor.preset("bly172s-24v"), mode="hall").drive.scope.signals
    assert own.keys() - scope.signals.keys() == {"Hall code"} and scope.signals.keys() < own.keys()
    with pytest.raises(narx.SignalError, match='no scope signal "Hall code"'):
        scope.arm(["Hall code"])
    scope.arm(["VoltagePhaseA", "Duty"], samples=2)
    bits = {name: bit for name, (bit, _, _) in description.OWN.signals.items()}
    assert device.raw[22] == 1 << bits["VoltagePhaseA"] | 1 << bits["Duty"]
    device.raw |= {260: 3, 301: 4}
    device.record = [4096, 2048, 8192, 1024]
    seen = scope.download()
    assert list(seen) == ["time", "VoltagePhaseA", "Duty"]
    assert np.array_equal(seen["VoltagePhaseA"], [32.0, 64.0]) and np.array_equal(seen["Duty"], [50.0, 25.0])


def test_what_was_read_is_kept_by_build_number_and_crc(folder: Path) -> None:
    text = other()

    def downloads(name: str, text: str = text, build: int = 7) -> int:
        with peer(name, text, build=build) as (device, bus), narx.Drive(bus) as drive:
            assert drive.parameters[400] == 65.5
            return device.downloads

    assert downloads("first") == 1
    assert downloads("again") == 0
    assert downloads("another build", build=8) == 1
    assert downloads("other text", text.replace("Of the cup", "Of the pot")) == 1
    # An empty memory stands for another program on this computer.
    description._known.clear()
    assert downloads("later") == 0
    description._known.clear()
    for file in folder.iterdir():
        file.write_bytes(file.read_bytes().replace(b"Coffee", b"Toffee"))
    assert downloads("spoiled") == 1


def test_the_packages_own_drive_is_not_downloaded(folder: Path) -> None:
    with peer("own", narx.xml(), build=1) as (device, bus), narx.Drive(bus) as drive:
        assert drive.parameters["Motor pair poles"] == 4
        assert device.downloads == 0 and not list(folder.iterdir())


@pytest.mark.parametrize("text", [None, "no description", other().replace('scale="0.1"', 'scale="0.3"')])
def test_without_a_description_the_packages_tables_serve(text: str | None) -> None:
    with peer("without", None) as (device, bus), narx.Drive(bus) as drive:
        device.text = b"" if text is None else (text + "\n" * (len(text.encode()) % 2)).encode()
        device.check = crc32(device.text)
        device.raw[78] = 8
        with pytest.warns(narx.DescriptionWarning, match="the drive's description cannot be read .*: names, units"):
            assert drive.parameters["Motor pair poles"] == 8
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert drive.parameters["Motor pair poles"] == 8


def test_a_description_with_another_crc_is_not_believed() -> None:
    with peer("crc", other()) as (device, bus), narx.Drive(bus) as drive:
        device.check ^= 1
        with pytest.warns(narx.DescriptionWarning, match="CRC [0-9a-f]{8} of the download differs from [0-9a-f]{8}"):
            assert 400 not in drive.parameters


def test_a_clamped_set_point_is_a_warning() -> None:
    with peer("clamp", narx.xml(), build=1, speed_max=900) as (device, bus), narx.Drive(bus) as drive:
        with pytest.warns(narx.SpeedWarning, match="speed 1000 rpm: the drive uses 900 rpm"):
            drive.start(1000)
        device.raw[103] = 800
        with pytest.raises(narx.ParameterError, match='speed 850 rpm is above parameter 103 "Speed setpoint max'):
            drive.set_speed(850)
        with pytest.raises(narx.ParameterError, match='speed 499 rpm is below parameter 104 "Speed setpoint min'):
            drive.start(499)
