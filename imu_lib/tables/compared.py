"""A table or figure of a paper and ours: how far apart, said in the chapter and kept in its
outputs.

The index of what is reproduced is made from what the chapters' cells store, never by hand.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from imu_lib.tables.coefficients import values_of
from imu_lib.units import datasheet

#: MIME type under which a comparison is stored among the outputs of a cell.
MIME = "application/vnd.imu-lib.comparison+json"
TOLERANCE = 0.1


class Comparison:
    """Printed values and ours of one item; notebooks keep it as JSON beside the sentence.

    item : as the index calls it, "2013 Table 4"; ours, printed : name -> number, of the same names;
    remark : what to know about it, where the numbers do not say it
    """

    def __init__(self, item: str, ours: Mapping, printed: Mapping, remark: str = ""):
        self.item, self.remark = item, remark
        ours, printed = ({_name(k): v for k, v in dict(t).items()} for t in (ours, printed))
        self.pairs = {
            name: (float(ours[name]), float(value))
            for name, value in printed.items()
            if name in ours and ours[name] is not None and math.isfinite(float(ours[name]))
        }
        self.missing = [name for name in printed if name not in self.pairs]

    @property
    def ratios(self) -> dict[str, float]:
        """Ours over the printed value, where that is not zero."""
        return {n: o / p for n, (o, p) in self.pairs.items() if p}

    def to_json(self) -> dict:
        ratios = sorted(self.ratios.items(), key=lambda item: abs(math.log(abs(item[1]) or 1e-9)))
        middle = sorted(self.ratios.values())[len(ratios) // 2] if ratios else None
        worst = ratios[-1] if ratios else None
        return {
            "item": self.item,
            "values": len(self.pairs) + len(self.missing),
            "within": sum(abs(r - 1.0) <= TOLERANCE for _, r in ratios),
            "median_ratio": None if middle is None else float(f"{middle:.3g}"),
            "furthest": None if worst is None else [worst[0], *self._rounded(worst[0])],
            "missing": self.missing,
            "remark": self.remark,
        }

    def _rounded(self, name):
        return [float(f"{v:.4g}") for v in self.pairs[name]]

    def __repr__(self):
        return sentence(self.to_json())

    def _repr_mimebundle_(self, include=None, exclude=None):
        return {"text/plain": repr(self), MIME: self.to_json()}


def _name(key) -> str:
    return " ".join(map(str, key)) if isinstance(key, tuple) else str(key)


def sentence(stored: Mapping) -> str:
    """A stored comparison in words."""
    words = f"{stored['item']}: {stored['within']} of {stored['values']} values within 10 %"
    if stored["median_ratio"] is not None:
        words += f", median ratio {stored['median_ratio']:g}"
    if stored["furthest"] and stored["within"] < stored["values"]:
        name, ours, printed = stored["furthest"]
        words += f"; furthest {name}, {ours:g} against {printed:g}"
    if stored["missing"]:
        words += f"; not found: {', '.join(stored['missing'])}"
    return f"{words}. {stored['remark']}".strip() if stored["remark"] else f"{words}."


def compare(item: str, ours: Mapping, printed: Mapping, remark: str = "") -> None:
    """Display how far ours are from the printed values of one table or figure (`Comparison`)."""
    found = Comparison(item, ours, printed, remark)
    try:
        from IPython.display import display
    except ImportError:  # the notebook's packages are an extra
        print(found)
    else:
        display(found)


def flat(table: Mapping, symbols=None) -> dict[str, float]:
    """{channel: entry} as {"channel symbol": number}, in datasheet units.

    An entry is what `values_of` reads (its Estimates are SI and are converted), or printed values
    or (value, uncertainty) pairs, which are taken as they are.
    """
    out = {}
    for channel, entry in table.items():
        for symbol, value in values_of(entry).items():
            if symbols is not None and symbol not in symbols:
                continue
            if hasattr(value, "shown"):
                value = value.value / datasheet(symbol, channel)[0] if value.shown else None
            elif isinstance(value, tuple):
                value = value[0]
            if value is not None:
                out[f"{channel} {symbol}"] = float(value)
    return out
