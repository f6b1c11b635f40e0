#!/usr/bin/env python3
"""Writes the small mesh files that tests/mesh reads: a 1 x 2 x 3 brick of six tetrahedra (volume 6), with one unused
node, a physical group "base" (triangles on z = 0) and one "body". Written straight from the format descriptions, not by
the program under test; the .vtu files come from VTK's own writer (package python3-vtk9)."""
import itertools
import pathlib
import struct

here = pathlib.Path(__file__).parent
corners = [(x, y, z) for z in (0, 3) for y in (0, 2) for x in (0, 1)]
tets = []
for path in itertools.permutations((1, 2, 4)):
    t = [0, path[0], path[0] + path[1], 7]
    even = path in ((1, 2, 4), (2, 4, 1), (4, 1, 2))
    tets.append(t if even else [t[0], t[2], t[1], t[3]])
base = [(0, 1, 3), (0, 3, 2)]
nodes = [tuple(map(float, c)) for c in corners]
mids = {}


def mid(a, b):
    key = (min(a, b), max(a, b))
    if key not in mids:
        mids[key] = len(nodes10)
        nodes10.append(tuple((p + q) / 2 for p, q in zip(nodes[a], nodes[b])))
    return mids[key]


nodes10 = list(nodes)
EDGES = {"vtk": ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)),
         "gmsh": ((0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)),
         "tetgen": ((2, 3), (0, 3), (0, 1), (1, 2), (1, 3), (0, 2))}
tets10 = {kind: [t + [mid(t[a], t[b]) for a, b in edges] for t in tets] for kind, edges in EDGES.items()}
base6 = [list(t) + [mid(t[0], t[1]), mid(t[1], t[2]), mid(t[2], t[0])] for t in base]
unused = (9.0, 9.0, 9.0)
NAMES = '$PhysicalNames\n2\n2 7 "base"\n3 1 "body"\n$EndPhysicalNames\n'


def gmsh22(order, binary):
    pts = [unused] + (nodes10 if order == 2 else nodes)
    faces, solids = (base6, tets10["gmsh"]) if order == 2 else (base, tets)
    kinds = [(9 if order == 2 else 2, 7, faces), (11 if order == 2 else 4, 1, solids)]
    out = b"$MeshFormat\n2.2 %d 8\n" % binary + (struct.pack("<i", 1) + b"\n" if binary else b"") + b"$EndMeshFormat\n"
    out += NAMES.encode() + b"$Nodes\n%d\n" % len(pts)
    for i, p in enumerate(pts):  # numbers 10, 20, ...: they need not run on
        out += struct.pack("<i3d", 10 * (i + 1), *p) if binary else b"%d %r %r %r\n" % (10 * (i + 1), *p)
    out += (b"\n" if binary else b"") + b"$EndNodes\n$Elements\n%d\n" % sum(len(k[2]) for k in kinds)
    number = 0
    for kind, tag, rows in kinds:
        if binary:
            out += struct.pack("<3i", kind, len(rows), 2)
        for row in rows:
            number += 1
            ids = [10 * (n + 2) for n in row]
            out += (struct.pack("<%di" % (3 + len(ids)), number, tag, 1, *ids) if binary
                    else b"%d %d 2 %d 1 " % (number, kind, tag) + b" ".join(b"%d" % n for n in ids) + b"\n")
    return out + (b"\n" if binary else b"") + b"$EndElements\n"


def gmsh41(order, binary):
    pts = [unused] + (nodes10 if order == 2 else nodes)
    faces, solids = (base6, tets10["gmsh"]) if order == 2 else (base, tets)
    ints = lambda *v: struct.pack("<%di" % len(v), *v) if binary else b" ".join(b"%d" % x for x in v) + b" "
    sizes = lambda *v: struct.pack("<%dQ" % len(v), *v) if binary else b" ".join(b"%d" % x for x in v) + b" "
    reals = lambda *v: struct.pack("<%dd" % len(v), *v) if binary else b" ".join(b"%r" % x for x in v) + b" "
    end = b"" if binary else b"\n"
    out = b"$MeshFormat\n4.1 %d 8\n" % binary + (struct.pack("<i", 1) + b"\n" if binary else b"") + b"$EndMeshFormat\n"
    out += NAMES.encode() + b"$Entities\n" + sizes(0, 0, 1, 1) + end
    out += ints(4) + reals(0., 0., 0., 1., 2., 0.) + sizes(1) + ints(7) + sizes(0) + end
    out += ints(5) + reals(0., 0., 0., 1., 2., 3.) + sizes(1) + ints(1) + sizes(1) + ints(4) + end
    out += b"\n$EndEntities\n$Nodes\n" + sizes(2, len(pts), 10, 10 * len(pts)) + end
    for dim, tag, part, first in ((2, 4, pts[:3], 1), (3, 5, pts[3:], 4)):
        out += ints(dim, tag, 0) + sizes(len(part)) + end
        for i in range(len(part)):
            out += sizes(10 * (first + i)) + end
        for p in part:
            out += reals(*p) + end
    n = len(faces) + len(solids)
    out += b"\n$EndNodes\n$Elements\n" + sizes(2, n, 1, n) + end
    number = 0
    for dim, tag, kind, rows in ((2, 4, 9 if order == 2 else 2, faces), (3, 5, 11 if order == 2 else 4, solids)):
        out += ints(dim, tag, kind) + sizes(len(rows)) + end
        for row in rows:
            number += 1
            out += sizes(number, *[10 * (x + 2) for x in row]) + end
    return out + b"\n$EndElements\n"


for order in (1, 2):
    for binary in (0, 1):
        tail = "p%d%s.msh" % (order, "-binary" if binary else "")
        (here / ("brick-22-" + tail)).write_bytes(gmsh22(order, binary))
        (here / ("brick-41-" + tail)).write_bytes(gmsh41(order, binary))

for order, first in ((1, 0), (2, 1)):
    pts = nodes10 if order == 2 else nodes
    rows = tets10["tetgen"] if order == 2 else tets
    stem = here / ("brick-p%d" % order)
    with open(str(stem) + ".node", "w") as f:
        f.write("# brick\n%d 3 0 1\n" % len(pts))
        for i, p in enumerate(pts):
            f.write("%d %r %r %r %d\n" % (i + first, *p, 7 if p[2] == 0 else 0))
    with open(str(stem) + ".ele", "w") as f:
        f.write("%d %d 0\n" % (len(rows), len(rows[0])))
        for i, row in enumerate(rows):
            f.write(" ".join(str(v) for v in [i + first] + [n + first for n in row]) + "\n")


def vtu():
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter as Writer
    for name, order, mode, compressor in (("ascii", 1, "Ascii", None), ("binary-zlib", 2, "Binary", "ZLib"),
                                          ("appended-raw", 2, "Raw", None), ("appended-lzma", 1, "Base64", "LZMA"),
                                          ("appended-lz4", 2, "Raw", "LZ4")):
        grid, points = vtkUnstructuredGrid(), vtkPoints()
        points.SetDataTypeToDouble()
        for p in (nodes10 if order == 2 else nodes) + [unused]:
            points.InsertNextPoint(*p)
        grid.SetPoints(points)
        for row in base6 if order == 2 else base:
            grid.InsertNextCell(22 if order == 2 else 5, len(row), row)
        for row in tets10["vtk"] if order == 2 else tets:
            grid.InsertNextCell(24 if order == 2 else 10, len(row), row)
        writer = Writer()
        writer.SetFileName(str(here / ("brick-%s.vtu" % name)))
        writer.SetInputData(grid)
        if mode == "Ascii":
            writer.SetDataModeToAscii()
        elif mode == "Binary":
            writer.SetDataModeToBinary()
        else:
            writer.SetDataModeToAppended()
            writer.SetEncodeAppendedData(mode == "Base64")
        getattr(writer, "SetCompressorTypeTo" + (compressor or "None"))()
        writer.Write()


vtu()
