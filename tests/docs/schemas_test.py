#!/usr/bin/env python3
"""What klang writes keeps to docs/schema: schemas_test.py KLANG ROOT

Every schema is one itself and asks for its kind; results of quick commands hold, with every key that they have described; the same
without its kind or of another kind does not.
"""
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import wave

import jsonschema

TUBE = "--shape tube --dims length_m=0.1,outer_radius_m=0.0125,wall_m=0.002"
QUICK = {
    "modes": f"modes {TUBE} --count 2",
    "tune": "tune --shape tube --dims length_m=0.505,outer_radius_m=0.0125,wall_m=0.001 --vary length_m --target 0=587.33",
    "analysis": "analyze tap.wav --bell",
}


def write_tap(path):
    rate = 16000
    samples = [0.4 * math.exp(-8 * i / rate) * math.sin(2 * math.pi * 880 * i / rate) for i in range(rate)]
    with wave.open(str(path), "wb") as sound:
        sound.setnchannels(1)
        sound.setsampwidth(2)
        sound.setframerate(rate)
        sound.writeframes(b"".join(struct.pack("<h", round(32767 * s)) for s in samples))


def undescribed(value, schema, place=""):
    """Keys of a value that its schema does not name."""
    if isinstance(value, dict) and "properties" in schema:
        for key, inner in value.items():
            if key in schema["properties"]:
                yield from undescribed(inner, schema["properties"][key], f"{place}.{key}")
            else:
                yield f"{place}.{key}"
    elif isinstance(value, list) and "items" in schema:
        for inner in value:
            yield from undescribed(inner, schema["items"], place + "[]")


def main():
    klang, root = sys.argv[1], pathlib.Path(sys.argv[2])
    faults = []
    schemas = {}
    for file in sorted((root / "docs/schema").glob("*.schema.json")):
        schema = json.loads(file.read_text())
        jsonschema.Draft202012Validator.check_schema(schema)
        kind = file.name.removesuffix(".schema.json")
        if "kind" not in schema["required"] or schema["properties"]["kind"]["const"] != kind:
            faults.append(f"{file.name} does not ask for its kind")
        schemas[kind] = jsonschema.Draft202012Validator(schema)
    with tempfile.TemporaryDirectory() as folder:
        write_tap(pathlib.Path(folder, "tap.wav"))
        for kind, command in QUICK.items():
            subprocess.run([klang, *command.split(), "--quiet", "--json", "result.json"], cwd=folder, check=True)
            result = json.loads(pathlib.Path(folder, "result.json").read_text())
            faults += [f"{kind}: {error.json_path}: {error.message}" for error in schemas[kind].iter_errors(result)]
            faults += [f"{kind}: {key} is not described" for key in undescribed(result, schemas[kind].schema)]
            for broken in ({k: v for k, v in result.items() if k != "kind"}, {**result, "kind": "other"}):
                if schemas[kind].is_valid(broken):
                    faults.append(f"{kind}: a result without its kind is taken")
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
