#!/usr/bin/env python3
"""What a formatted tree must keep to (docs/developer/style.md): no function above 100 lines or of 7 parameters and more, no header above 300, no source above 500,
no include that climbs ("../") or names a detail header of another room, no call of Ceres past fit/least_squares (which keeps it
silent), no flag of the command line in a text of the library (it names fields, apps/ maps them to flags), no subject of a commit above 72 characters.

    structure.py [--commits RANGE] FILE...

Prints one line per finding; exit code 1 where there is one. Function ends are found by indentation: clang-format has set it.
"""
import re
import subprocess
import sys

LINES = {".hpp": 300, ".cpp": 500}
FUNCTION_LINES = 100
SUBJECT_LENGTH = 72
# What a line that ends in " {" begins with when it opens no function: a type, a namespace, a statement, the end of a block.
NO_FUNCTION = re.compile(r" *(namespace|struct|class|enum|union|extern|if|for|while|switch|do|else|try|return|case|[}\])]|\{)")


def functions(lines):
    """(first line from 1, number of lines) of the bodies that stand in a namespace or in a class."""
    at = 0
    while at < len(lines):
        if lines[at].endswith(" {") and not re.search(r"[=,(] \{$", lines[at]):
            first = at
            while first > 0 and re.search(r"[,(&|?+]$|->$", lines[first - 1]):  # a signature of several lines
                first -= 1
            indent = len(lines[first]) - len(lines[first].lstrip())
            if indent <= 4 and not NO_FUNCTION.match(lines[first]):
                end = next((i for i in range(at + 1, len(lines)) if re.match(r" {0,%d}\}" % indent, lines[i])), None)
                if end is not None:
                    yield first + 1, end - first + 1
                    at = end
        at += 1


KERNELS = re.compile(r"kernel|lapack|blas|legendre\.cpp$")  # numeric kernels and wrappers of LAPACK pass what these pass
LIBRARY = re.compile(r"(core|fit|datasets-synthetic|validate)/")
NO_CALL = {"if", "for", "while", "switch", "return", "sizeof", "catch", "static_assert", "decltype", "assert"}
PARAMETER = re.compile(r"^(const\s+)?[\w:<>,\s*&]+[\s*&]+\w+(\s*=\s*.+)?$", re.S)


def parameters(text, at):
    """The parts between commas of the bracket that opens before text[at]."""
    parts, depth, angle, start = [], 1, 0, at
    while at < len(text) and depth > 0:
        c = text[at]
        if c in "([{":
            depth += 1
        elif c in ")]}":
            depth -= 1
        elif c == "<":
            angle += 1
        elif c == ">" and text[at - 1] != "-":
            angle = max(0, angle - 1)
        if depth == 0 or (c == "," and depth == 1 and angle == 0):
            parts.append(text[start:at].strip())
            start = at + 1
        at += 1
    return parts


def long_signatures(path, text):
    """(line, name, number) of functions with 7 parameters or more."""
    if KERNELS.search(path) or path.startswith("tests/"):
        return
    text = re.sub(r"//[^\n]*", "", text)
    text = re.sub(r'"(\\.|[^"\\])*"', '""', text)
    for call in re.finditer(r"\b([A-Za-z_]\w*)\s*\(", text):
        if call.group(1) in NO_CALL:
            continue
        parts = parameters(text, call.end())
        if len(parts) >= 7 and sum(1 for part in parts if PARAMETER.match(part)) >= len(parts) - 1:
            yield text.count("\n", 0, call.start()) + 1, call.group(1), len(parts)


def room_of(path):
    """The folder of a header without its detail part; None for what is no room's file."""
    return re.sub(r"/detail$", "", path.rpartition("/")[0])


def findings(path):
    lines = open(path, encoding="utf-8").read().splitlines()
    limit = LINES[path[-4:]]
    if len(lines) > limit:
        yield f"{path}: {len(lines)} lines, allowed are {limit}"
    for line, count in functions(lines):
        if count > FUNCTION_LINES:
            yield f"{path}:{line}: function of {count} lines, allowed are {FUNCTION_LINES}"
    for line, name, count in long_signatures(path, "\n".join(lines)):
        yield f"{path}:{line}: {name} has {count} parameters: 7 and more go into a struct"
    for number, line in enumerate(lines, 1):
        if "ceres::Solve(" in line and not path.startswith("fit/least_squares/"):
            yield f"{path}:{number}: ceres::Solve outside fit/least_squares, where its messages are silenced"
        if LIBRARY.match(path) and re.search(r'"--[a-z]', line.partition("//")[0]):
            yield f"{path}:{number}: a flag in the library: name the field (option_error), the command says its flag"
        include = re.match(r'^#include "([^"]+)"', line)
        if not include:
            continue
        if "../" in include.group(1):
            yield f"{path}:{number}: include that climbs: {include.group(1)}"
        # Tests link the detail headers of the room that they test (klang::ROOM_detail).
        if "/detail/" in include.group(1) and not path.startswith("tests/") and room_of(include.group(1)) != room_of(path):
            yield f"{path}:{number}: detail header of another room: {include.group(1)}"


def main(arguments):
    found = []
    if arguments[:1] == ["--commits"]:
        log = subprocess.run(["git", "log", "--format=%h %s", arguments[1]], capture_output=True, text=True)
        for line in log.stdout.splitlines():
            commit, _, subject = line.partition(" ")
            if len(subject) > SUBJECT_LENGTH:
                found.append(f"commit {commit}: subject of {len(subject)} characters, allowed are {SUBJECT_LENGTH}: {subject}")
        arguments = arguments[2:]
    for path in arguments:
        found += findings(path)
    print("\n".join(found + [f"structure: {len(arguments)} files, {len(found)} findings"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
