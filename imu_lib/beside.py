"""A file that appears whole or not at all: written beside its place under a name of its own, then
renamed.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole(path: str | os.PathLike[str], *, sync: bool = False) -> Iterator[Path]:
    """A path beside `path` that takes its name when the block ends well and vanishes otherwise.

    Parameters
    ----------
    path : path-like
        The file to be. A symbolic link is followed; what is there stays until the new file is
        whole.
    sync : bool
        Wait for the disk before the file takes its name, so that a power cut leaves one of the two.
    """
    final = Path(path).resolve() if Path(path).is_symlink() else Path(path)
    # with its suffix, by which writers choose the format
    handle, name = tempfile.mkstemp(dir=final.parent, prefix=f".{final.stem}-", suffix=final.suffix)
    os.close(handle)
    part = Path(name)
    try:
        yield part
        if sync:
            with open(part, "rb") as file:
                os.fsync(file.fileno())
        make_public(part)
        part.replace(final)
    finally:
        part.unlink(missing_ok=True)


def make_public(path: Path) -> None:
    """The rights that the user's files have: a temporary file is private, a result is not."""
    umask = os.umask(0)
    os.umask(umask)
    path.chmod(0o666 & ~umask)
