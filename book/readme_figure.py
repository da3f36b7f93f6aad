"""Draws the figure of the README with the README's own example: `python book/readme_figure.py`."""

import re
from pathlib import Path

from imu_lib import plots

ROOT = Path(__file__).resolve().parents[1]

plots.headless()
code = re.search(
    r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL
)[1]
*lines, last = code.strip().splitlines()
names = {}
exec("\n".join([*lines, f"axes = {last}"]), names)
plots.save(names["axes"], ROOT / "book/_static/readme.png")
