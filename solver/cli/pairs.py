"""NAME=VALUE arguments of the command line, and the error for bad input."""

from collections.abc import Sequence

from ..scene import PARAMETERS

SETTABLE = (*PARAMETERS, "profile")  # by --set


class InputError(ValueError):
    """Bad input on the command line; the message is one line that names it and what is allowed."""


def settings(
    pairs: Sequence[str],
    option: str = "--set",
    form: str = "NAME=VALUE",
    of: str = f", NAME one of {', '.join(SETTABLE)}",
) -> dict[str, str]:
    """{'name': 'text'} of the NAME=VALUE arguments of an option; of: what is allowed as NAME. Raises InputError."""
    texts: dict[str, str] = {}
    for pair in pairs:
        name, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"{option} {pair}: give {form}{of}")
        if (name := name.strip()) in texts:
            raise InputError(f"{option} {pair}: {name} = {texts[name]} is given as well; leave one of them out")
        texts[name] = text.strip()
    return texts
