#!/usr/bin/env python3
"""Builds the book with mdBook, and checks every link and anchor of its pages.

    docs/book.py FOLDER          writes FOLDER/index.html; needs `mdbook` 0.5 in the PATH, or its path in MDBOOK

The pages stay where GitHub shows them, with links relative to their files; docs/SUMMARY.md lists them. mdBook wants all of them in
one folder, so they are copied to a temporary one with everything that they link to. Exit code 1: a warning of mdBook, a broken
link, a dead anchor, or a page that no chapter shows.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parent.parent
SUMMARY = ROOT / "docs/SUMMARY.md"
LINK = re.compile(r"\]\(([^)#\s]+)(#[^)\s]*)?\)")
CODE = re.compile(r"^```.*?^```|`[^`\n]*`", re.MULTILINE | re.DOTALL)


def chapters() -> list[Path]:
    """The pages of the book, relative to the repository."""
    links = [match[1] for match in LINK.finditer(SUMMARY.read_text())]
    return [Path(os.path.relpath(SUMMARY.parent / link, ROOT)) for link in links]


def stage(folder: Path) -> list[str]:
    """Copies the pages and what they link to; the faults of links to nothing."""
    faults = []
    pages = chapters()
    for page in pages:
        text = (ROOT / page).read_text()
        target = folder / page
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text)
        for match in LINK.finditer(CODE.sub("", text)):
            link = match[1]
            if "://" in link or link.startswith("mailto:"):
                continue
            linked = Path(os.path.relpath((ROOT / page).parent / unquote(link), ROOT))
            if not (ROOT / linked).exists():
                faults.append(f"{page}: {link} does not exist")
            elif linked.suffix == ".md" and linked not in pages:
                faults.append(f"{page}: {link} is no chapter of docs/SUMMARY.md")
            elif linked not in pages:
                (folder / linked).parent.mkdir(parents=True, exist_ok=True)
                copy = shutil.copytree if (ROOT / linked).is_dir() else shutil.copy
                if not (folder / linked).exists():
                    copy(ROOT / linked, folder / linked)
    relative = LINK.sub(lambda match: f"]({os.path.relpath(SUMMARY.parent / match[1], ROOT)})", SUMMARY.read_text())
    (folder / "SUMMARY.md").write_text(relative)
    return faults


class Page(HTMLParser):
    """The anchors and links of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.feed(path.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("id", "name") and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)


def dead_links(book: Path) -> list[str]:
    """Links of the built pages that lead to no file or to no anchor."""
    pages = {path.resolve(): Page(path) for path in book.rglob("*.html") if path.name not in ("toc.html", "404.html")}
    faults = []
    for path, page in pages.items():
        for link in page.links:
            if re.match(r"[a-z]+:", link):
                continue
            to, _, anchor = unquote(link).partition("#")
            target = (path.parent / to).resolve() if to else path
            if not target.exists():
                faults.append(f"{path.relative_to(book.resolve())}: {link} leads to no file")
            elif anchor and target in pages and anchor not in pages[target].anchors:
                faults.append(f"{path.relative_to(book.resolve())}: {link} leads to no anchor")
    return sorted(set(faults))


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    book = Path(sys.argv[1]).absolute()
    with tempfile.TemporaryDirectory() as made:
        staged = Path(made)
        shutil.copy(ROOT / "docs/book.toml", staged)
        (staged / "src").mkdir()
        faults = stage(staged / "src")
        built = subprocess.run(
            [os.environ.get("MDBOOK", "mdbook"), "build", "--dest-dir", str(book), str(staged)],
            capture_output=True,
            text=True,
        )
        said = built.stdout + built.stderr
        faults += [line for line in said.splitlines() if "WARN" in line or "ERROR" in line]
        if built.returncode != 0 and not faults:
            faults.append(said)
    if built.returncode == 0:
        faults += dead_links(book)
    for fault in faults:
        print(fault)
    print(f"{len(chapters())} chapters, {len(faults)} faults: {book / 'index.html'}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
