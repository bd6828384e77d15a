"""Programming the drive."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress

from narx.cli.app import JSON, app, connected, err, examples, out


@app.command(epilog=examples("narx update drive-1.4.0.narximg", "narx -i slcan -c /dev/ttyACM0 update drive-1.4.0.narximg"))
def update(
    image: Annotated[Path, typer.Argument(help="A signed image, .narximg.")],
    as_json: Annotated[bool, JSON] = False,
) -> None:
    """Programs the drive with a signed image, restarts it, and confirms that the image runs."""
    with connected(bootloader=True) as drive, Progress(console=err) as bar:
        task = bar.add_task("asking", total=None)
        drive.update(
            image, lambda stage, done, total: bar.update(task, description=stage, completed=done, total=total)
        )
        info = drive.info
    if as_json:
        print(json.dumps({"file": str(image), "software": info.software, "build": info.build_number}))
        return
    out.print(f"software {info.software}, build {info.build_number} runs", highlight=False)
