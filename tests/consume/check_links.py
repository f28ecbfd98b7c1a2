#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when a page below FOLDER links to a file that is not there: check_links.py FOLDER"""
import pathlib
import re
import sys

LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")
CODE = re.compile(r"```.*?```|`[^`]*`", re.DOTALL)


def broken_links(folder):
    for page in sorted(folder.rglob("*.md")):
        for link in LINK.findall(CODE.sub("", page.read_text(encoding="utf-8"))):
            if "://" not in link and not link.startswith("mailto:") and not (page.parent / link).exists():
                yield f"{page.relative_to(folder)}: {link}"


def main(folder):
    folder = pathlib.Path(folder)
    pages = len(list(folder.rglob("*.md")))
    broken = list(broken_links(folder))
    print("\n".join(broken) or f"{pages} pages: every link leads somewhere")
    return 1 if broken or not pages else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
