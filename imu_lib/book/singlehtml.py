"""Sphinx extension: what an extension draws in HTML pages it also draws in the single page that
becomes the PDF.

Sphinx takes a builder's own node handlers instead of its format's as soon as one exists;
sphinx-exercise registers none for `singlehtml`, another extension does, and every exercise would
be an unknown node.
"""


def setup(app):
    app.connect("builder-inited", share_handlers)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def share_handlers(app):
    handlers = app.registry.translation_handlers
    if app.builder.name == "singlehtml":
        handlers["singlehtml"] = {**handlers.get("html", {}), **handlers.get("singlehtml", {})}
