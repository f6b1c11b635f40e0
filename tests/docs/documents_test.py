#!/usr/bin/env python3
"""README and docs speak the truth: what they print is what the program prints.

    documents_test.py KLANG ROOT

1. Output. A fenced block that follows `<!-- printed by: klang ARGUMENTS -->` is held against the standard output of that command, run in ROOT;
   OUT stands for a scratch folder. A line "..." in the block stands for any number of lines; before its first and after its last line the
   program may print more.
2. Commands. Every option (--name) of a line "klang SUBCOMMAND ..." in a fenced block is one that `klang SUBCOMMAND --help` lists.
3. Paths. Every path in backticks that begins with a folder of the project's root exists, and so does every program below build/ci, which is
   looked for in the build that KLANG belongs to.
4. The README's list of subcommands has every subcommand of the program, and no other.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

FOLDERS = "core|fit|validate|datasets-synthetic|reports|tests|apps|docs|tools|cmake"


def fenced_blocks(text):
    """(line before the block, lines of the block) of each fenced block."""
    lines, before, block = text.splitlines(), "", None
    for line in lines:
        if line.startswith("```"):
            if block is None:
                block = []
            else:
                yield before, block
                before, block = "", None
        elif block is not None:
            block.append(line)
        elif line.strip():
            before = line.strip()


def stands_in(block, output):
    """Whether the block's lines follow one another in the output, "..." apart."""
    parts, part = [], []
    for line in block + ["..."]:
        if line.strip() == "...":
            if part:
                parts.append(part)
            part = []
        else:
            part.append(line.rstrip())
    at = 0
    for part in parts:
        for start in range(at, len(output) - len(part) + 1):
            if output[start:start + len(part)] == part:
                at = start + len(part)
                break
        else:
            return part
    return None


class Checker:
    def __init__(self, klang, root):
        self.klang, self.root, self.failures, self.help_texts = klang, root, [], {}
        self.build = pathlib.Path(klang).resolve().parents[1]

    def run(self, arguments):
        return subprocess.run([self.klang] + arguments, cwd=self.root, capture_output=True, text=True)

    def help_text(self, words):
        if words not in self.help_texts:
            self.help_texts[words] = self.run(list(words) + ["--help"]).stdout
        return self.help_texts[words]

    def subcommands(self, words=()):
        text = self.help_text(words)
        _, _, after = text.partition("Subcommands:")
        return re.findall(r"^  (\S+)", after, re.M) if after else []

    def check_output(self, name, command, block):
        with tempfile.TemporaryDirectory() as scratch:
            words = command.split()[1:]
            result = self.run([word.replace("OUT", scratch) for word in words])
        missing = stands_in(block, [line.rstrip() for line in result.stdout.splitlines()])
        if result.returncode != 0:
            self.failures.append(f"{name}: `{command}` ends with {result.returncode}: {result.stderr.strip()}")
        elif missing is not None:
            shown = "\n    ".join(missing)
            self.failures.append(f"{name}: `{command}` does not print\n    {shown}\n  it prints\n{result.stdout}")

    def check_options(self, name, line):
        words = line.split("#")[0].split()[1:]
        subcommand = ()
        for word in words:
            if not re.fullmatch(r"[a-z]+", word) or word not in self.subcommands(subcommand):
                break
            subcommand += (word,)
        if not subcommand or (self.subcommands(subcommand) and "|" in line):
            return
        known = self.help_text(subcommand)
        for option in re.findall(r"(?<![\w-])--[a-z][a-z0-9-]*", line.split("#")[0]):
            if not re.search(re.escape(option) + r"(?![\w-])", known):
                self.failures.append(f"{name}: `klang {' '.join(subcommand)}` has no {option}")

    def check_file(self, path):
        name, text = path.relative_to(self.root), path.read_text(encoding="utf-8")
        for before, block in fenced_blocks(text):
            printed = re.fullmatch(r"<!-- printed by: (klang .*) -->", before)
            if printed:
                self.check_output(name, printed[1], block)
            for line in block:
                if line.startswith("klang "):
                    self.check_options(name, line)
        for quoted in re.findall(rf"`((?:{FOLDERS})/[\w./-]*[\w/])`", text):
            if not (self.root / quoted).exists():
                self.failures.append(f"{name}: there is no {quoted}")
        for built in re.findall(r"build/(?:ci|release)/((?:tests|apps)/[\w./-]*\w)", text):
            if not (self.build / built).exists():
                self.failures.append(f"{name}: the build has no {built}")

    def check_readme_list(self):
        text = (self.root / "README.md").read_text(encoding="utf-8")
        listed = set(re.findall(r"^klang (\w+) ", text, re.M))
        there = set(self.subcommands())
        if not there:
            self.failures.append("klang --help lists no subcommands")
        for word in sorted(listed ^ there):
            self.failures.append(f"README.md: subcommand {word} is " + ("not in the list" if word in there else "none"))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    checker = Checker(sys.argv[1], pathlib.Path(sys.argv[2]).resolve())
    files = [checker.root / "README.md", checker.root / "CONTRIBUTING.md"] + sorted((checker.root / "docs").rglob("*.md"))
    for path in files:
        checker.check_file(path)
    checker.check_readme_list()
    for failure in checker.failures:
        print(failure)
    sys.exit(1 if checker.failures else 0)


if __name__ == "__main__":
    main()
