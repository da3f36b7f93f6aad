"""A table as a reader sees it: HTML with a caption in a notebook or a page, plain text
elsewhere.
"""

from __future__ import annotations

import html

import pandas as pd


class Shown:
    """A frame with its caption; notebooks draw it as HTML, a terminal as text.

    Parameters
    ----------
    frame : pandas.DataFrame or pandas.Series
    caption : str
        What to see in it; the book numbers a table that has one.
    **options
        Of `pandas.DataFrame.to_string`: `float_format`, `na_rep`, `index`.
    """

    def __init__(self, frame, caption="", **options):
        self.frame = frame.to_frame("") if isinstance(frame, pd.Series) else frame
        self.caption, self.options = caption, options

    def __repr__(self):
        text = self.frame.to_string(**self.options)
        return f"{self.caption}\n{text}" if self.caption else text

    def _repr_html_(self):
        frame, options = self.frame, dict(self.options)
        if options.pop("index", True):  # row names become columns, so that each can be sorted by
            names = [name or "" for name in frame.index.names]
            columns = list(frame.columns)
            frame = frame.reset_index(
                names=names[0] if len(names) == 1 else names, allow_duplicates=True
            )
            if frame.columns.nlevels == 1:
                frame.columns = [*names, *columns]
        text = frame.to_html(index=False, sparsify=False, border=0, justify="right", **options)
        head = f"<caption>{html.escape(self.caption)}</caption>" if self.caption else ""
        return text.replace("<thead>", f"{head}<thead>", 1)


def show(frame, caption="", **options):
    """Display `frame` where the cell stands (see `Shown`); outside of a notebook it is printed."""
    try:
        from IPython.display import display
    except ImportError:  # the notebook's packages are an extra
        print(Shown(frame, caption, **options))
    else:
        display(Shown(frame, caption, **options))
