"""Where data lies: beside the code in a source tree, in the wheel, in the user's cache, in
IMU_LIB_DATA.
"""

from __future__ import annotations

import os
from pathlib import Path

from imu_lib.errors import InputError

PACKAGE = Path(__file__).resolve().parents[1]
#: The short record that is committed as a file.
EXAMPLE = "gx3_25_one_minute.csv"


def shipped() -> Path:
    """The folder `data/` that comes with the code."""
    packaged = PACKAGE / "_book" / "data"
    return packaged if packaged.is_dir() else PACKAGE.parent / "data"


def example(name: str = EXAMPLE) -> Path:
    """Path of a committed file. InputError where there is none of that name."""
    path = shipped() / name
    if not path.is_file():
        raise InputError(
            f"{name} is no committed file; there are "
            f"{', '.join(sorted(p.name for p in shipped().glob('*.csv'))) or 'none'}."
        )
    return path


def cache() -> Path:
    """The folder for what is drawn or downloaded, made on first use: data/cache of a source tree,
    else the user's cache folder.
    """
    tree = PACKAGE.parent
    if (
        (tree / "pyproject.toml").is_file()
        and (tree / "data").is_dir()
        and os.access(tree / "data", os.W_OK)
    ):
        folder = tree / "data" / "cache"
    else:
        import pooch

        folder = Path(pooch.os_cache("imu_lib"))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def given() -> Path | None:
    """The folder that IMU_LIB_DATA names (relative: to the working folder, then to the source
    tree), None where it is not set or not there."""
    value = os.environ.get("IMU_LIB_DATA", "")
    if not value:
        return None
    return next((p for p in (Path(value), PACKAGE.parent / value) if p.is_dir()), None)
