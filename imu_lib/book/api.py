"""The page of functions, made from the docstrings: a section for each room of the package."""

from pathlib import Path

#: Section -> modules, in the order of a reader's work.
SECTIONS = {
    "Records and models": ("imu_lib.record", "imu_lib.readers", "imu_lib.model", "imu_lib.drive"),
    "Noise processes": ("imu_lib.processes",),
    "Estimators": (
        "imu_lib.spectrum",
        "imu_lib.allan",
        "imu_lib.wavelet",
        "imu_lib.autocorrelation",
        "imu_lib.autoregressive",
        "imu_lib.likelihood",
        "imu_lib.gmwm",
        "imu_lib.characterise",
    ),
    "Calibration": ("imu_lib.calibration",),
    "Navigation": (
        "imu_lib.navigation.strapdown",
        "imu_lib.navigation.filter",
        "imu_lib.navigation.models",
        "imu_lib.navigation.outages",
        "imu_lib.navigation.simulation",
        "imu_lib.navigation.statistics",
    ),
    "Gap": ("imu_lib.gap", "imu_lib.health", "imu_lib.compare"),
    "Output": ("imu_lib.export", "imu_lib.plots", "imu_lib.tables", "imu_lib.verdict"),
}
HEAD = """# Reference of the functions

Made from the docstrings. Arrays are NumPy arrays, quantities SI; conventions are in {doc}`notation`. What is not listed
here is internal and may change.
"""


def page() -> str:
    """The text of the page."""
    lines = [HEAD]
    for section, modules in SECTIONS.items():
        lines += [f"## {section}", ""]
        for module in modules:
            lines += [f"### {module.removeprefix('imu_lib.')}", "", "```{eval-rst}"]
            lines += [f".. automodule:: {module}", "   :members:", "   :member-order: bysource"]
            lines += ["```", ""]
    return "\n".join(lines)


def write(root: Path) -> None:
    (root / "book/api.md").write_text(page(), encoding="utf-8")


def modules() -> list[str]:
    return [module for group in SECTIONS.values() for module in group]
