"""Suggestions of similar names for a name that does not exist."""

from collections.abc import Iterable
from difflib import get_close_matches


def suggestion(wanted: object, names: Iterable[str]) -> str:
    """Returns `; did you mean "x"?` for the names that are most similar to `wanted`, or ""."""
    known = {name.casefold(): name for name in names}
    close = get_close_matches(str(wanted).casefold(), known)
    meant = '" or "'.join(known[name] for name in close)
    return f'; did you mean "{meant}"?' if meant else ""
