"""For mkdocs: a link of a page that leaves docs/ leads to the file in the repository."""

import pathlib
import re

DOCS = pathlib.Path(__file__).resolve().parent


def on_page_markdown(markdown, page, config, **_):
    """Other links stay as they are: mkdocs checks them."""
    folder = (DOCS / page.file.src_path).parent

    def leading(match):
        target = (folder / match[1]).resolve()
        if target.is_relative_to(DOCS) or not target.exists():
            return match[0]
        return f"]({config['repo_url']}/blob/main/{target.relative_to(DOCS.parent)}{match[2]})"

    return re.sub(r"\]\((\.\./[^)#\s]*)((?:#[^)\s]*)?)\)", leading, markdown)
