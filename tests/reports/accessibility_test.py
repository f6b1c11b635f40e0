#!/usr/bin/env python3
"""Pages by axe-core in a browser: accessibility_test.py KLANG ROOT [FOLDER_TO_KEEP [KIND...]]

One page of each kind is made by the program. At 1400 and at 390 px axe-core must find no violation of WCAG 2.1 AA, with every fold open, and the page
must not be wider than the screen. A page that lacks a name for its pictures must be found, so that the test can fail. axe-core 4.10.3 stands in axe/
(MPL-2.0, as npm has it).
"""
import html
import json
import math
import os
import pathlib
import re
import shlex
import struct
import subprocess
import sys
import tempfile
import wave

RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]
JUDGE = """addEventListener("load", async function () {
  document.querySelectorAll("details").forEach(function (fold) { fold.open = true; });
  const found = await axe.run(document, { runOnly: %s, resultTypes: ["violations"] });
  parent.postMessage(JSON.stringify({
    wide: document.documentElement.scrollWidth - document.documentElement.clientWidth, width: innerWidth, passes: found.passes.length,
    violations: found.violations.map(function (v) {
      return v.id + ": " + v.nodes.length + " at " + v.nodes.slice(0, 3).map(function (n) { return n.target.join(" "); }).join("; "); }) }), "*");
});""" % json.dumps(RULES)
# In a frame, since a window cannot be narrower than 500 px.
FRAME = """<!doctype html><title>frame</title><script>addEventListener("message", function (said) {
  document.body.appendChild(document.createElement("pre")).textContent = "VERDICT" + said.data + "TCIDREV"; });</script>
<body style="margin:0">"""

ROD = "--shape rod --dims length_m=0.2,radius_m=0.005"
# Each with the folder of its page.
COMMANDS = [
    ("fit", "fit datasets-synthetic/tables/s02_chimes.toml -o fit --no-pictures"),
    ("chime", "chime fit/fit.json --notes 'D5 A5' -o chime"),
    ("", f"modes {ROD} --count 6 --json modes.json"),
    ("modes", "report modes.json --no-pictures"),
    ("analysis", "analyze tap.wav -o analysis"),
    ("iet", "iet bars.csv -o iet"),
    ("study", "converge multipole --levels 3 --no-pictures -o study"),
    ("papers", "validate papers -o papers"),
    ("", "regress make tap.wav -o reference.json"),
    ("regression", "regress check reference.json tap.wav -o regression"),
    ("scene", "scene run scene.toml -o scene"),
    ("liquid", "scene run pool.toml -o liquid"),
    ("", "dataset datasets-synthetic/recipes/drops.toml -o drops"),
    ("bubbles", "bubble fit drops/drip-1.wav -o bubbles"),
    ("", "proxy build --no-radiation --thinnest 0.6 --tolerance 0.05 --degree 8 --check-shapes 20 -o a.bank"),
    ("", "modes --shape box --dims length_m=0.16,width_m=0.13,height_m=0.1 --max-edge-m 0.05 --no-mesh-error"
         " --material youngs_modulus_pa=6.2e10,poissons_ratio=0.2,density_kg_m3=2600 --count 8 -o box.vtu"),
    ("proxy", "proxy fit a.bank box.vtu -o proxy --duration-s 0.1 --generations 1"),
]
# A bar that falls; a pool with a bubble and a patch that makes more.
SCENE = """duration_s = 0.4
[world.floor]
material = "steel"
[[material]]
name = "steel"
preset = "steel"
restitution = 0.6
damping = { model = "loss_factor", loss_factor = 2e-3 }
[[body]]
name = "bar"
shape = { kind = "box", length_m = 0.2, width_m = 0.04, height_m = 0.01 }
material = "steel"
max_edge_m = 0.02
position_m = [0, 0, 0.1]
rotation_deg = [8, 5, 0]
[sound]
band_hz = [20, 4000]
"""
POOL = """name = "pool"
[domain]
size_m = [0.12, 0.12, 0.12]
cell_m = 0.02
duration_s = 0.1
[[pool]]
depth_m = 0.08
[[bubble]]
radius_m = 0.003
position_m = [0.06, 0.06, 0.04]
birth_s = 0.01
[listener]
position_m = [0.06, -0.5, 0.3]
[entrainment]
attempts_per_m2_s = 1e5
coverage = 0
radii = { kind = "gaussian", mean_m = 0.002, std_m = 0.0005, smallest_m = 0.001, largest_m = 0.003 }
[[entrainment.patch]]
low_m = [0.02, 0.02, 0.06]
high_m = [0.1, 0.1, 0.1]
start_s = 0.0
end_s = 0.1
"""


WIDTHS_PX = (1400, 390)


def verdicts(axe, text, folder):
    """What was found, by the width that was asked for."""
    at = text.rfind("</body>")
    (folder / "judged.html").write_text(f"{text[:at]}<script>{axe}</script><script>{JUDGE}</script>{text[at:]}")
    frames = "".join(f'<iframe title="{width}" src="judged.html" style="width:{width}px;height:900px;border:0"></iframe>' for width in WIDTHS_PX)
    (folder / "frame.html").write_text(FRAME + frames)
    ran = subprocess.run(
        ["timeout", "280", "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-dev-shm-usage",
         f"--user-data-dir={folder}/profile", "--window-size=2000,1000", "--virtual-time-budget=60000", "--dump-dom",
         f"file://{folder}/frame.html"], capture_output=True, text=True, check=False)
    found = [json.loads(html.unescape(text)) for text in re.findall(r"VERDICT(\{.*?\})TCIDREV", ran.stdout, re.S)]
    return {seen["width"]: seen for seen in found}


def complaints(axe, text, name, folder):
    wrong = []
    found = verdicts(axe, text, folder)
    for width in WIDTHS_PX:
        seen = found.get(width)
        if seen is None or seen["passes"] < 10:
            wrong.append(f"{name} at {width} px: was not judged: {seen}")
            continue
        wrong += [f"{name} at {width} px: {violation}" for violation in seen["violations"]]
        if seen["wide"] > 0:
            wrong.append(f"{name} at {width} px: {seen['wide']} px wider than the screen")
    return wrong


def write_tap(path, partials_hz):
    """50 ms of silence, then partials that decay by 20 per second."""
    rate = 44100
    samples = [0] * (rate // 20)
    for i in range(rate):
        t = i / rate
        samples.append(round(6000 * math.exp(-20 * t) * sum(math.sin(2 * math.pi * f * t) for f in partials_hz)))
    with wave.open(str(path), "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(rate)
        out.writeframes(struct.pack(f"<{len(samples)}h", *samples))


def main():
    kinds = sys.argv[4:]
    klang, root = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    axe = (root / "tests/reports/axe/axe.min.js").read_text()
    wrong = []
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else scratch).resolve()
        folder.mkdir(exist_ok=True)
        if not (folder / "datasets-synthetic").exists():
            os.symlink(root / "datasets-synthetic", folder / "datasets-synthetic")
        write_tap(folder / "tap.wav", [700.0, 1930.0])
        write_tap(folder / "bar.wav", [3160.0])
        (folder / "scene.toml").write_text(SCENE)
        (folder / "pool.toml").write_text(POOL)
        (folder / "bars.csv").write_text("specimen,shape,length_m,width_m,thickness_m,mass_kg,recording,operator,date\n"
                                         "one,bar,0.1,0.02,0.006,0.0942,bar.wav,A. Tester,2026-11-27\n")
        last = ""
        for name, command in COMMANDS:
            if kinds and name and name not in kinds:
                continue
            ran = subprocess.run([klang, *shlex.split(command), "--quiet"], cwd=folder, capture_output=True, text=True, check=False)
            if ran.returncode not in (0, 1):
                wrong.append(f"klang {command}: exit {ran.returncode}: {ran.stderr.strip()}")
            elif name:
                page = folder / name / "report.html"
                last = (page if page.exists() else folder / "report.html").read_text()
                found = complaints(axe, last, name, folder)
                print(f"{name}: {len(found)} complaints", flush=True)
                wrong += found
        # What must be found: a picture without a name, and a line that does not wrap.
        spoilt = last.replace("</main>", '<img src="data:,"><p style="white-space:nowrap">' + "wide " * 200 + "</p></main>")
        found = " ".join(complaints(axe, spoilt, "spoilt", folder))
        if "image-alt" not in found or "wider than the screen" not in found:
            wrong.append(f"a spoilt page was not found to be one: {found}")
    print("\n".join(wrong) if wrong else "accessibility: every page passes")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
