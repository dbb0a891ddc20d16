#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Leads links to headings of other pages, which Doxygen leaves as they are, to the headings of the site.

    heading_links.py HTML_FOLDER      after Doxygen, in the root of the tree
"""
import html
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/docs"))
from links import anchor, pages_of  # noqa: E402


def page_name(source):
    name = re.sub(r"[/-]", "_", str(source.relative_to(ROOT).with_suffix("")))
    return "index.html" if name == "README" else f"md_{name}.html"


def headings(page):
    """Identifiers on the site by those that a link of the sources names."""
    found = re.findall(r'<a class="anchor" id="([^"]+)"></a>\s*(.*?)</h\d>', page.read_text(), re.S)
    return {anchor(html.unescape(re.sub(r"<[^>]+>", "", text))): name for name, text in found}


def main():
    folder = Path(sys.argv[1])
    pages = {source: folder / page_name(source) for source in pages_of(ROOT)}
    pages = {source: page for source, page in pages.items() if page.exists()}
    for source, page in pages.items():

        def led(match):
            target = pages.get((source.parent / match[1]).resolve())
            heading = headings(target).get(match[2]) if target else None
            return f'href="{target.name}#{heading}"' if heading else match[0]

        page.write_text(re.sub(r'href="([\w./-]+\.md)#([\w-]+)"', led, page.read_text()))


if __name__ == "__main__":
    main()
