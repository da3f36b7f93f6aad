"""A Sphinx extension: a function named in the text, as `allan.deviation(x, fs)`, is a link to its
entry in the reference.
"""

import re

from docutils import nodes

NAME = re.compile(r"(?:imu_lib\.|imu\.)?([a-z]\w*(?:\.\w+)+)(?![\w.])")


def target(text: str, objects) -> str | None:
    """Full name of the object that a piece of code names first, of those in the reference."""
    found = NAME.match(text)
    if not found:
        return None
    full = f"imu_lib.{found[1]}"
    return full if full in objects else None


def link(app, doctree, docname):
    """Wrap such literals into references, but for those in links and headings."""
    objects = app.env.domains["py"].objects
    for literal in list(doctree.findall(nodes.literal)):
        name = target(literal.astext(), objects)
        if name is None or objects[name].docname == docname or _inside(literal):
            continue
        entry = objects[name]
        page = app.builder.get_relative_uri(docname, entry.docname)
        reference = nodes.reference(
            "", "", internal=True, refuri=f"{page}#{entry.node_id}", classes=["to-reference"]
        )
        literal.replace_self(reference)
        reference += literal


def _inside(node) -> bool:
    while node.parent is not None:
        node = node.parent
        if isinstance(node, (nodes.reference, nodes.title)):
            return True
    return False


def setup(app):
    app.connect("doctree-resolved", link)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
