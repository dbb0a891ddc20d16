#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Puts the tables of a `limber paper` run into docs/evidence/paper.md: every case and method, and every claim with its verdict.

  scripts/paper_page.py FOLDER [PAGE]       FOLDER: what --out of limber paper named; PAGE: docs/evidence/paper.md

What stands between the lines <!-- NAME --> and <!-- end --> of the page is replaced, for NAME in provenance, overview, cases,
claims. The numbers are those of FOLDER/paper.html, so that page and report cannot differ; program and processor are those of
FOLDER/paper.sqlite.
"""
import argparse
import json
import pathlib
import re
import sqlite3
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
CASE_COLUMNS = ["method", "runs", "position RMSE [m]", "worst run [m]", "attitude RMSE [deg]", "landmark RMSE [m]", "ANEES pose",
                "ANEES position", "ANEES attitude", "in bounds", "scale"]


def document_of(page):
    found = re.search(r'<script type="application/json" id="report-data">(.*?)</script>', page.read_text(), re.DOTALL)
    if not found:
        sys.exit(f"{page}: expected a report of limber, found no report-data")
    return json.loads(found.group(1))


def cell(text):
    return text.replace("|", "\\|").replace("\n", "<br>")


def markdown(columns, rows):
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(map(cell, line)) + " |" for line in lines)


def blocks(document, kind):
    return [(section, block) for section in document["sections"] for block in section["blocks"] if block["type"] == kind]


def texts(row):
    return [entry["text"] for entry in row]


def provenance(database):
    starts = sqlite3.connect(f"file:{database}?mode=ro", uri=True).execute(
        "SELECT time, program_version, compiler, cpu, processes, threads FROM starts ORDER BY time").fetchall()
    return markdown(["started", "limber", "g++", "processor", "processes", "threads"], [[str(v) for v in row] for row in starts])


def overview(document):
    tables = [block for section, block in blocks(document, "table") if section["id"] == "overview"]
    return "\n\n".join(f"{table['title']}:\n\n{markdown(table['columns'], map(texts, table['rows']))}" for table in tables)


def cases(document):
    out = []
    for section, table in blocks(document, "table"):
        if section["id"] != "overview":
            chosen = [table["columns"].index(name) for name in CASE_COLUMNS]
            rows = [[texts(row)[k] for k in chosen] for row in table["rows"]]
            out.append(f"### {section['title']}\n\n{markdown(CASE_COLUMNS, rows)}")
    return "\n\n".join(out)


def numbered_claims(document):
    """(number, claim) in the order of the list that the report begins with, each with what stands further down."""
    full = {(c["statement"], c["source"]): c for _, block in blocks(document, "claims") if not block["brief"] for c in block["claims"]}
    brief = next(block for _, block in blocks(document, "claims") if block["brief"])
    return [(k + 1, full[c["statement"], c["source"]]) for k, c in enumerate(brief["claims"])]


def claims(document):
    rows = [[str(k), f"{c['statement']} ({c['source']})", c["measured"], c["criterion"],
             c["verdict"] if c["verdict"] == "agrees" else f"**{c['verdict']}**"] for k, c in numbered_claims(document)]
    return markdown(["", "the paper", "measured", "rule", "verdict"], rows)


def replaced(page, name, content):
    pattern = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end -->)", re.DOTALL)
    if len(pattern.findall(page)) != 1:
        sys.exit(f"expected one <!-- {name} --> … <!-- end --> in the page")
    return pattern.sub(lambda found: f"{found.group(1)}\n{content}\n\n{found.group(2)}", page)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("page", type=pathlib.Path, nargs="?", default=ROOT / "docs/evidence/paper.md")
    arguments = parser.parse_args()
    document = document_of(arguments.folder / "paper.html")
    page = arguments.page.read_text()
    for name, content in [("provenance", provenance(arguments.folder / "paper.sqlite")), ("overview", overview(document)),
                          ("cases", cases(document)), ("claims", claims(document))]:
        page = replaced(page, name, content)
    arguments.page.write_text(page)


if __name__ == "__main__":
    main()
