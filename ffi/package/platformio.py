"""Links the library for the board's processor, or without a board for this machine; PlatformIO runs this from
library.json. `custom_narx = small` in platformio.ini takes the small one."""

import platform
from pathlib import Path

Import("env", "projenv")  # noqa: F821

TARGETS = {
    "thumbv6m-none-eabi": ("cortex-m0", "cortex-m0plus", "cortex-m1", "cortex-m23"),
    "thumbv7m-none-eabi": ("cortex-m3",),
    "thumbv7em-none-eabihf": ("cortex-m4", "cortex-m7"),
    "thumbv8m.main-none-eabihf": ("cortex-m33", "cortex-m35p", "cortex-m55", "cortex-m85"),
    "x86_64-unknown-linux-gnu": ("x86_64",),
}

has_board = "BOARD" in env  # noqa: F821
processor = env.BoardConfig().get("build.cpu", "") if has_board else platform.machine()  # noqa: F821
target = next((target for target, processors in TARGETS.items() if processor in processors), None)
if target is None:
    raise SystemExit(f"narx: no library for the processor {processor!r}; there are {TARGETS}")
small = has_board and env.GetProjectOption("custom_narx", "") == "small"  # noqa: F821
# This file is in share/narx.
root = Path(Dir(".").srcnode().abspath).parents[1]  # noqa: F821
library = root / "lib" / target / ("libnarx-small.a" if small else "libnarx.a")
projenv.Append(LINKFLAGS=["-Wl,--gc-sections"], LIBS=[File(str(library))])  # noqa: F821
if not has_board:
    projenv.Append(LIBS=["pthread", "dl", "m"])  # noqa: F821
