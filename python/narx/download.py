"""Downloads from the drive: words with their places."""

from collections.abc import Callable

from narx.errors import NoAnswerError
from narx.link import Link

STALL = 5.0
"""Time without a new word after which a download has failed, s."""


def download(
    link: Link,
    what: str,
    first: int = 0,
    count: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> bytes:
    """Returns the bytes of a download. An exception of `progress`, or Ctrl-C, aborts it on the drive, too."""
    words: dict[int, bytes] = {}
    length: list[int] = []
    told = -1

    def done() -> bool:
        nonlocal told
        for offset, chunk in link.take_chunks():
            words[offset] = chunk
        state = link.master.download_progress()
        if progress is not None and state is not None and state[0] != told:
            told = state[0]
            progress(*state)
        end = link.master.poll_download()
        if end is not None:
            length.append(end)
            if progress is not None and told != end:
                progress(end, end)
        return bool(length)

    link.master.download(what, first, count)
    link.downloads = True
    try:
        link.wake()
        received = -1
        while not link.wait(done, STALL):
            if len(words) == received:
                raise NoAnswerError(f"nothing more came of the {what} within {STALL:g} s")
            received = len(words)
    except BaseException:
        link.master.abort_download()
        link.wait(lambda: ended(link), 1.0)
        raise
    finally:
        link.downloads = False
    data = bytearray(2 * length[0])
    for offset, chunk in words.items():
        data[2 * offset : 2 * offset + len(chunk)] = chunk
    return bytes(data[: 2 * length[0]])


def ended(link: Link) -> bool:
    """Returns whether an aborted download is over."""
    from narx.errors import NarxError

    link.take_chunks()
    try:
        return link.master.poll_download() is not None
    except NarxError:
        return True
