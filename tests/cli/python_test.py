#!/usr/bin/env python3
"""The Python package gives what the program gives: python_test.py KLANG PACKAGE_FOLDER ROOT"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import warnings

KLANG, PACKAGE, ROOT = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
sys.path.insert(0, PACKAGE)
import numpy as np

import klangprobe

ROD = {"length_m": 0.2, "radius_m": 0.005}
ALUMINIUM = {"youngs_modulus_pa": 7.1e10, "poissons_ratio": 0.33, "density_kg_m3": 2700}


def command(folder, *words):
    subprocess.run([KLANG, *words, "--quiet", "--json", "result.json"], cwd=folder, check=True)
    return json.loads(pathlib.Path(folder, "result.json").read_text())


class Package(unittest.TestCase):
    def setUp(self):
        self.holder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.holder.name)
        self.addCleanup(self.holder.cleanup)

    def test_modes_have_the_digits_of_the_command(self):
        modes = klangprobe.modes("rod", ROD, ALUMINIUM, count=4, threads=1)
        told = command(self.folder, "modes", "--shape", "rod", "--dims", "length_m=0.2,radius_m=0.005", "--count", "4", "--threads", "1",
                       "--material", "youngs_modulus_pa=7.1e10,poissons_ratio=0.33,density_kg_m3=2700")
        self.assertIsInstance(modes.frequency_hz, np.ndarray)
        self.assertEqual(modes.frequency_hz.tolist(), [mode["frequency_hz"] for mode in told["modes"]])

    def test_partials_of_an_array(self):
        rate, t = 16000, np.arange(16000) / 16000
        found = klangprobe.analyze(0.3 * np.exp(-5 * t) * np.cos(2 * np.pi * 440 * t), rate)
        self.assertEqual(len(found.partials), 1)
        self.assertAlmostEqual(found.partials[0].frequency_hz, 440, places=3)
        self.assertEqual(found.partials[0].note, "A4")
        stereo = klangprobe.analyze(np.stack([np.exp(-5 * t) * np.cos(2 * np.pi * 440 * t)] * 2, axis=1), rate)
        self.assertEqual(stereo.data["n_channels"], 2)

    def test_a_fit_and_its_sound(self):
        modes = klangprobe.modes("rod", ROD, ALUMINIUM, count=6).frequency_hz
        rows = [f"{f!r},0.1,{np.pi * f * 1e-3!r},{0.02 * np.pi * f * 1e-3!r}" for f in modes.tolist()]
        (self.folder / "p.csv").write_text("frequency_hz,frequency_std_hz,decay_per_s,decay_std_per_s\n" + "\n".join(rows) + "\n")
        (self.folder / "rod.toml").write_text(
            '[material]\nyoungs_modulus_pa = 7e10\npoissons_ratio = 0.33\ndensity_kg_m3 = 2700\n[[specimen]]\nname = "rod"\n'
            'shape = { kind = "rod", length_m = 0.2, radius_m = 0.005 }\npartials = "p.csv"\n'
            '[fit]\nparameters = ["youngs_modulus_pa"]\n')
        fit = klangprobe.fit(self.folder / "rod.toml")
        told = command(self.folder, "fit", "rod.toml", "-o", "out", "--no-pictures")
        self.assertEqual(fit.parameters["youngs_modulus_pa"].value, told["parameters"][0]["value"])
        self.assertEqual(fit.parameters["youngs_modulus_pa"].std, told["parameters"][0]["std"])
        sound = klangprobe.synth(fit, "rod", 0.5, 44100)
        self.assertEqual(sound.shape, (22050,))
        self.assertAlmostEqual(np.abs(sound).max(), 10 ** (-3 / 20), places=6)
        again = klangprobe.fit(self.folder / "out/fit.json")
        np.testing.assert_array_equal(klangprobe.synth(again, "rod", 0.5, 44100), sound)

    def test_what_the_command_warns_of_is_a_python_warning(self):
        self.assertIsNotNone(klangprobe.modes.__doc__)
        bar, example = re.findall(r">>> (?:bar = )?(.*)", klangprobe.modes.__doc__)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            held = eval(example, {"klangprobe": klangprobe, "bar": eval(bar)})
        # a cantilever of 0.2 m and 5 mm: 3.516 / (2 pi L^2) h sqrt(E / 12 rho), its width and grip aside
        self.assertAlmostEqual(held[0] / 104.44, 1, delta=0.01)
        with self.assertWarnsRegex(UserWarning, "cuts"):
            klangprobe.modes("rod", ROD, ALUMINIUM, count=1, support="clamped:x=0")

    def test_a_bubble(self):
        self.assertEqual(klangprobe.bubble_info(0.001)["damped_frequency_hz"],
                         command(self.folder, "bubble", "info", "--radius-m", "0.001")["damped_frequency_hz"])

    def test_bad_input_is_a_value_error_of_one_line(self):
        (self.folder / "half.json").write_text('{"kind": "fit", ')
        (self.folder / "other.json").write_text('{"kind": "analysis"}')
        for wrong in (lambda: klangprobe.modes("rood", ROD), lambda: klangprobe.fit(self.folder / "none.toml"),
                      lambda: klangprobe.analyze(np.zeros(1000), 8000), lambda: klangprobe.modes("rod", ROD, "alumium"),
                      lambda: klangprobe.bubble_info(-1), lambda: klangprobe.fit(self.folder / "none.json"),
                      lambda: klangprobe.fit(self.folder / "half.json"), lambda: klangprobe.fit(self.folder / "other.json"),
                      lambda: klangprobe.synth(self.folder / "none.json", "rod"), lambda: klangprobe.analyze(np.zeros((2, 2, 2)), 8000)):
            with self.assertRaises(ValueError) as caught:
                wrong()
            self.assertNotIn("\n", str(caught.exception))
        tone = np.exp(-5 * np.arange(8000) / 8000)
        for words, wrong in (
                (("modes: dims must be a dict", "None"), lambda: klangprobe.modes("rod", None)),
                (('dims["length_m"] must be a number',), lambda: klangprobe.modes("rod", {"length_m": "a", "radius_m": 1})),
                (("count must be an integer", "2.5"), lambda: klangprobe.modes("rod", ROD, count=2.5)),
                (("material must be a preset",), lambda: klangprobe.modes("rod", ROD, None)),
                (("shape must be a text",), lambda: klangprobe.modes(3, ROD)),
                (("modes: help is no option (accepted: band_hz",), lambda: klangprobe.modes("rod", ROD, help=True)),
                (("no option", "did you mean support"), lambda: klangprobe.modes("rod", ROD, suport="free")),
                (("support must be a value",), lambda: klangprobe.modes("rod", ROD, support=True)),
                (("no_mesh_error must be True or False",), lambda: klangprobe.modes("rod", ROD, no_mesh_error="yes")),
                (("method: polinomial", "did you mean polynomial"), lambda: klangprobe.modes("rod", ROD, method="polinomial")),
                (("x must be an array of real numbers",), lambda: klangprobe.analyze("abc", 8000)),
                (("x must be an array of real numbers",), lambda: klangprobe.analyze(tone + 1j, 8000)),
                (("rate must be a number",), lambda: klangprobe.analyze(tone, None)),
                (("band_hz must be two numbers",), lambda: klangprobe.analyze(tone, 8000, band_hz=3)),
                (("path must be a path",), lambda: klangprobe.fit(None)),
                (("specimen must be a text",), lambda: klangprobe.synth(self.folder / "half.json", 3)),
                (('dims["length_m"] must be a number',), lambda: klangprobe.synth("none.json", "rod", dims={"length_m": None})),
                (("radius_m must be a number",), lambda: klangprobe.bubble_info("x")),
                (("output: is missing",), lambda: klangprobe.transfer("no.vtu")),
                (("output must be a path",), lambda: klangprobe.scene("no.toml", 3))):
            with self.assertRaises(ValueError) as caught:
                wrong()
            said = str(caught.exception)
            self.assertNotIn("\n", said)
            self.assertNotIn("--", said)
            for word in words:
                self.assertIn(word, said)
        with self.assertRaises(klangprobe.Error):
            klangprobe.analyze(np.random.default_rng(1).normal(size=8000) * 0.1, 8000)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
