"""Files for tools/attack: valid ones of every kind, what is done to them, and large broken ones that are made, not kept."""
import hashlib
import json
import math
import pathlib
import random
import re
import shlex
import struct
import subprocess
import wave
import zlib

import attack_liquids

DATA = pathlib.Path(__file__).resolve().parents[2] / "tests" / "data" / "mesh"
RECIPES = pathlib.Path(__file__).resolve().parents[2] / "datasets-synthetic" / "recipes"


def bank_file(version, header, data):
    packed = zlib.compress(data, 6)
    return b"KLBANK\r\n" + struct.pack("<IQQQ", version, len(header), len(packed), len(data)) + header + packed


class Bank:
    """Container of a soundbank: "KLBANK\\r\\n", version, three sizes, JSON header, zlib data."""
    small = None  # where the small one is kept once it is made

    def __init__(self, data):
        version, *sizes = struct.unpack("<IQQQ", data[8:36])
        self.version = version
        self.header = json.loads(data[36:36 + sizes[0]])
        self.data = bytearray(zlib.decompress(data[36 + sizes[0]:]))

    def packed(self, header_text=None):
        self.header["data_sha256"] = hashlib.sha256(self.data).hexdigest()
        return bank_file(self.version, header_text if header_text is not None else json.dumps(self.header).encode(), bytes(self.data))

    @classmethod
    def of(cls, klang):
        if not cls.small.exists():
            subprocess.run([klang, "proxy", "build", "--no-radiation", "--thinnest", "0.6", "--tolerance", "0.05", "--degree", "8",
                            "--check-shapes", "20", "--quiet", "-o", str(cls.small)], check=True)
        return cls(cls.small.read_bytes())


DEGREE_AT = 8 * 6 + 8 * 2 + 4 + 8 * 2 + 4 + 4  # of the polynomials, in a bank's data


def make(recipe, klang, folder):
    """Makes the large file that a case names in its line make."""
    word, _, rest = recipe.partition(" ")
    if word == "bank":
        bank = Bank.of(klang)
        what, _, value = rest.partition("=")
        header = None
        if what == "degree":
            bank.data[DEGREE_AT:DEGREE_AT + 4] = struct.pack("<i", int(value))
        elif what == "index":  # of the first cell's first mode
            number = first_mode_at(bank.data)
            bank.data[number + 4:number + 8] = struct.pack("<i", int(value))
        elif what == "kind":
            bank.header["kind"] = int(value)
        elif what == "zeros":
            bank.data = bytearray(int(value))
        elif what == "deep":
            header = b'{"kind":"soundbank","provenance":' + b"[" * int(value) + b"]" * int(value) + b"}"
        (folder / "x.bank").write_bytes(bank.packed(header))
    elif word == "modal":
        modal_model(klang, folder / "m.vtu")
        data = (folder / "m.vtu").read_bytes()
        if rest == "header":
            data = data.replace(b'header_type="UInt32"', b'header_type="UInt64"', 1)
        elif rest == "shape":
            data = changed_array(data, b'Name="mode_0000"', struct.pack("<d", 1e300))
        (folder / "m.vtu").write_bytes(data)
    elif word == "deep-json":
        n = int(rest)
        (folder / "fit.json").write_text('{"kind":"fit","schema_version":1,"status":"converged","provenance":{"options":'
                                         + '{"a":' * n + "1" + "}" * n + "}}")
    elif word == "deep-toml":
        line, _, n = rest.rpartition(" ")
        (folder / "s.toml").write_text(line.replace("DEEP", ".".join("a" * int(n))) + "\n")
    elif word == "deep-xml":
        text = (DATA / "brick-ascii.vtu").read_text()
        (folder / "x.vtu").write_text(text.replace("<PointData>", "<a>" * int(rest) + "<PointData>"))
    else:
        raise SystemExit(f"tools/attack: nothing makes {recipe!r}")


def first_mode_at(data):
    """Offset of the first mode (class, index, frequency, ...) of the first cell in a bank's data."""
    at = DEGREE_AT + 4

    def count():
        nonlocal at
        n = struct.unpack_from("<Q", data, at)[0]
        at += 8
        return n

    def skip(n_bytes_each):
        nonlocal at
        n = count()
        at += n * n_bytes_each

    skip(16)
    for _ in range(count()):
        for _ in range(8):
            skip(8)
    skip(32)
    assert count() > 0
    at += 16
    assert count() > 0
    return at


def modal_model(klang, path):
    subprocess.run([klang, "modes", "--shape", "box", "--dims", "length_m=0.2,width_m=0.15,height_m=0.1", "--element", "p1", "--max-edge-m",
                    "0.1", "--count", "4", "--no-mesh-error", "-q", "-o", str(path)], check=True)


def changed_array(data, name, number):
    """A raw appended array with another first number."""
    at = data.index(name)
    offset = int(re.search(rb'offset="(\d+)', data[at:]).group(1))
    begin = data.index(b"_", data.index(b"<AppendedData")) + 1 + offset + 4
    return data[:begin] + number + data[begin + len(number):]


CUBE = [(x, y, z) for z in (0, 0.1) for x, y in ((0, 0), (0.1, 0), (0.1, 0.1), (0, 0.1))]
FACES = [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4),
         (3, 4, 7)]


def surfaces():
    points = "\n".join(" ".join(map(str, p)) for p in CUBE)
    yield "off", "x.off", f"OFF\n8 12 0\n{points}\n" + "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
    yield "obj", "x.obj", "".join(f"v {x} {y} {z}\n" for x, y, z in CUBE) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in FACES)
    head = ("ply\nformat {} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 12\n"
            "property list uchar int vertex_indices\nend_header\n")
    yield "ply", "x.ply", head.format("ascii") + points + "\n" + "".join(f"3 {a} {b} {c}\n" for a, b, c in FACES)
    yield "ply-binary", "x.ply", (head.format("binary_little_endian").encode() + b"".join(struct.pack("<3f", *p) for p in CUBE)
                                  + b"".join(struct.pack("<B3i", 3, *f) for f in FACES))
    yield "stl", "x.stl", "solid a\n" + "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*CUBE[i]) for i in f) + "endloop\nendfacet\n"
        for f in FACES) + "endsolid a\n"
    yield "stl-binary", "x.stl", bytes(80) + struct.pack("<I", 12) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for i in f for x in CUBE[i]), 0) for f in FACES)


def box_surface(n):
    """A box of 0.1 m, n squares along each edge: points, triangles, regions (0 on top, 1 elsewhere)."""
    points, triangles, regions = [], [], []
    for axis in range(3):
        for side in (0, 1):
            first = len(points)
            u, v = ((axis + 1) % 3, (axis + 2) % 3) if side else ((axis + 2) % 3, (axis + 1) % 3)
            for i in range(n + 1):
                for j in range(n + 1):
                    point = [0.1 * side] * 3
                    point[u], point[v] = 0.1 * i / n, 0.1 * j / n
                    points.append(point)
            for i in range(n):
                for j in range(n):
                    at = [first + (i + di) * (n + 1) + j + dj for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
                    triangles += [(at[0], at[1], at[2]), (at[0], at[2], at[3])]
                    regions += [0 if axis == 2 and side else 1] * 2
    return points, triangles, regions


def boundary(n=3):
    points, triangles, regions = box_surface(n)
    numbers = " ".join(f"{x:.6g}" for p in points for x in p)
    corners = " ".join(str(i) for t in triangles for i in t)
    offsets = " ".join(str(3 * i) for i in range(1, len(triangles) + 1))
    return (f'<?xml version="1.0"?><VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"><PolyData><Piece NumberOfPoints="{len(points)}" '
            f'NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{len(triangles)}"><Points><DataArray type="Float64" '
            f'NumberOfComponents="3" format="ascii">{numbers}</DataArray></Points><CellData><DataArray type="Int32" Name="region" '
            f'format="ascii">{" ".join(map(str, regions))}</DataArray></CellData><Polys><DataArray type="Int64" Name="connectivity" '
            f'format="ascii">{corners}</DataArray><DataArray type="Int64" Name="offsets" format="ascii">{offsets}</DataArray></Polys>'
            "</Piece></PolyData></VTKFile>")


def struck_sound(path):
    rate, n = 16000, 16000
    frames = bytearray()
    for i in range(n):
        t = (i - 1600) / rate
        y = 0.0 if t < 0 else sum(a * math.exp(-d * t) * math.sin(2 * math.pi * f * t)
                                  for a, d, f in ((0.4, 6, 523.0), (0.2, 9, 1441.0), (0.1, 14, 2824.0)))
        frames += struct.pack("<h", round(32767 * y))
    with wave.open(str(path), "wb") as out:
        out.setparams((1, 2, rate, n, "NONE", ""))
        out.writeframes(bytes(frames))


SCENE = """[sound]
sample_rate_hz = 8000
[[bubble]]
radius_m = 0.002
position_m = [0, 0, -0.02]
rise = "terminal"
[[bubble]]
radius_m = 0.003
birth_s = 0.05
path_csv = "path.csv"
[[population]]
count = 20
time_end_s = 0.2
box_low_m = [-0.1, -0.1, -0.1]
box_high_m = [0.1, 0.1, -0.05]
"""
SPECIMEN = """name = "bar"
[fit]
band_hz = [100, 4000]
[material]
youngs_modulus_pa = 70e9
poissons_ratio = 0.33
density_kg_m3 = 2700
[[specimen]]
name = "bar"
shape = { kind = "rod", length_m = 0.3, radius_m = 0.006 }
recordings = ["x.wav"]
"""
LISTENER = "time_s,x_m,y_m,z_m\n0,0,1,1\n0.1,0.1,1,1\n0.2,0.2,1,1\n"
PROFILE = "r_m,z_m\n0,0\n0.05,0\n0.05,0.02\n0.03,0.03\n0,0.03\n"
PATH = "time_s,x_m,y_m,z_m\n" + "".join(f"{i * 0.01},0,0,{-0.05 + 0.001 * i}\n" for i in range(30))
PARTIALS = "frequency_hz,frequency_std_hz,decay_per_s,decay_std_per_s,amplitude\n523,0.1,6,0.1,0.4\n1441,0.2,9,0.2,0.2\n2824,0.4,14,0.4,0.1\n"


def bases(klang, folder, only):
    """Kind: (files by name, the one that is broken, command). All are valid."""
    folder.mkdir()

    def klang_run(command):
        subprocess.run([klang, *shlex.split(command)], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    found = {}
    for file in sorted(DATA.iterdir()):
        if file.suffix in (".vtu", ".msh"):
            found["mesh-" + file.stem + file.suffix] = ({"x" + file.suffix: file.read_bytes()}, "x" + file.suffix,
                                                        f"mesh x{file.suffix} -o out.msh --json m.json")
    tetgen = {"x" + s: (DATA / ("brick-p2" + s)).read_bytes() for s in (".node", ".ele")}
    for name in tetgen:
        found["tetgen-" + name] = (tetgen, name, "mesh x.node -o out.vtu --json m.json")
    for kind, name, data in surfaces():
        found["surface-" + kind] = ({name: data if isinstance(data, bytes) else data.encode()}, name,
                                    f"mesh {name} -o out.msh --json m.json")
    found["boundary"] = ({"b.vtp": boundary().encode(), "p.csv": b"x_m,y_m,z_m\n0.05,0.05,0.3\n"}, "b.vtp",
                         "bubble transfer --boundary b.vtp --bubble 0.05,0.05,0.06 --frequency-hz 1000 --points p.csv --json j.json -q")
    found["points"] = (found["boundary"][0], "p.csv", found["boundary"][2])
    struck_sound(folder / "x.wav")
    wav = {"x.wav": (folder / "x.wav").read_bytes()}
    modal_model(klang, folder / "m.vtu")
    model = {"m.vtu": (folder / "m.vtu").read_bytes()}
    synth = "synth m.vtu -o o.wav --strike time_s=0.01,x_m=0.1,y_m=0.07,z_m=0.05,fz_n_s=0.1 --rayleigh-mass-per-s 10 --duration-s 0.2 --json s.json"
    found["modal-synth"] = (model, "m.vtu", synth)
    found["modal-transfer"] = (model, "m.vtu", "transfer m.vtu -o o.vtu -q --max-elements 400 --allow-coarse")
    klang_run("transfer m.vtu -o t.vtu -q --max-elements 400 --allow-coarse")
    found["transfer"] = ({**model, "t.vtu": (folder / "t.vtu").read_bytes(), "l.csv": LISTENER.encode()}, "t.vtu",
                         synth + " --transfer t.vtu --listener l.csv")
    found["listener"] = (found["transfer"][0], "l.csv", found["transfer"][2])
    bank = Bank.of(klang).packed()
    found["bank"] = ({"x.bank": bank}, "x.bank", "proxy info x.bank --json i.json")
    found["bank-lookup"] = ({"x.bank": bank}, "x.bank", "proxy lookup x.bank --inertia 1.64,1.36,1.0 --lowest-frequency-hz 5200 --json l.json")
    found["scene"] = ({"s.toml": SCENE.encode(), "path.csv": PATH.encode()}, "s.toml", "bubble synth s.toml -o o.wav --json j.json -q")
    found["path"] = (found["scene"][0], "path.csv", found["scene"][2])
    found["specimen"] = ({"s.toml": SPECIMEN.encode(), **wav}, "s.toml", "fit s.toml -o out -q")
    found["profile"] = ({"p.csv": PROFILE.encode()}, "p.csv", "mesh revolution --profile p.csv --max-edge-m 0.02 -o out.vtu --json m.json")
    for recipe in ("tile", "drops", "beating_pair"):
        found["recipe-" + recipe] = ({"r.toml": (RECIPES / f"{recipe}.toml").read_bytes()}, "r.toml", "dataset r.toml -o out -q")
    found["sound"] = (wav, "x.wav", "analyze x.wav --json a.json -q")
    for name, command in (("analysis.json", "analyze x.wav -o analysis -q"), ("modes.json", "modes --shape box --dims length_m=0.2,width_m=0.15,"
                          "height_m=0.1 --element p1 --max-edge-m 0.1 --count 4 -q --json modes.json"),
                          ("study.json", "converge synthesis -o study -q"), ("reference.json", "regress make x.wav -o reference.json -q"),
                          ("regression.json", "regress check reference.json x.wav -o regression -q")):
        try:
            klang_run(command)
        except subprocess.CalledProcessError:
            continue
        file = next((f for f in (folder / name, folder / name[:-5] / name) if f.exists()), None)
        if file is None or name == "reference.json":
            continue
        found["report-" + name[:-5]] = ({name: file.read_bytes()}, name, f"report {name} --no-pictures -q")
    if (folder / "reference.json").exists():
        found["reference"] = ({**wav, "r.json": (folder / "reference.json").read_bytes()}, "r.json", "regress check r.json x.wav --json c.json -q")

    def klang_did(command):
        try:
            klang_run(command)
        except subprocess.CalledProcessError:
            return False
        return True

    found.update(attack_liquids.bases(klang_did, folder))
    return {kind: base for kind, base in found.items() if only in kind}


ABSURD = ["0", "-1", "1", "1e300", "-1e300", "1e-300", "nan", "inf", "-inf", "2147483648", "4294967295", "999999999999", "1000000000",
          "0.5", "", "1e9", "-2147483649", "18446744073709551615", "x", "1e400", "65536", "100000"]
NUMBER = re.compile(rb"(?<![\w.])-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
DEEP = [b"[" * 20000, b'{"a":' * 20000, b"<a>" * 50000, b"a." * 20000, b"[[a]]\n" * 5000, b"(" * 20000, b'"' * 999]


def text_mutation(data, rng):
    what = rng.randrange(10)
    if what == 0:
        return data[:rng.randrange(len(data))]
    if what <= 4:  # other numbers
        numbers = list(NUMBER.finditer(data))
        for _ in range(rng.choice((1, 1, 1, 2, 5))):
            if not numbers:
                break
            match = numbers.pop(rng.randrange(len(numbers)))
            data = data[:match.start()] + rng.choice(ABSURD).encode() + data[match.end():]
            numbers = list(NUMBER.finditer(data))
        return data
    lines = data.splitlines(keepends=True)
    if what == 5 and len(lines) > 1:
        a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
        lines[a], lines[b] = lines[b], lines[a]
        return b"".join(lines)
    if what == 6:  # a part again
        a = rng.randrange(len(data))
        b = min(len(data), a + rng.choice((10, 100, 1000, 10000)))
        return data[:b] + data[a:b] * rng.choice((1, 1, 50)) + data[b:]
    if what == 7:
        a = rng.randrange(len(data))
        return data[:a] + data[a + rng.choice((1, 5, 40, 400)):]
    if what == 8:
        a = rng.randrange(len(data))
        return data[:a] + rng.choice(DEEP) + data[a:]
    return byte_mutation(data, rng)


def byte_mutation(data, rng):
    out = bytearray(data)
    what = rng.randrange(6)
    if what == 0:
        return bytes(out[:rng.randrange(len(out))])
    for _ in range(rng.choice((1, 1, 2, 4, 16))):
        at = rng.randrange(max(1, min(len(out), rng.choice((64, 512, len(out))))))
        if what <= 2:
            out[at] ^= 1 << rng.randrange(8)
        elif what == 3:
            value = rng.choice((0, 0xFFFFFFFF, 0x7FFFFFFF, 0x80000000, 1000000000, 65536))
            out[at:at + 4] = struct.pack("<I", value)[:len(out) - at]
        elif what == 4:
            value = rng.choice((math.nan, math.inf, 1e300, -1e300, 1e-300, 0.0, -1.0))
            out[at:at + 8] = struct.pack("<d", value)[:len(out) - at]
        else:
            del out[at:at + rng.choice((1, 4, 8, 100))]
    return bytes(out)


def json_mutation(data, rng):
    document = json.loads(data)
    for _ in range(rng.choice((1, 1, 2, 4))):
        places = []

        def walk(node):
            for key in (node if isinstance(node, dict) else range(len(node))):
                places.append((node, key))
                if isinstance(node[key], (dict, list)):
                    walk(node[key])

        walk(document)
        if not places:
            break
        node, key = rng.choice(places)
        value = rng.choice((1e300, -1e300, 0, -1, 1e-300, None, "", "x" * 3000, [], {}, True, [[]], 2**31, 2**63, "javascript:alert(1)",
                            "\"'><img src=x onerror=alert(1)>", "../../etc/passwd", "/dev/zero", [1e300] * 3, "\ud800"))
        what = rng.randrange(6)
        if what == 0:
            del node[key]
        elif what == 1 and isinstance(node, list):
            node *= rng.choice((2, 100))
        elif what == 2 and isinstance(node[key], (int, float)) and not isinstance(node[key], bool):
            node[key] = rng.choice((1e300, -1e300, -node[key], 1e308, 5e-324, None, 0))
        else:
            node[key] = value
    return json.dumps(document).encode()


def mutate(base_files, number, seed, work):
    """Writes the files of a run, one of them broken; (kind, command)."""
    rng = random.Random(f"{seed}/{number}")
    kinds = sorted(base_files)
    kind = kinds[number % len(kinds)]
    files, target, command = base_files[kind]
    data = files[target]
    if kind.startswith("bank") and rng.random() < 0.7:
        bank = Bank(data)
        bank.data = bytearray(byte_mutation(bytes(bank.data), rng))
        data = bank.packed()
    elif target.endswith(".json") and rng.random() < 0.7:
        data = json_mutation(data, rng)
    elif b"\0" in data[:4096] or (b"<AppendedData" in data and rng.random() < 0.3):
        data = byte_mutation(data, rng)
    else:
        head = data.find(b"<AppendedData")
        data = text_mutation(data, rng) if head < 0 else text_mutation(data[:head], rng) + data[head:]
    work.mkdir()
    for name, content in files.items():
        (work / name).parent.mkdir(parents=True, exist_ok=True)
        (work / name).write_bytes(data if name == target else content)
    return kind, command
