"""The content of a file, and its text; what is no measurement is named."""

import re
from os import PathLike
from pathlib import Path
from typing import TextIO

from ..surfaces import DataError

Source = str | bytes | PathLike[str] | TextIO
MOST_BYTES = 20_000_000  # of a file: some 500,000 rows of two numbers
LONGEST_NAME = 120  # characters of a path in a message
OTHERS = {  # what a file is that begins so, and holds no measurement
    "a picture, whose heights are lost; export them as CSV": (b"\x89PNG\r\n", b"\xff\xd8\xff", b"GIF8", b"RIFF"),
    "a PDF; export its numbers as CSV": (b"%PDF-",),
    "an archive; unpack it": (b"\x1f\x8b", b"7z\xbc\xaf", b"Rar!", b"BZh", b"\xfd7zXZ"),
    "a program; choose a file of a measurement": (b"\x7fELF", b"MZ\x90", b"\xcf\xfa\xed\xfe"),
}


def content_of(source: Source) -> str | bytes:
    """The content of a file, a path, or the content itself; raises DataError, also for more than MOST_BYTES."""
    if isinstance(source, PathLike) or (isinstance(source, str) and not re.search("[\r\n]", source)):
        content = _content(source)
    else:
        content = source if isinstance(source, (str, bytes)) else source.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise DataError(f"more than {MOST_BYTES / 1e6:g} MB; thin it out, fewer points are enough")
    if isinstance(content, bytes):
        for what, beginnings in OTHERS.items():
            if content.startswith(beginnings):
                raise DataError(f"this is {what}")
        if not content.strip(b"\0"):
            raise DataError("this is an empty file; choose another one")
    return content


def text_of(content: str | bytes) -> str:
    """The content of a file as text, with plain line breaks; raises DataError where it is not text."""
    if not isinstance(content, str):
        raw = bytes(content)
        try:
            content = raw.decode("utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8")
        except UnicodeDecodeError:  # of an older instrument: in Latin-1 every byte is a character
            content = raw.decode("latin-1")
    content = content.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    if binary := re.search("[\0\ufffd]", content):
        raise DataError("not a text file; save it as CSV in UTF-8", content.count("\n", 0, binary.start()) + 1)
    return content


def _content(path):
    """The bytes of a file, at most one more than allowed."""
    shown = repr(str(path)[:LONGEST_NAME])
    try:
        if Path(path).is_file():  # a pipe or a device may never end
            with open(path, "rb") as file:
                return file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as failure:  # ValueError: a null character in the name
        reason = getattr(failure, "strerror", None) or failure
        raise DataError(f"{shown}: {reason}; name a CSV file that can be read") from None
    raise DataError(f"{shown} is not a file; name a CSV file, or give its lines")
