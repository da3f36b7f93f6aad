"""Sphinx extension of the book: outputs become numbered figures and tables, and each page loads
and offers only what works.

A chapter is a plain notebook: a figure is what a cell draws, its caption the emphasised sentence
that opens the next cell. Here the two are put together, so that figures are numbered and can be
referred to; a table that `imu_lib.tables.show` drew becomes a table of the page, with the script
of `book/_static/book.js` for sorting it and saving it as CSV.
"""

import re
from html.parser import HTMLParser

from docutils import nodes
from sphinx import addnodes
from sphinx.transforms import SphinxTransform


class Outputs(SphinxTransform):
    """Turns outputs into figures and tables, before targets are propagated (priority 260)."""

    default_priority = 245

    def apply(self, **_):
        for output in list(self.document.findall(nodes.container)):
            if "cell_output" not in output.get("classes", ()):
                continue
            bundles = [child for child in output if child.get("nb_element") == "mime_bundle"]
            for bundle in bundles:
                table = table_of(bundle)
                if table is not None:
                    bundle.replace_self(table)
                    adopt(self.document, output, table)
            pictures = [bundle for bundle in bundles if next(bundle.findall(nodes.image), None)]
            if pictures:
                framed = frame(pictures[-1], following(output.parent))
                if framed is not None:
                    adopt(self.document, output, framed)


def table_of(bundle):
    """The docutils table of an output whose HTML is a captioned pandas table; None for others."""
    for raw in bundle.findall(nodes.raw):
        if raw.get("format") == "html" and 'class="dataframe"' in raw.astext():
            found = Rows()
            found.feed(raw.astext())
            return table_node(found)
    return None


class Rows(HTMLParser):
    """Header rows, body rows and caption of a plain HTML table."""

    def __init__(self):
        super().__init__()
        self.head, self.body, self.caption = [], [], ""
        self._rows, self._text = self.body, None

    def handle_starttag(self, tag, attrs):
        if tag in ("thead", "tbody"):
            self._rows = self.head if tag == "thead" else self.body
        elif tag == "tr":
            self._rows.append([])
        elif tag in ("td", "th", "caption"):
            self._text = ""

    def handle_data(self, data):
        if self._text is not None:
            self._text += data

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self._rows[-1].append(self._text.strip())
        elif tag == "caption":
            self.caption = self._text
        if tag in ("td", "th", "caption"):
            self._text = None


def table_node(found: Rows):
    width = max(map(len, [*found.head, *found.body]))
    group = nodes.tgroup(cols=width)
    group += [nodes.colspec(colwidth=1) for _ in range(width)]
    for part, rows in ((nodes.thead(), found.head), (nodes.tbody(), found.body)):
        for cells in rows:
            row = nodes.row()
            row += [nodes.entry("", nodes.paragraph("", cell)) for cell in cells]
            part += row
        group += part
    table = nodes.table("", group, classes=["computed"])
    if found.caption:
        table.insert(0, nodes.title("", found.caption))
    return table


def following(cell):
    """The paragraph that comes right after a code cell in the text, or None."""
    after = cell.next_node(descend=False, siblings=True)
    while isinstance(after, (nodes.target, nodes.comment)):
        after = after.next_node(descend=False, siblings=True)
    return after if isinstance(after, nodes.paragraph) else None


def frame(bundle, paragraph):
    """Put the picture into a figure whose caption is the emphasis that opens `paragraph`."""
    if paragraph is None or not paragraph.children or not isinstance(paragraph[0], nodes.emphasis):
        return None
    words = paragraph[0]
    figure = nodes.figure("", classes=["computed"])
    caption = nodes.caption("", "", *[child.deepcopy() for child in words.children])
    bundle.replace_self(figure)
    figure += [bundle, caption]
    paragraph.remove(words)
    if paragraph.children and isinstance(paragraph[0], nodes.Text):
        paragraph.replace(paragraph[0], nodes.Text(paragraph[0].astext().lstrip()))
    if not paragraph.astext().strip():
        paragraph.parent.remove(paragraph)
    for image in figure.findall(nodes.image):
        image["alt"] = caption.astext()
    return figure


def adopt(document, output, node):
    """Give `node` the targets that stand before its cell, so that a reference says its number."""
    cell = output.parent
    siblings = cell.parent.children
    at = siblings.index(cell)
    taken = []
    while at and isinstance(siblings[at - 1], nodes.target):
        at -= 1
        taken.append(siblings[at])
    for target in taken:
        for name in target["ids"] or [target.get("refid")]:
            if name:
                node["ids"].append(name)
                document.ids[name] = node
        node["names"].extend(target["names"])
        cell.parent.remove(target)
    if not node["ids"]:
        document.set_id(node)


class Functions(SphinxTransform):
    """Turns the code of a table of symbols into links to the reference, where it names a
    function.
    """

    default_priority = 700

    def apply(self, **_):
        if not self.env.docname.startswith("nbs/"):
            return
        for table in self.document.findall(nodes.table):
            if "computed" in table.get("classes", ()):
                continue
            for literal in list(table.findall(nodes.literal)):
                name = re.match(r"[A-Za-z_]\w*\.[A-Za-z_]\w*", literal.astext())
                if name is None or isinstance(literal.parent, addnodes.pending_xref):
                    continue
                link = addnodes.pending_xref(
                    "",
                    refdomain="py",
                    reftype="obj",
                    reftarget=name[0],
                    refspecific=True,
                    refexplicit=True,
                    refwarn=False,
                    refdoc=self.env.docname,
                )
                literal.replace_self(link)
                link += literal


def page_context(app, pagename, templatename, context, doctree):
    """Leave out Thebe, which needs a network (and is declared twice), and say what printing
    does.
    """
    context["script_files"] = [
        script
        for script in context.get("script_files", ())
        if "thebe" not in str(getattr(script, "filename", script)).lower()
        and "THEBE" not in str(getattr(script, "attributes", {}).get("body", ""))
    ]
    for group in context.get("header_buttons", ()):
        for button in group.get("buttons", ()):
            if button.get("label") == "download-pdf-button":
                button["text"], button["tooltip"] = "Print this page", "Print this page, or to PDF"


def plain_docstring(app, what, name, obj, options, lines):
    """Docstrings are plain text with formulas: what reStructuredText would take for markup is
    not.
    """
    for number, line in enumerate(lines):
        bullet, line = re.match(r"(\s*(?:\* )?)(.*)", line).groups()
        parts = re.split(r"(`+[^`]+`+)", line)
        lines[number] = bullet + "".join(
            part
            if part.startswith("`")
            else re.sub(r"(?<=\w)_(?=\W|$)", r"\\_", re.sub(r"([|*])", r"\\\1", part))
            for part in parts
        )


def skip_values(app, what, name, obj, skip, options):
    """Only functions and classes have an entry in the reference; tables of values do not."""
    return True if what == "module" and not callable(obj) else skip


def setup(app):
    if "sphinx.ext.autodoc" in app.extensions:
        app.connect("autodoc-process-docstring", plain_docstring, priority=100)
        app.connect("autodoc-skip-member", skip_values)
    app.add_transform(Outputs)
    app.add_transform(Functions)
    app.connect("html-page-context", page_context, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
