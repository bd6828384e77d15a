"""The description that the drive serves is well formed, valid by its schema, and agrees with the database."""

import os
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import cantools
import pytest
import xmlschema

SAMPLES = Path(os.environ["NARX_INTEROP"])
DOCUMENTS = Path(__file__).parents[2] / "docs"
TEXT = (SAMPLES / "description.xml").read_bytes()


@pytest.fixture(scope="module")
def schema():
    return xmlschema.XMLSchema(DOCUMENTS / "narx.xsd")


@pytest.fixture(scope="module")
def description():
    return ElementTree.fromstring(TEXT)


def test_it_is_of_its_schema(schema):
    schema.validate(TEXT.decode())


@pytest.mark.parametrize(
    "old, new",
    [
        (b'access="live"', b'access="sometimes"'),
        (b'<parameter number="5"', b'<parameter number="6"'),
        (b'category="21"', b'category="22"'),
        (b'scale="0.001"', b'scale="0"'),
        (b'id="0AAD5202"', b'id="0AAD520"'),
        (b'names="motor mode"', b'names="mood"'),
        (b"<causes>", b"<causes/><causes>"),
    ],
)
def test_the_schema_refuses_what_is_not(schema, old, new):
    assert old in TEXT
    with pytest.raises(xmlschema.XMLSchemaValidationError):
        schema.validate(TEXT.replace(old, new, 1).decode())


def test_scales_and_ranges_are_those_of_the_database(description):
    database = cantools.database.load_file(DOCUMENTS / "narx.dbc", strict=True)
    signals = {s.multiplexer_ids[0]: s for s in database.get_message_by_name("PARAMETER").signals if s.multiplexer_ids}
    parameters = description.findall("parameters/parameter")
    assert len(parameters) == len(signals) >= 122
    for parameter in parameters:
        signal = signals[int(parameter.get("number"))]
        assert float(parameter.get("scale")) == pytest.approx(float(signal.scale), rel=1e-12)
        assert float(parameter.get("min")) == pytest.approx(float(signal.minimum), rel=1e-12)
        assert float(parameter.get("max")) == pytest.approx(float(signal.maximum), rel=1e-12)
        assert (parameter.get("unit") or "").replace("°C", "degC") == (signal.unit or "")
        assert (parameter.get("type") == "int32") == signal.is_signed
        assert signal.comment == f"{parameter.get('name')}: {parameter.text}"


def test_fields_are_those_of_the_database(description):
    database = cantools.database.load_file(DOCUMENTS / "narx.dbc", strict=True)
    for message in description.findall("messages/message"):
        known = database.get_message_by_frame_id(int(message.get("id"), 16))
        plain = [field for field in message.findall("field") if field.get("refers") is None]
        named = {signal.start: signal for signal in known.signals if not signal.multiplexer_ids}
        for field in plain:
            bit = int(field.get("bit"))
            signal = named[bit // 8 * 8 + 7 - bit % 8]
            assert (signal.length, signal.is_signed) == (int(field.get("bits")), field.get("type") == "int")
            assert float(field.get("scale") or 1) == pytest.approx(float(signal.scale), rel=1e-12)


def test_scope_signals_that_are_broadcast_have_their_unit(description):
    units = {f.get("name"): f.get("unit") for f in description.findall("messages/message/field")}
    signals = description.findall("scope/signal")
    assert [int(signal.get("bit")) for signal in signals] == list(range(len(signals)))
    shared = [signal for signal in signals if signal.get("name") in units]
    assert len(shared) >= 8
    assert all(signal.get("unit") == units[signal.get("name")] for signal in shared)
