"""The catalogue of what may act on a drive: one effect, one file. Files are found by themselves."""

from importlib import import_module
from pkgutil import iter_modules

_MODULES = [import_module(f"{__name__}.{m.name}") for m in iter_modules(__path__)]
#: Every effect by the name that it has in the model file.
CATALOGUE = {m.EFFECT.name: m.EFFECT for m in _MODULES if hasattr(m, "EFFECT")}
#: Those whose parameters are columns of the innovations (`columns.ALL`).
LINEAR = {n: e for n, e in CATALOGUE.items() if hasattr(e, "columns")}
