#!/usr/bin/env python3
"""The gallery's commands run as they stand: gallery_test.py KLANG ROOT [FOLDER_TO_KEEP]

docs/gallery.md: a block after `<!-- file: NAME -->` is a file, one after `<!-- run: FOLDER -->` holds commands, of which one writes FOLDER with a
page. All run in one scratch folder, in the order of the document, where datasets-synthetic stands for that of ROOT. Each must end with 0 and leave every
file or folder that its -o, --sfz and --csv name; each page must be one (data of its own, no link out). Every picture stands beside the document.
"""
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile


def parts(text):
    """(kind, name, lines) of each marked block."""
    for kind, name, block in re.findall(r"<!-- (file|run): (\S+) -->\n```\n(.*?)```", text, re.S):
        yield kind, name, block


def check_command(line, klang, folder):
    words = shlex.split(line)
    assert words[0] == "klang", line
    ran = subprocess.run([klang, *words[1:]], cwd=folder, capture_output=True, text=True, check=False)
    wrong = [] if ran.returncode == 0 else [f"{line}: exit {ran.returncode}: {ran.stderr.strip()}"]
    for option, value in zip(words, words[1:]):
        if option in ("-o", "--sfz") and not (folder / value).exists():
            wrong.append(f"{line}: did not write {value}")
    return wrong


def check_page(folder):
    page = folder / "report.html"
    if not page.exists():
        return [f"{folder.name}: has no page"]
    text = page.read_text()
    wrong = [] if "<main" in text and "</html>" in text else [f"{folder.name}: the page is not whole"]
    return wrong + [f"{folder.name}: the page links to {link}" for link in re.findall(r"(?:src|href)=\"(https?:[^\"]+)", text)]


def main():
    klang, root = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    document = root / "docs/gallery.md"
    text = document.read_text()
    wrong = [f"no picture {name}" for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", text) if not (document.parent / name).exists()]
    pages = 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else scratch)
        folder.mkdir(exist_ok=True)
        os.symlink(root / "datasets-synthetic", folder / "datasets-synthetic")
        for kind, name, block in parts(text):
            if kind == "file":
                (folder / name).write_text(block)
                continue
            for line in block.splitlines():
                wrong += check_command(line, klang, folder)
            wrong += check_page(folder / name)
            pages += 1
    if pages != len(re.findall(r"^## ", text, re.M)):
        wrong.append(f"{pages} pages of {len(re.findall(r'^## ', text, re.M))} chapters")
    print("\n".join(wrong) or f"gallery: {pages} pages")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
