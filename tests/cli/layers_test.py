#!/usr/bin/env python3
"""Layers are enforced by link targets: what a room does not link, its sources do not find.

    layers_test.py BUILD COMPILER

BUILD/layers/rooms.txt (written by CMake from the targets) says which rooms there are and what they link. For each room, and for klang
itself, the preprocessor is asked with the include folders of the room's own compile command (compile_commands.json) which headers of all
rooms it finds. Claims, for every pair of a room and a header:
  1. a public header is found if the room links the header's room, directly or through public links, and not otherwise;
  2. a header below detail/ is found by its own room alone;
  3. what is found lies on the same storey or a lower one.
"""
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

STOREYS = [["core/foundation"], ["core/geometry"], ["core/physics"], ["core/sound"], ["datasets-synthetic", "fit"],
           ["validate"], ["reports"], ["apps"]]


def storey(folder):
    """(height, name) of the wing or top folder that holds the room."""
    for height, names in enumerate(STOREYS):
        for name in names:
            if folder == name or folder.startswith(name + "/"):
                return height, name
    sys.exit(f"layers: {folder} stands in no storey that layers_test.py knows")


class Room:
    def __init__(self, line):
        self.name, self.folder, links, public = line.split("|")
        self.links = self.rooms_in(links)
        # A static library's private links stand among the public ones as $<LINK_ONLY:...>: their headers are not passed on.
        self.public = self.rooms_in(re.sub(r"\$<LINK_ONLY:[^>]*>", "", public))

    @staticmethod
    def rooms_in(text):
        return {name for name in re.findall(r"klang(?:::|_)(\w+)", text) if not name.endswith("_detail")}


def linked(room, rooms):
    """The room itself, what it links, and what comes with that through public links."""
    found, rest = {room.name}, set(room.links)
    while rest:
        name = rest.pop()
        if name in found or name not in rooms:
            continue
        found.add(name)
        rest |= rooms[name].public
    return found


def include_flags(build, rooms):
    """Room name -> the -I flags of one of its sources."""
    flags = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        match = re.search(r"CMakeFiles/klang(?:_(\w+))?\.dir/", entry.get("output", "") or entry["command"])
        name = match and (match.group(1) or "klang")
        if name in rooms and name not in flags:
            flags[name] = [word for word in shlex.split(entry["command"]) if word.startswith("-I")]
    return flags


def headers_found(compiler, flags, headers, empty_folder):
    text = "".join(f'#if __has_include("{header}")\nfound {header}\n#endif\n' for header in headers)
    run = subprocess.run([compiler, "-std=c++20", "-E", "-P", "-x", "c++", *flags, "-"], input=text, text=True,
                         capture_output=True, cwd=empty_folder, check=True)
    return {"".join(line.split()[1:]) for line in run.stdout.splitlines() if line.startswith("found ")}


def main(build, compiler):
    root = pathlib.Path(__file__).resolve().parents[2]
    rooms = {room.name: room for room in map(Room, (build / "layers/rooms.txt").read_text().split())}
    owner = {}
    for room in rooms.values():
        for pattern in ("*.hpp", "detail/*.hpp"):
            for header in (root / room.folder).glob(pattern):
                owner[str(header.relative_to(root))] = room
    flags = include_flags(build, rooms)
    failures = [f"{name} has no compile command" for name in rooms if name not in flags]
    n_pairs = 0
    with tempfile.TemporaryDirectory() as empty_folder:
        for name in flags:
            room, allowed = rooms[name], linked(rooms[name], rooms)
            found = headers_found(compiler, flags[name], owner, empty_folder)
            height, wing = storey(room.folder)
            for header, other in owner.items():
                n_pairs += 1
                want = other.name == name if "/detail/" in header else other.name in allowed
                if want != (header in found):
                    failures.append(f"{name} {'does not find' if want else 'finds'} {header}")
                other_height, other_wing = storey(other.folder)
                if header in found and not (other_height < height or other_wing == wing):
                    failures.append(f"{name} ({room.folder}) sees {header}, which stands above or beside it")
    if len(rooms) < 20 or len(owner) < 100:
        failures.append(f"only {len(rooms)} rooms and {len(owner)} headers: the lists are broken")
    print("\n".join(failures[:60]))
    print(f"layers: {len(rooms)} rooms, {len(owner)} headers, {n_pairs} pairs, {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]), sys.argv[2]))
