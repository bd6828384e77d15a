"""Build backend of the package: maturin, behind cargo, which builds the library of the FMUs that maturin packs
into the wheel as a file."""

import os
import platform
import shutil
import subprocess
from pathlib import Path

import maturin
from maturin import (  # noqa: F401
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

LIBRARY = "libnarx_fmu.so"
ROOT = Path(__file__).parents[2]

# The sources that a registry has are those of this package alone: without the library of the FMUs, and with a lock file
# that names more than they use, which cargo refuses under --locked and else only shortens.
WHOLE = (ROOT / "python/fmu").exists()
if WHOLE:
    os.environ.setdefault("MATURIN_PEP517_ARGS", "--locked")


def build_library() -> None:
    """Builds the library and puts it beside the package's files; elsewhere than on Linux on x86-64 there is
    none."""
    if not WHOLE or (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        return
    command = ["cargo", "rustc", "--package", "narx-fmu", "--release", "--locked", "--", "-C", "strip=symbols"]
    subprocess.run(command, cwd=ROOT, check=True)
    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / LIBRARY
    # In a folder that is no package: it is no module of Python.
    binaries = ROOT / "python/narx/binaries"
    binaries.mkdir(exist_ok=True)
    shutil.copy(built, binaries / LIBRARY)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Builds a wheel."""
    build_library()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN201
    """Builds an editable wheel."""
    build_library()
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)
