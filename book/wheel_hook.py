"""Puts the chapters and the book's configuration into a wheel, so that `imu-lib book` works from
anywhere.
"""

from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PATTERNS = (
    "CHANGELOG.md",
    "book/*.*",
    "book/_static/*",
    "nbs/*.ipynb",
    "benchmarks/results/*.json",
    "data/*.csv",
    "data/*.json",
)


class BookInWheel(BuildHookInterface):
    def initialize(self, version, build_data):
        if version != "standard":  # an editable installation reads the checkout's own folders
            return
        root = Path(self.root)
        for path in sorted(path for pattern in PATTERNS for path in root.glob(pattern)):
            if path.is_file():
                build_data["force_include"][str(path)] = (
                    f"imu_lib/_book/{path.relative_to(root).as_posix()}"
                )
