"""Liquids and bubbles of other programs for tools/attack and the fuzz targets: OpenFOAM cases, trackedBubInfo."""
import itertools

TRACKED = ("Bub 1 0.002\n  Start: N 0.01\n  0.01 1640 0.1 0.05 -0.02 0 0.03\n  0.02 1700.25 0.1 0.051 -0.02 0 0.029\n  End: S 0.02 2 3\n"
           "Bub 2 0.0015\n  Start: S 0.02 1\n  0.02 2200 0.1 0.07 -0.02\n  0.03 2210 0.1 0.08 -0.02\n  End: C 0.03\n"
           "Bub 3 0.001\n  Start: S 0.02 1\n  0.02 3300 0.1 0.07 -0.02\n  0.025 3310 0.1 0.08 -0.02\n  End: M 0.025 2\n")
POOL = ('name = "pool"\n[domain]\nsize_m = [0.12, 0.1, 0.12]\ncell_m = 0.02\nduration_s = 0.03\nframe_rate_hz = 100\n[[pool]]\ndepth_m = 0.074\n'
        "[listener]\nposition_m = [0.06, -0.5, 0.3]\n")
CELLS = (4, 3, 4)
EDGE_M = 0.02


def _file(name, kind, text):
    return f"FoamFile\n{{\n version 2.0;\n format ascii;\n class {kind};\n object {name.rsplit('/', 1)[-1]};\n}}\n{text}".encode()


def _listed(rows):
    return f"{len(rows)}\n(\n" + "".join(f"{row}\n" for row in rows) + ")\n"


def _faces():
    """(corners, cell, cell beside it or None) of every face, inner ones first; corners turn outwards."""
    inner, outer = [], []
    for k, j, i in itertools.product(*(range(n) for n in reversed(CELLS))):
        here = (i, j, k)
        for axis, up in itertools.product(range(3), (1, 0)):
            b, c = (axis + 1) % 3, (axis + 2) % 3
            corners = []
            for first, second in ((0, 0), (1, 0), (1, 1), (0, 1)):
                at = list(here)
                at[axis] += up
                at[b if up else c] += first
                at[c if up else b] += second
                corners.append(at[0] + (CELLS[0] + 1) * (at[1] + (CELLS[1] + 1) * at[2]))
            beside = list(here)
            beside[axis] += 1
            if up and beside[axis] < CELLS[axis]:
                inner.append((corners, here, tuple(beside)))
            elif up or here[axis] == 0:
                outer.append((corners, here, None))
    return inner, outer


def openfoam_case(times=("0", "0.01"), depth_m=0.05):
    """File contents by name: a box of CELLS cells, water up to depth_m."""
    inner, outer = _faces()
    number = lambda at: at[0] + CELLS[0] * (at[1] + CELLS[1] * at[2])  # noqa: E731
    points = [f"({EDGE_M * i:g} {EDGE_M * j:g} {EDGE_M * k:g})"
              for k, j, i in itertools.product(*(range(n + 1) for n in reversed(CELLS)))]
    mesh = "constant/polyMesh/"
    files = {mesh + "points": _file("points", "vectorField", _listed(points)),
             mesh + "faces": _file("faces", "faceList", _listed(["4(" + " ".join(map(str, f[0])) + ")" for f in inner + outer])),
             mesh + "owner": _file("owner", "labelList", _listed([number(f[1]) for f in inner + outer])),
             mesh + "neighbour": _file("neighbour", "labelList", _listed([number(f[2]) for f in inner])),
             mesh + "boundary": _file("boundary", "polyBoundaryMesh", f"1\n(\nwalls\n{{\n type wall;\n nFaces {len(outer)};\n startFace "
                                      f"{len(inner)};\n}}\n)\n"),
             "system/controlDict": _file("controlDict", "dictionary", "startTime 0;\nendTime 1;\ndeltaT 0.01;\nwriteInterval 0.01;\n")}
    for time in times:
        share = [f"{min(1.0, max(0.0, (depth_m - EDGE_M * k) / EDGE_M)):g}" for k in range(CELLS[2]) for _ in range(CELLS[0] * CELLS[1])]
        files[f"{time}/alpha.water"] = _file("alpha.water", "volScalarField", "dimensions [0 0 0 0 0 0 0];\ninternalField nonuniform "
                                             f"List<scalar>\n{_listed(share)};\nboundaryField\n{{\nwalls\n{{\n type zeroGradient;\n}}\n}}\n")
    return files


def bases(klang_run, folder):
    """Kind: (files by name, the one that is broken, command), as attack_files.bases."""
    found = {"tracked": ({"t.txt": TRACKED.encode()}, "t.txt", "scene import t.txt --kind tracked -o out -q")}
    case = {"case/" + name: data for name, data in openfoam_case().items()}
    for name in case:
        kind = "openfoam-" + name.rsplit("/", 1)[-1]
        found[kind] = (case, name, "scene import case --kind openfoam -o out -q")
    (folder / "pool.toml").write_text(POOL)
    # A build without OpenVDB has no frames.
    if klang_run("scene run pool.toml -o pool --no-page -q") and klang_run("scene export pool --vdb vdb -q"):
        frames = {f.name: f.read_bytes() for f in sorted((folder / "vdb").glob("*.vdb"))}
        found["vdb"] = (frames, "f_0001.vdb", "scene import f_####.vdb --kind vdb --frame-step-s 0.01 -o out -q")
    return found
