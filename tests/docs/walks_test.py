#!/usr/bin/env python3
"""README's walks run as they stand: walks_test.py KLANG PYTHON_PACKAGE ROOT [FOLDER_TO_KEEP]

The first block under "## For whom" prepares; each block after `<!-- walk: NAME -->` holds commands, or Python where it imports. All run in one scratch folder where
datasets-synthetic stands for that of ROOT, must end with 0 and leave what their -o and --sfz name. Prints what each took.
"""
import os
import pathlib
import re
import resource
import shlex
import subprocess
import sys
import tempfile
import time


def run(words, folder, environment):
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False, env=environment)
    wrong = [] if done.returncode == 0 else [f"{words}: exit {done.returncode}: {done.stderr.strip()}"]
    for option, value in zip(words, words[1:]):
        if option in ("-o", "--sfz") and not (folder / value).exists():
            wrong.append(f"{words}: did not write {value}")
    return wrong


def main():
    klang, package, root = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    section = re.search(r"^## For whom\n(.*?)^## ", (root / "README.md").read_text(), re.S | re.M)[1]
    blocks = [("start", re.search(r"```\n(.*?)```", section, re.S)[1])]
    blocks += re.findall(r"<!-- walk: (\S+) -->\n```\n(.*?)```", section, re.S)
    environment = dict(os.environ, PATH=f"{klang.parent}:{os.environ['PATH']}", PYTHONPATH=str(package))
    wrong = [] if len(blocks) >= 6 else [f"only {len(blocks)} blocks"]
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(sys.argv[4] if len(sys.argv) > 4 else scratch)
        folder.mkdir(exist_ok=True)
        os.symlink(root / "datasets-synthetic", folder / "datasets-synthetic")
        for name, block in blocks:
            began, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
            if block.startswith("import "):
                wrong += run([sys.executable, "-c", block], folder, environment)
            else:
                for line in block.splitlines():
                    words = shlex.split(line, comments=True)
                    wrong += run(words, folder, environment) if words[0] == "klang" else run(["sh", "-c", line], folder, environment)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            print(f"{name:12} {time.monotonic() - began:6.1f} s, {cpu_s:6.1f} s of processor time")
    print("\n".join(wrong) or f"walks: {len(blocks)}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
