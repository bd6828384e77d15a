"""FMUs of a bench: archives for simulation tools, by FMI 2.0 and 3.0 (Functional Mock-up Interface),
co-simulation, for Linux on x86-64."""

from __future__ import annotations

import importlib.resources
import math
from os import PathLike
from typing import Literal, TypeAlias
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from narx import _core, given
from narx.errors import MissingError, ParameterError
from narx.signals import DESCRIPTIONS

Variable: TypeAlias = tuple[int, str, str, str, str, float]
"""Value reference, name, unit, causality, kind and first value."""

LIBRARY = "binaries/libnarx_fmu.so"
NAME = "narx_drive"
INPUTS = {
    "run": "true requests Drive, false Standby",
    "speed_request": "requested mechanical speed, to a whole rpm; negative is Reverse",
    "load_torque": "constant torque that opposes the motion",
    "machine_torque": "torque of a machine on the shaft, against Forward whichever way it turns; a negative one drives Forward",
    "supply_voltage": "open-circuit voltage of the supply",
}
"""Description of each input."""
UNITS: dict[str, dict[str, str]] = {
    "s": {"s": "1"}, "rpm": {"rad": "1", "s": "-1", "factor": repr(math.tau / 60)}, "A": {"A": "1"},
    "V": {"kg": "1", "m": "2", "s": "-3", "A": "-1"}, "N m": {"kg": "1", "m": "2", "s": "-2"}, "J": {"kg": "1", "m": "2", "s": "-2"},
    "deg": {"rad": "1", "factor": repr(math.tau / 360)}, "rad": {"rad": "1"}, "degC": {"K": "1", "offset": "273.15"},
}  # fmt: skip
"""Base units of each unit."""


def save(bench: _core.Bench, path: str | PathLike[str], version: Literal[2, 3], period: float) -> None:
    """Writes the FMU of a bench at power-up. period: of a control tick, s."""
    if version not in (2, 3):
        raise ParameterError(f"version {version!r}: must be 2 or 3")
    library = importlib.resources.files("narx") / LIBRARY
    if not library.is_file():
        raise MissingError("this package has no library for FMUs: it is built on Linux on x86-64, by pip install ./python")
    file, token, variables = bench.fmu()
    described = (description_2 if version == 2 else description_3)(variables, token, period)
    ElementTree.indent(described)
    platform = "linux64" if version == 2 else "x86_64-linux"
    parts = {
        "modelDescription.xml": ElementTree.tostring(described, "UTF-8", xml_declaration=True),
        f"binaries/{platform}/{NAME}.so": library.read_bytes(),
        "resources/drive.json": file.encode(),
    }
    with ZipFile(given.path(path), "w", ZIP_DEFLATED) as archive:
        for name, data in parts.items():
            # Without the time of writing: the same bench gives the same bytes.
            archive.writestr(ZipInfo(name, (1980, 1, 1, 0, 0, 0)), data, ZIP_DEFLATED)


def description_2(variables: list[Variable], token: str, period: float) -> Element:
    """Returns the model description of FMI 2.0."""
    root = head("2.0", "guid", token)
    SubElement(root, "CoSimulation", modelIdentifier=NAME, canHandleVariableCommunicationStepSize="true", canGetAndSetFMUstate="true")
    units(root)
    SubElement(root, "DefaultExperiment", startTime="0", stopTime="1", stepSize=repr(period))
    listed, structure = SubElement(root, "ModelVariables"), SubElement(root, "ModelStructure")
    outputs, unknowns = SubElement(structure, "Outputs"), SubElement(structure, "InitialUnknowns")
    for index, variable in enumerate(variables, 1):
        reference, name, unit, causality, kind, _ = variable
        scalar = SubElement(listed, "ScalarVariable", {"name": name, "valueReference": str(reference)} | attributes(variable))
        SubElement(scalar, kind.capitalize(), ({"unit": unit} if unit else {}) | start(variable))
        if causality == "output":
            SubElement(outputs, "Unknown", index=str(index))
            SubElement(unknowns, "Unknown", index=str(index))
    return root


def description_3(variables: list[Variable], token: str, period: float) -> Element:
    """Returns the model description of FMI 3.0."""
    root = head("3.0", "instantiationToken", token)
    SubElement(
        root, "CoSimulation", modelIdentifier=NAME, canHandleVariableCommunicationStepSize="true", canGetAndSetFMUState="true",
        fixedInternalStepSize=repr(period),
    )  # fmt: skip
    units(root)
    SubElement(root, "DefaultExperiment", startTime="0", stopTime="1", stepSize=repr(period))
    listed, structure = SubElement(root, "ModelVariables"), SubElement(root, "ModelStructure")
    types = {"real": "Float64", "integer": "Int32", "boolean": "Boolean"}
    outputs, unknowns = [], []
    for variable in variables:
        reference, name, unit, causality, kind, _ = variable
        about = {"name": name, "valueReference": str(reference)} | attributes(variable) | ({"unit": unit} if unit else {})
        SubElement(listed, types[kind], about | start(variable))
        if causality == "output":
            outputs.append(Element("Output", valueReference=str(reference)))
            unknowns.append(Element("InitialUnknown", valueReference=str(reference)))
    structure.extend([*outputs, *unknowns])
    return root


def head(version: str, token_name: str, token: str) -> Element:
    """Returns the root of a model description."""
    about = "BLDC drive in six-step commutation, with its motor, load and supply"
    generator = f"narx {_core.__version__}"
    return Element(
        "fmiModelDescription", {"fmiVersion": version, "modelName": NAME, token_name: token}, description=about, generationTool=generator
    )


def units(root: Element) -> None:
    """Appends the definitions of the units."""
    definitions = SubElement(root, "UnitDefinitions")
    for name, base in UNITS.items():
        SubElement(SubElement(definitions, "Unit", name=name), "BaseUnit", base)


def attributes(variable: Variable) -> dict[str, str]:
    """Returns description, causality and variability of a variable."""
    _, name, _, causality, kind, _ = variable
    about = "time" if causality == "independent" else INPUTS.get(name) or DESCRIPTIONS[name]
    variability = "continuous" if kind == "real" else "discrete"
    return {"description": about, "causality": causality, "variability": variability}


def start(variable: Variable) -> dict[str, str]:
    """Returns the first value of an input."""
    *_, causality, kind, first = variable
    if causality != "input":
        return {}
    return {"start": str(bool(first)).lower() if kind == "boolean" else repr(first)}
