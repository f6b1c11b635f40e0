#!/usr/bin/env python3
"""The page of a fit as it prints: print_test.py KLANG ROOT [FOLDER_TO_KEEP]

Chromium prints it, poppler reads it. Every cell of every table is there, folds or not, every page has its number of how many, the date stands there
as ISO 8601 has it, the paper is A4, and no word lies beyond its margins. A page with a table that does not print, and without numbers, must be found, so that the test can fail.
"""
import html.parser
import os
import pathlib
import re
import subprocess
import sys
import tempfile

POINTS_MM = 72.0 / 25.4
MARGIN = 13.0 * POINTS_MM  # a little less than the page's own, 14 mm


class Cells(html.parser.HTMLParser):
    """Texts of td and th, those left out that do not print: buttons and what holds them."""

    def __init__(self):
        super().__init__()
        self.cells, self.open, self.skip, self.tables = [], False, 0, 0

    def handle_starttag(self, tag, attributes):
        classes = (dict(attributes).get("class") or "").split()
        self.tables += tag == "table"
        if tag in ("td", "th"):
            self.open = "act" not in classes
            if self.open:
                self.cells.append("")

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self.open = False

    def handle_data(self, data):
        if self.open:
            self.cells[-1] += data


def squeezed(text):
    return re.sub(r"\s+", "", text)


def printed(page, folder):
    pdf = folder / "page.pdf"
    pdf.unlink(missing_ok=True)
    subprocess.run(
        ["timeout", "200", "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-dev-shm-usage",
         f"--user-data-dir={folder}/profile", "--no-pdf-header-footer", f"--print-to-pdf={pdf}", f"file://{page}"],
        capture_output=True, check=False)
    text = subprocess.run(["pdftotext", "-raw", str(pdf), "-"], capture_output=True, text=True, check=True).stdout
    boxes = subprocess.run(["pdftotext", "-bbox", str(pdf), "-"], capture_output=True, text=True, check=True).stdout
    return text, boxes


def complaints(page, folder):
    text, boxes = printed(page, folder)
    cells = Cells()
    cells.feed(page.read_text())
    wrong = []
    if cells.tables < 3 or len(cells.cells) < 50:
        wrong.append(f"the page has {cells.tables} tables of {len(cells.cells)} cells")
    # A cell may break over lines, and over pages between its rows: words are looked for without their blanks, a line's hyphens kept.
    flat = squeezed(text)
    for cell in cells.cells:
        words = [squeezed(word) for word in cell.split()]
        lost = [word for word in words if word not in flat]
        if lost:
            wrong.append(f"not printed: {' '.join(lost)}")
    pages = text.rstrip("\f").split("\f")
    for i, one in enumerate(pages):
        if f"{i + 1} / {len(pages)}" not in one:
            wrong.append(f"page {i + 1} has no '{i + 1} / {len(pages)}'")
    if not re.search(r"\b20\d\d-[01]\d-[0-3]\d\b", text):
        wrong.append("no date")
    for width, height, body in re.findall(r'<page width="([\d.]+)" height="([\d.]+)">(.*?)</page>', boxes, re.S):
        if abs(float(width) - 210 * POINTS_MM) > 2 or abs(float(height) - 297 * POINTS_MM) > 2:
            wrong.append(f"the paper is {width} x {height} points")
        for left, right, word in re.findall(r'<word xMin="([-\d.]+)" yMin="[-\d.]+" xMax="([-\d.]+)" yMax="[-\d.]+">(.*?)</word>', body):
            if float(left) < MARGIN or float(right) > float(width) - MARGIN:
                wrong.append(f"beyond the margin: {word}")
    return wrong


def main():
    klang, root = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else scratch).resolve()
        folder.mkdir(exist_ok=True)
        subprocess.run([klang, "fit", str(root / "datasets-synthetic/tables/s02_chimes.toml"), "-o", "fit", "--no-pictures", "-q"],
                       cwd=folder, check=False)
        subprocess.run([klang, "chime", "fit/fit.json", "--notes", "D5 E5 G5 A5 B5", "-o", "chime", "-q"], cwd=folder, check=True)
        wrong = []
        for name in ("fit", "chime"):
            wrong += [f"{name}: {one}" for one in complaints(folder / name / "report.html", folder)]
        # What must be found: a table that does not print, pages without their numbers.
        spoilt = (folder / "chime/report.html").read_text().replace(
            "</main>", '<table style="display:none"><tr><td>unprinted</td></tr></table></main>').replace("counter(pages)", '"all"')
        (folder / "spoilt.html").write_text(spoilt)
        found = " ".join(complaints(folder / "spoilt.html", folder))
        if "not printed: unprinted" not in found or "page 1 has no" not in found:
            wrong.append(f"a spoilt page was not found to be one: {found[:300]}")
    print("\n".join(wrong[:40]) if wrong else "print: every table fits")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
