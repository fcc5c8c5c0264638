"""The text in a file, however it is packed and encoded.

Recognised by the first bytes, whatever the file is called: gzip, xz, zip with one member, Parquet,
UTF-8 with or without a byte order mark, UTF-16 with one.
"""

import codecs
import gzip
import io
import lzma
import os
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

_UNPACKED = ((b"\x1f\x8b", gzip.decompress), (b"\xfd7zXZ\x00", lzma.decompress))
_MARKS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_KNOWN = (
    (b"\x89PNG", "a PNG picture"),
    (b"%PDF", "a PDF document"),
    (b"\x89HDF", "an HDF5 file"),
    (b"MATLAB", "a MATLAB file"),
    (b"\xd0\xcf\x11\xe0", "an old Excel workbook"),
    (b"SQLite", "an SQLite database"),
)


_MAGIC = (
    *(magic for table in (_UNPACKED, _MARKS, _KNOWN) for magic, _ in table),
    b"PK\x03\x04",
    b"ULog",
)
HEAD_BYTES = 1 << 22


@dataclass(frozen=True)
class Content:
    """What a file holds: UTF-8 text, or the bytes of a Parquet file or of a PX4 flight log."""

    name: str
    """The file's name, for messages."""
    source: bytes | Path
    """The content itself, or the file whose bytes are the content as they are."""
    kind: str
    """``"text"``, ``"parquet"`` or ``"ulog"``."""

    @property
    def data(self) -> bytes:
        """The whole content."""
        return self.source if isinstance(self.source, bytes) else self.source.read_bytes()

    @property
    def size(self) -> int:
        """The number of bytes."""
        if isinstance(self.source, bytes):
            return len(self.source)
        return self.source.stat().st_size

    def head(self, count: int = HEAD_BYTES) -> bytes:
        """The first bytes."""
        if isinstance(self.source, bytes):
            return self.source[:count]
        with self.source.open("rb") as file:
            return file.read(count)


def read(path: str | os.PathLike[str], *, may_be_empty: bool = False) -> Content:
    """The content of a file, unpacked; ``-`` is standard input.

    A file that needs no unpacking stays where it is, however large: its readers read it there.
    """
    if os.fspath(path) == "-":
        found = content("standard input", sys.stdin.buffer.read())
    elif not (path := Path(path)).is_file():
        found = content(path.name, path.read_bytes())
    else:
        found = _in_place(path) or content(path.name, path.read_bytes())
    if not may_be_empty and not found.head().strip() and not found.data.strip():
        raise ValueError(f"{found.name} is empty")
    return found


def _in_place(path: Path) -> Content | None:
    """The content of a file that is text or Parquet as it is; None for anything else."""
    with path.open("rb") as file:
        head = file.read(4096)
        if head.startswith(b"PAR1"):
            return Content(path.name, path, "parquet")
        if head.startswith(_MAGIC) or b"\x00" in head:
            return None
        decoder = codecs.getincrementaldecoder("utf-8")()
        block = head
        while block:
            if decoder.getstate()[0] or not block.isascii():
                try:
                    decoder.decode(block)
                except UnicodeDecodeError:
                    return None
            block = file.read(1 << 20)
    return None if decoder.getstate()[0] else Content(path.name, path, "text")


def content(name: str, data: bytes) -> Content:
    """What these bytes are, unpacked and decoded."""
    for magic, unpack in _UNPACKED:
        if data.startswith(magic):
            try:
                return content(name, unpack(data))
            except (OSError, EOFError, lzma.LZMAError) as error:
                raise ValueError(f"{name} cannot be unpacked: {error}") from None
    if data.startswith(b"PK\x03\x04"):
        return _from_zip(name, data)
    if data.startswith(b"PAR1"):
        return Content(name, data, "parquet")
    if data.startswith(b"ULog"):
        return Content(name, data, "ulog")
    return Content(name, _as_utf8(name, data), "text")


def _from_zip(name: str, data: bytes) -> Content:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = [m for m in archive.infolist() if not m.is_dir()]
            if any(m.filename.startswith(("xl/", "word/")) for m in members):
                raise ValueError(f"{name} is an office document: export it as CSV")
            if len(members) != 1:
                listed = ", ".join(m.filename for m in members[:5])
                raise ValueError(f"{name} holds {len(members)} files ({listed}): expected one")
            return content(f"{name}/{members[0].filename}", archive.read(members[0]))
    except zipfile.BadZipFile as error:
        raise ValueError(f"{name} cannot be unpacked: {error}") from None


def _as_utf8(name: str, data: bytes) -> bytes:
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            try:
                return data.decode(encoding).encode()
            except UnicodeDecodeError as error:
                raise ValueError(f"{name} is not {encoding} text: {error.reason}") from None
    for magic, what in _KNOWN:
        if data.startswith(magic):
            raise ValueError(f"{name} is {what}: expected text, Parquet, or either packed")
    if b"\x00" in data[:4096]:
        raise ValueError(
            f"{name} is not text (it begins with {data[:8]!r}): expected UTF-8, UTF-16 with a byte "
            "order mark, Parquet, gzip, xz or zip"
        )
    try:
        data.decode()
    except UnicodeDecodeError as error:
        row = data.count(b"\n", 0, error.start)
        raise ValueError(
            f"{name}, line {row + 1}: not UTF-8 text (byte {data[error.start]:#04x}); save it as "
            "UTF-8"
        ) from None
    return data
