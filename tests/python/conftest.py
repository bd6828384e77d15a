"""Fixtures that the tests of the Python package share."""

from pathlib import Path

import pytest

import narx

VECTORS = sorted((Path(__file__).parents[1] / "vectors").glob("*.narxrec"))


@pytest.fixture(params=VECTORS, ids=lambda path: path.stem)
def vector(request: pytest.FixtureRequest) -> Path:
    """Each conformance vector in turn."""
    path: Path = request.param
    return path


@pytest.fixture
def motor() -> narx.Motor:
    """A motor that runs at every supply voltage."""
    return narx.Motor.preset("ec45-flat-50w-18v")


@pytest.fixture
def bench(motor: narx.Motor) -> narx.Bench:
    """A drive with hall sensors in Initialization."""
    return narx.Bench(motor, supply_voltage=18.0, mode="hall")
