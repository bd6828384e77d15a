"""Downloads from the drive: words with their places."""

from collections.abc import Callable

from narx.errors import NoAnswerError
from narx.link import Link
from narx.progress import counted

STALL = 5.0
"""Time without a new word after which a download has failed, s."""


def download(
    link: Link,
    what: str,
    first: int = 0,
    count: int = 0,
    progress: Callable[[int, int], None] | bool | None = None,
) -> bytes:
    """Returns the bytes of a download. progress: as of `progress.counted`. An exception of it, or Ctrl-C, aborts
    the download on the drive, too."""
    with counted(what, progress) as tell:
        return received(link, what, first, count, tell)


def received(link: Link, what: str, first: int, count: int, tell: Callable[[int, int], None] | None) -> bytes:
    """Returns the bytes of a download; `tell` is called with the number of words received and the total."""
    words: dict[int, bytes] = {}
    length: list[int] = []
    told = -1

    def done() -> bool:
        nonlocal told
        for offset, chunk in link.take_chunks():
            words[offset] = chunk
        state = link.master.download_progress()
        if tell is not None and state is not None and state[0] != told:
            told = state[0]
            tell(*state)
        end = link.master.poll_download()
        if end is not None:
            length.append(end)
            if tell is not None and told != end:
                tell(end, end)
        return bool(length)

    link.master.download(what, first, count)
    link.downloads = True
    try:
        link.wake()
        known = -1
        while not link.wait(done, STALL):
            if len(words) == known:
                raise NoAnswerError(f"nothing more came of the {what} within {STALL:g} s")
            known = len(words)
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
