#!/usr/bin/env python3
"""Every cell of docs/notebook.ipynb runs, and it is committed without outputs: notebook_test.py PACKAGE_FOLDER ROOT"""
import os
import pathlib
import sys

import nbclient
import nbformat

PACKAGE, ROOT = sys.argv[1], pathlib.Path(sys.argv[2])
os.environ["PYTHONPATH"] = PACKAGE
notebook = nbformat.read(ROOT / "docs/notebook.ipynb", as_version=4)
assert all(not cell.get("outputs") for cell in notebook.cells), "docs/notebook.ipynb holds outputs"
nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
told = notebook.cells[-1].outputs[0].data["text/plain"]
assert told == "((48000,), 0.708)", told
print(f"notebook: {sum(cell.cell_type == 'code' for cell in notebook.cells)} cells")
