"""Names that were perhaps meant."""

from collections.abc import Iterable
from difflib import get_close_matches


def suggestion(wanted: object, names: Iterable[str]) -> str:
    """`; did you mean "x"?` for the names that look most like `wanted`, or nothing."""
    known = {name.casefold(): name for name in names}
    close = get_close_matches(str(wanted).casefold(), known)
    meant = '" or "'.join(known[name] for name in close)
    return f'; did you mean "{meant}"?' if meant else ""
