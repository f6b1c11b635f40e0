#!/usr/bin/env python3
"""additions_test.py SOURCE BUILD CXX: adds a dummy shape, damping law, study, command with a page and room to a copy of the sources, as
docs/developer/add-*.md say, compiles what is new or touched, links the program from that and BUILD's libraries, and uses the dummies.

Holds: at most three files that were there before are touched for each, and the how-to page names them and no others.
"""
import json, pathlib, re, shutil, subprocess, sys

SOURCE, BUILD, CXX = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
HERE = SOURCE / "tests" / "docs" / "additions"
COPY = BUILD / "additions" / "source"
TREE = BUILD / "additions" / "build"
FOLDERS = ["core", "fit", "validate", "datasets-synthetic", "reports", "apps", "cmake", "tests", "docs"]

# (how-to page, file, what stands there, what stands there afterwards)
EDITS = [
    ("shape", "core/geometry/shapes/shape_registry.cpp", '#include "core/geometry/shapes/detail/revolution_shape.hpp"\n',
     '#include "core/geometry/shapes/detail/pebble_shape.hpp"\n#include "core/geometry/shapes/detail/revolution_shape.hpp"\n'),
    ("shape", "core/geometry/shapes/shape_registry.cpp", "&detail::revolution_shape(),", "&detail::revolution_shape(), &detail::pebble_shape(),"),
    ("shape", "core/geometry/shapes/CMakeLists.txt", "detail/sphere_shape.cpp", "detail/sphere_shape.cpp detail/pebble_shape.cpp"),
    ("damping-law", "core/physics/modal/damping/damping_laws.cpp", '#include "core/physics/modal/damping/zener.hpp"\n',
     '#include "core/physics/modal/damping/square_root.hpp"\n#include "core/physics/modal/damping/zener.hpp"\n'),
    ("damping-law", "core/physics/modal/damping/damping_laws.cpp", "    RegisteredLaw{zener_law, LawUse::kRecipes},",
     "    RegisteredLaw{square_root_law, LawUse::kOptions},\n    RegisteredLaw{zener_law, LawUse::kRecipes},"),
    ("damping-law", "core/physics/modal/damping/CMakeLists.txt", "zener.cpp", "zener.cpp square_root.cpp"),
    ("study", "validate/studies/CMakeLists.txt", "set(studies fem", "set(studies midpoint fem"),
    ("command", "apps/commands/commands.cpp", "  COMMAND(doctor)", "  COMMAND(tally) \\\n  COMMAND(doctor)"),
    ("command", "reports/pages/CMakeLists.txt", "set(pages fit", "set(pages tally fit"),
    ("room", "core/physics/CMakeLists.txt", "foreach(room ", "foreach(room tally "),
    ("room", "tests/CMakeLists.txt", "core/physics/bubble ", "core/physics/bubble core/physics/tally "),
]
REGISTRIES = ["validate/studies/registry.cpp", "reports/pages/registry.cpp"]  # written by CMake from the lists that an addition is entered in


def run(command, where, fails=False):
    done = subprocess.run([str(c) for c in command], cwd=where, capture_output=True, text=True)
    if (done.returncode != 0) != fails:
        sys.exit(f"{' '.join(map(str, command))}: exit {done.returncode}\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}")
    return done.stdout + done.stderr


def expect(right, what):
    if not right:
        sys.exit("FAILED: " + what)
    print("ok:", what)


def copy_sources():
    """The copy keeps the times of unchanged files, so that a second run builds little."""
    for name in FOLDERS:
        for file in (SOURCE / name).rglob("*"):
            if not file.is_file() or HERE in file.parents or "__pycache__" in file.parts:
                continue
            to = COPY / file.relative_to(SOURCE)
            if not to.exists() or to.read_bytes() != file.read_bytes():
                to.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(file, to)
    for name in ["CMakeLists.txt", "README.md", "CMakePresets.json", "LICENSE"]:
        if (SOURCE / name).exists():
            shutil.copy2(SOURCE / name, COPY / name)


def add(kind):
    """Returns the files that are new, and those that were there and are touched."""
    new = []
    for file in (HERE / kind).rglob("*"):
        if file.is_file():
            to = COPY / file.relative_to(HERE / kind)
            expect(not (SOURCE / file.relative_to(HERE / kind)).exists(), f"{kind}: {to.relative_to(COPY)} is new")
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(file, to)
            new.append(str(to.relative_to(COPY)))
    touched = []
    for page, name, before, after in EDITS:
        if page != kind:
            continue
        text = (COPY / name).read_text()
        expect(text.count(before) == 1, f"{kind}: {name} has the place for the line")
        (COPY / name).write_text(text.replace(before, after))
        if name not in touched:
            touched.append(name)
    return new, touched


def named_by_page(kind):
    text = (SOURCE / "docs" / "developer" / f"add-{kind}.md").read_text()
    expect("Touched files:" in text, f"add-{kind}.md lists what is touched")
    numbered = [line for line in text.split("Touched files:")[1].split("\n") if re.match(r"\d\. ", line)]
    return [re.findall(r"`([^`]+)`", line)[0] for line in numbered]


def changed_objects(sources):
    """Builds what the additions change, each source on its own; everything else stays BUILD's."""
    units = json.loads((TREE / "compile_commands.json").read_text())
    wanted = {COPY / name for name in sources} | {TREE / name for name in REGISTRIES}
    objects = [re.search(r" -o (\S+)", unit["command"])[1] for unit in units if pathlib.Path(unit["file"]) in wanted]
    expect(len(objects) == len([name for name in wanted if name.suffix == ".cpp"]), f"{len(objects)} objects hold what is new or touched")
    run(["ninja", "tally_test", *objects], TREE)
    return objects


def link(objects):
    """The program's link command with BUILD's objects and libraries, behind those that the additions change."""
    command = run(["ninja", "-t", "commands", "apps/klang"], TREE).strip().split("\n")[-1]
    words = re.sub(r"^: && | && :$", "", command).split()
    def place(word):
        return str(BUILD / word) if word.endswith((".a", ".o")) and not word.startswith("/") else word
    # What is first in the line holds: BUILD's libraries have the touched sources as they were.
    at = next(k for k, word in enumerate(words) if word.endswith(".o"))
    run([*map(place, words[:at]), *objects, "-Wl,-z,muldefs", *map(place, words[at:])], TREE)
    return TREE / "apps" / "klang"


def main():
    copy_sources()
    sources = []
    for kind in ["shape", "damping-law", "study", "command", "room"]:
        (new, touched), named = add(kind), named_by_page(kind)
        expect(len(named) <= 3, f"add-{kind}.md names at most three files: {', '.join(named)}")
        for name in touched:
            expect(name in named, f"add-{kind}.md names {name}")
        sources += [name for name in new + touched if name.endswith(".cpp") and not name.startswith("tests/")]
    run(["cmake", "-S", COPY, "-B", TREE, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Dummies", "-DCMAKE_CXX_FLAGS_DUMMIES=-O0 -DNDEBUG",
         f"-DCMAKE_CXX_COMPILER={CXX}", "-DKLANG_BUILD_TESTS=ON", "-DKLANG_BUILD_BENCHMARKS=OFF",
         "-DKLANG_BATCH=OFF", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"], BUILD)
    klang = link(changed_objects(sources))
    out = TREE / "out"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    run([klang, "mesh", "pebble", "--dims", "diameter_m=0.1", "-o", "pebble.vtu", "--json", "pebble.json"], out)
    text = run([klang, "mesh", "pebble", "--dims", "diameter_m=-1", "-o", "bad.vtu"], out, fails=True)
    expect("diameter_m" in text, "the shape's own dimension is refused by name: " + text.strip())
    text = run([klang, "synth", "--help"], out)
    expect("--root-factor" in text, "the damping law is an option of klang synth")
    run([klang, "converge", "midpoint", "-o", "study", "--json", "midpoint.json"], out)
    order = json.loads((out / "midpoint.json").read_text())["series"][0]["observed_order"]
    expect(abs(order - 2) <= 0.05, f"the study observes order {order}")
    run([klang, "tally", "3", "-o", "tally"], out)
    page = (out / "tally" / "report.html").read_text()
    expect("3 taps were counted." in page, "the command writes its result's page")
    expect("1 test" in run([TREE / "tests/core/physics/tally/tally_test"], out), "the room's test runs")


main()
