#!/usr/bin/env python3
"""Seeds for the fuzz targets: fuzz_seeds.py FOLDER writes FOLDER/{mesh,model,table}/... The first byte of each is its format's number, as
tests/fuzz/{mesh,model,table}_fuzz.cpp count them. (sound and toml take files as they are.)"""
import hashlib
import json
import lzma
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import attack_files  # noqa: E402
import attack_liquids  # noqa: E402

MESH = {"stl": 0, "obj": 1, "ply": 2, "off": 3, "tetgen": 4, "profile": 5, ".msh": 6, ".vtu": 7}
TRACKED = pathlib.Path(__file__).resolve().parents[2] / "tests/fuzz/seeds/tracked"
LIQUID = pathlib.Path(__file__).resolve().parents[2] / "tests/fuzz/seeds/liquid.vdb"  # a box of 4 x 3 x 4 cells from klang scene export
TET = ('<VTKFile type="UnstructuredGrid" byte_order="LittleEndian"><UnstructuredGrid><FieldData>{fields}</FieldData><Piece NumberOfPoints='
       '"{n}" NumberOfCells="{cells}"><PointData>{data}</PointData><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">'
       '{points}</DataArray></Points><Cells><DataArray type="Int64" Name="connectivity" format="ascii">{corners}</DataArray><DataArray '
       'type="Int64" Name="offsets" format="ascii">{offsets}</DataArray><DataArray type="UInt8" Name="types" format="ascii">{types}'
       "</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>")


def numbers(name, values, kind="Float64"):
    return (f'<DataArray type="{kind}" Name="{name}" NumberOfTuples="{len(values)}" format="ascii">'
            + " ".join(map(str, values)) + "</DataArray>")


def text(name, value):
    return (f'<Array type="String" Name="{name}" NumberOfTuples="1" format="ascii">'
            + " ".join(str(b) for b in value.encode() + b"\0") + "</Array>")


def modal():
    fields = (numbers("klang_modal_model", [1], "Int32") + numbers("frequencies_hz", [159.15]) + numbers("angular_frequency_rad_s", [1000.0])
              + numbers("lame_lambda_pa", [5e10]) + numbers("lame_mu_pa", [2.6e10]) + numbers("density_kg_m3", [2700.0])
              + text("material_name", "a") + text("material_source", "b") + text("support", "free") + text("provenance_json", "{}"))
    shape = ('<DataArray type="Float64" Name="mode_0000" NumberOfComponents="3" format="ascii">1 0 0 0 1 0 0 0 1 1 1 1</DataArray>')
    return TET.format(fields=fields, n=4, cells=1, data=shape, points="0 0 0 1 0 0 0 1 0 0 0 1", corners="0 1 2 3", offsets="4", types="10")


def transfer():
    fields = (numbers("klang_transfer_model", [1], "Int32") + numbers("coefficients_pa", [1.0, 0.5]) + numbers("density_kg_m3", [1.2])
              + numbers("sound_speed_m_s", [343.0]) + text("provenance_json", "{}"))
    data = "".join(numbers(n, [v]) for n, v in (("frequency_hz", 159.15), ("wavenumber_per_m", 2.9), ("radiated_power_w", 1e-3),
                                                ("decay_radiation_per_s", 0.1), ("kept_power_fraction", 1.0), ("residual", 0.0)))
    data += "".join(numbers(n, [v], "Int32") for n, v in (("mode", 0), ("order", 0), ("n_bem_elements", 100), ("has_residual", 1)))
    return TET.format(fields=fields, n=1, cells=1, data=data, points="0 0 0", corners="0", offsets="1", types="1")


def bank():
    """One triangle, one cell, one mode of degree 3, class 0 without sound (core/sound/soundbank/soundbank_file.cpp)."""
    mu, lame = 2.583333333333333e10, 1.7222222222222222e10
    data = struct.pack("<8d", lame / (2 * (lame + mu)), lame, mu, 2600.0, 1.2, 343.0, 0.5, 0.05)
    data += struct.pack("<i2d3i", 1, 0.01, 0.01, 0, 1, 3)
    corners = [(-0.69, 0.0), (0.0, 0.0), (-0.69, -0.69), (-0.34, -0.34), (-0.69, -0.34), (-0.34, 0.0)]
    data += struct.pack("<Q", 6) + b"".join(struct.pack("<2d", *p) for p in corners)
    data += struct.pack("<Q", 6) + (struct.pack("<Q", 2) + struct.pack("<2d", 1.5, 2.5)) * 8 * 6
    data += struct.pack("<Q", 1) + struct.pack("<8i", 0, 1, 2, 3, 4, 5, -1, -1)
    n = sum(1 for a in range(3) for i in range(4) for j in range(4 - i) for k in range(4 - i - j)
            if [i & 1, j & 1, k & 1] == [int(a == b) for b in range(3)])
    mode = struct.pack("<2id", 0, 0, 20000.0) + struct.pack("<Q", n) + struct.pack(f"<{n}f", *[0.1] * n)
    mode += struct.pack("<iQ3d", 0, 0, 0.0, 0.0, 0.0)
    return data + struct.pack("<Q", 1) + struct.pack("<2d", -0.3, -0.2) + struct.pack("<Q", 1) + mode


def documents():
    head = {"schema_version": 1, "status": "ok", "warnings": [], "provenance": {"command": "klang", "seed": 1, "version": "0", "options": {},
                                                                                "inputs": []}}
    for number, kind in enumerate(("fit", "analysis", "modes", "study", "regression", "bubbles", "proxy_fit", "tune")):
        yield number, json.dumps({**head, "kind": kind})
    for file in sorted((pathlib.Path(__file__).resolve().parents[2] / "tests" / "attack").glob("report-json__*/*.json")):
        kind = json.loads(file.read_text())["kind"]
        yield {"analysis": 1, "study": 3, "regression": 4, "fit": 0}[kind], file.read_text()
    yield 9, json.dumps({"kind": "reference_spectrum", "schema_version": 1, "origin": "a", "n_takes": 1, "scatter_dof": 1, "sample_rate_hz": 48000})
    yield 10, json.dumps({"partials": [{"frequency_hz": 440, "decay_per_s": 3, "amplitude": 0.1}]})
    yield 11, attack_files.PARTIALS
    yield 12, "time_s,x_m,phi_m\n0,0,-1\n0.1,1,-1\n0.2,2,-1\n"
    yield 13, json.dumps({"transfer": [{"time_s": 0, "re": 1, "im": 0}, {"time_s": 1, "re": 1, "im": 0}]})
    yield 14, "time_s,x_m,y_m,z_m\n0,0,1,0\n1,0,2,0\n"


def seeds():
    """(target, format, name, bytes)"""
    for kind, name, data in attack_files.surfaces():
        yield "mesh", MESH[kind.split("-")[0]], kind, data
    for file in sorted(attack_files.DATA.iterdir()):
        if file.suffix in MESH:
            yield "mesh", MESH[file.suffix], file.name, file.read_bytes()
        elif file.suffix == ".node":
            yield "mesh", MESH["tetgen"], file.name, file.read_bytes() + b"\0" + file.with_suffix(".ele").read_bytes()
    yield "mesh", MESH["profile"], "profile", attack_files.PROFILE
    vtp = attack_files.boundary(1)
    obj = next(data for kind, _, data in attack_files.surfaces() if kind == "obj")
    pvd = '<VTKFile type="Collection"><Collection><DataSet timestep="0" file="a.vtp"/><DataSet timestep="1" file="b.vtp"/></Collection></VTKFile>'
    data = bank()
    header = json.dumps({"kind": "soundbank", "data_sha256": hashlib.sha256(data).hexdigest()}).encode()
    for number, value in enumerate((vtp, modal(), "g region_1\n" + obj, pvd, modal(), transfer(), attack_files.bank_file(1, header, data), data)):
        yield "model", number, str(number), value
    for number, value in documents():
        yield "table", number, str(number), value
    for number, name, value in ((15, "frf", universal(4)), (15, "decay", universal(1)), (16, "mat", matlab()),
                                (17, "tracked", attack_liquids.TRACKED), (18, "tracked-xz", lzma.compress(attack_liquids.TRACKED.encode())),
                                (19, "vdb", LIQUID.read_bytes()), (20, "openfoam", foam_case())):
        yield "table", number, name, value
    for file in sorted(TRACKED.glob("*.trk")):  # plain, and as .xz
        yield "table", 17, file.stem, file.read_bytes()
        yield "table", 18, file.stem, lzma.compress(file.read_bytes())


def foam_case():
    """The files of a case in the order of tests/fuzz/table_fuzz.cpp, a byte 30 between them."""
    files = attack_liquids.openfoam_case()
    mesh = [f"constant/polyMesh/{name}" for name in ("points", "faces", "owner", "neighbour", "boundary")]
    return b"\x1e".join(files[name] for name in ("system/controlDict", *mesh, "0/alpha.water", "0.01/alpha.water"))


def universal(kind, n=16):
    """Dataset 58 of one response, text: a frequency response (4) or a free decay (1); with a node."""
    frf = kind == 4
    values = "".join(f"{(-1) ** i / (1 + i):20.11e}{0.5 / (1 + i) if frf else 0.1:20.11e}\n" for i in range(n))
    nodes = "    -1\n    15\n" + "%10d%10d%10d%10d%13.5e%13.5e%13.5e\n" % (1, 0, 0, 8, 0, 0.1, 0) + "    -1\n"
    return (nodes + "    -1\n    58\nNONE\nNONE\nNONE\nNONE\nNONE\n"
            + "%5d%10d%5d%10d %10s%10d%4d %10s%10d%4d\n" % (kind, 0, 0, 0, "NONE", 1, 3, "NONE", 1, 3)
            + "%10d%10d%10d%13.5e%13.5e%13.5e\n" % (6 if frf else 4, n if frf else 2 * n, 1, 0, 0.5, 0)
            + "%10d    0    0    0 NONE                 NONE\n" % (18 if frf else 17)
            + "        12    0    0    0 NONE                 m/s^2\n        13    0    0    0 NONE                 N\n"
            + "         0    0    0    0 NONE                 NONE\n" + values + "    -1\n")


def matlab():
    """A MATLAB 5 file of time_s, response and unit."""
    def element(kind, data):
        return struct.pack("<2I", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    def variable(name, matlab_class, kind, dims, data):
        body = (element(6, struct.pack("<2I", matlab_class, 0)) + element(5, struct.pack("<2i", *dims)) + element(1, name.encode())
                + element(kind, data))
        return struct.pack("<2I", 14, len(body)) + body

    times, values = [0.01 * i for i in range(16)], [(-0.9) ** i for i in range(16)]
    return (b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM"
            + variable("time_s", 6, 9, (1, 16), struct.pack("<16d", *times))
            + variable("response", 6, 9, (1, 16), struct.pack("<16d", *values))
            + variable("unit", 4, 4, (1, 5), struct.pack("<5H", *map(ord, "m/s^2"))))


def main():
    for target, number, name, data in seeds():
        folder = pathlib.Path(sys.argv[1]) / target
        folder.mkdir(parents=True, exist_ok=True)
        data = data.encode() if isinstance(data, str) else data
        (folder / f"{number}-{name}-{len(data)}").write_bytes(bytes([number]) + data)


if __name__ == "__main__":
    main()
