"""Buttons that open a chapter on Binder or Colab: links alone, where the project has an address.

The address comes from the environment: `IMU_LIB_REPOSITORY`, or what GitHub's runners say of
themselves. Without one the pages have no such buttons; nothing is ever fetched for them.
"""

import os
from pathlib import Path

import yaml

HUBS = {
    "binderhub_url": "https://mybinder.org",
    "colab_url": "https://colab.research.google.com",
}


def address() -> str | None:
    """Where the project lives, as `https://github.com/OWNER/NAME`; None where nobody says."""
    own = os.environ.get("IMU_LIB_REPOSITORY")
    server, name = os.environ.get("GITHUB_SERVER_URL"), os.environ.get("GITHUB_REPOSITORY")
    return own or (f"{server}/{name}" if server and name else None)


def write(root: Path) -> None:
    """Put the buttons into the book's configuration, where there is an address."""
    where = address()
    if where is None:
        return
    path = root / "book/_config.yml"
    config = yaml.safe_load(path.read_text(encoding="utf-8"))
    branch = os.environ.get("GITHUB_REF_NAME", "main")
    config["repository"] = {"url": where, "branch": branch, "path_to_book": ""}
    buttons = {**config.get("launch_buttons", {}), **HUBS}
    config["launch_buttons"] = buttons
    # options of the theme that the configuration names are taken in place of the ones above
    config["sphinx"]["config"]["html_theme_options"] |= {
        "repository_url": where,
        "repository_branch": branch,
        "path_to_docs": "",
        "launch_buttons": buttons,
    }
    path.write_text(yaml.safe_dump(config, sort_keys=False), encoding="utf-8")
