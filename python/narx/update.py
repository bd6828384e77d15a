"""Programming the drive: an image on its way to the bootloader."""

from collections.abc import Callable

from narx.errors import NarxError
from narx.link import Link

LOOK = 0.5
"""Longest time between two checks of the progress and of Ctrl-C, s."""


def update(link: Link, image: bytes, progress: Callable[[str, int, int], None] | None = None) -> None:
    """Sends an image and waits until it runs. An exception of `progress`, or Ctrl-C, aborts it on the drive,
    too."""
    told: tuple[str, int, int] | None = None

    def done() -> bool:
        nonlocal told
        state = link.master.update_progress()
        if progress is not None and state is not None and state != told:
            told = state
            progress(*state)
        is_over = link.master.poll_update()
        if is_over and progress is not None and told is not None:
            # A drive that has just restarted reports 0 bytes, so the last call reports all of them.
            stage, _, total = told
            progress(stage, total, total)
        return is_over

    link.master.update(image)
    link.wake()
    try:
        # The master has a time-out for each stage.
        while not link.wait(done, LOOK):
            pass
    except BaseException:
        # Nothing to abort if the drive itself has ended the update.
        if link.master.update_progress() is not None:
            link.master.abort_update()
            link.wait(lambda: ended(link), 1.0)
        raise


def ended(link: Link) -> bool:
    """Returns whether an aborted update is over."""
    try:
        return link.master.poll_update()
    except NarxError:
        return True
