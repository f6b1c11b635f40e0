"""Klangprobe: material parameters from the sound of struck objects.

What the program klang does, as functions on numpy arrays. Numbers are SI with their unit in the name. Bad input is a ValueError of one
line; a computation that cannot give an answer is an Error. Results keep everything that the program writes in their field `data`.

>>> import klangprobe
>>> tube = {"length_m": 0.505, "outer_radius_m": 0.0125, "wall_m": 0.001}
>>> klangprobe.modes("tube", tube, "aluminium", count=2).frequency_hz
"""
from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import tempfile
import typing

import numpy as np

from . import _klangprobe
from ._klangprobe import Error

__version__ = _klangprobe.version()
__all__ = ["Analysis", "Error", "Fit", "Modes", "Parameter", "Partial", "analyze", "bubble_info", "fit", "modes", "scene", "synth", "transfer"]

Material = typing.Union[str, typing.Mapping[str, float]]
Path = typing.Union[str, "os.PathLike[str]"]


@dataclasses.dataclass(frozen=True)
class Modes:
    """Elastic modes of a body, ascending."""
    frequency_hz: np.ndarray
    none_missing: typing.Optional[bool]
    data: dict = dataclasses.field(repr=False)


@dataclasses.dataclass(frozen=True)
class Partial:
    """amplitude exp(-decay_per_s t) cos(2 pi frequency_hz t + phase_rad) from the strike on; None: not measured."""
    frequency_hz: float
    frequency_std_hz: typing.Optional[float] = None
    decay_per_s: typing.Optional[float] = None
    decay_std_per_s: typing.Optional[float] = None
    amplitude: typing.Optional[float] = None
    amplitude_std: typing.Optional[float] = None
    phase_rad: typing.Optional[float] = None
    phase_std_rad: typing.Optional[float] = None
    kind: str = "decaying"
    note: str = ""
    cents: typing.Optional[float] = None


@dataclasses.dataclass(frozen=True)
class Analysis:
    """Partials of a recording, ascending in frequency."""
    partials: typing.List[Partial]
    explained_energy: typing.Optional[float]
    data: dict = dataclasses.field(repr=False)

    def to_pandas(self):
        """The partials as a pandas.DataFrame, a row for each."""
        import pandas
        return pandas.DataFrame([dataclasses.asdict(partial) for partial in self.partials],
                                columns=[field.name for field in dataclasses.fields(Partial)])


@dataclasses.dataclass(frozen=True)
class Parameter:
    """An estimate; std and ci95 are None where the data do not determine it."""
    name: str
    value: float
    std: typing.Optional[float]
    ci95: typing.Optional[typing.Tuple[float, float]]
    identifiable: bool
    verdict: str
    why: str
    caveat: str


@dataclasses.dataclass(frozen=True)
class Fit:
    """What a fit found; `path` is its fit.json, beside which sounds and modes lie as long as the object lives (or for good in `output`)."""
    parameters: typing.Dict[str, Parameter]
    verdict: str
    path: pathlib.Path
    data: dict = dataclasses.field(repr=False)
    _folder: typing.Any = dataclasses.field(repr=False, default=None)

    def to_pandas(self):
        """The parameters as a pandas.DataFrame, a row for each."""
        import pandas
        return pandas.DataFrame([dataclasses.asdict(parameter) for parameter in self.parameters.values()])


def _words(options: typing.Mapping[str, typing.Any]) -> typing.List[str]:
    """rate_hz=8000 as --rate-hz 8000; True is a flag, a list a repeated option, None left out."""
    words: typing.List[str] = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        for one in value if isinstance(value, (list, tuple)) else [value]:
            if one is None or one is False:
                continue
            words += [option] if one is True else [option, os.fspath(one) if isinstance(one, os.PathLike) else str(one)]
    return words


def _assignments(values: typing.Mapping[str, float]) -> str:
    return ",".join(f"{name}={float(value)!r}" for name, value in values.items())


def _material(material: Material) -> str:
    return _assignments(material) if isinstance(material, typing.Mapping) else os.fspath(material)


def _call(words: typing.List[str], threads: int = 0) -> dict:
    """Runs a command and gives its --json."""
    with tempfile.TemporaryDirectory(prefix="klangprobe-") as folder:
        result = pathlib.Path(folder, "result.json")
        _klangprobe.call([*words, "--quiet", "--threads", str(threads), "--json", str(result)])
        return json.loads(result.read_text(encoding="utf-8"))


def modes(shape: str, dims: typing.Mapping[str, float], material: Material = "aluminium", count: int = 10, threads: int = 0,
          **options: typing.Any) -> Modes:
    """Eigenfrequencies of a free body, none missing. material: a preset, a fit.json, or {"youngs_modulus_pa": ..}; further options as of `klang
    modes` (support="clamped:x=0", output is -o)."""
    data = _call(["modes", "--shape", shape, "--dims", _assignments(dims), "--material", _material(material), "--count", str(count),
                  *_words(options)], threads)
    return Modes(np.array([mode["frequency_hz"] for mode in data["modes"]]), data.get("none_missing"), data)


def analyze(x: typing.Any, rate: float, a4_hz: float = 440.0, band_hz: typing.Tuple[float, float] = (20.0, 20000.0)) -> Analysis:
    """Partials of a recording with their standard deviations. x: frames, or frames x channels, full scale 1."""
    data = json.loads(_klangprobe.analyze(np.asarray(x, dtype=float), float(rate), float(a4_hz), float(band_hz[0]), float(band_hz[1])))
    known = {field.name for field in dataclasses.fields(Partial)}
    partials = [Partial(**{key: value for key, value in row.items() if key in known}) for row in data["partials"]]
    return Analysis(partials, data.get("explained_energy"), data)


def _read_fit(path: pathlib.Path) -> dict:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise ValueError(f"{path}: is no JSON ({error})") from error
    if not isinstance(data, dict) or data.get("kind") != "fit" or "parameters" not in data:
        raise ValueError(f"{path}: is no result of klang fit")
    return data


def fit(path: Path, output: typing.Optional[Path] = None, threads: int = 0, **options: typing.Any) -> Fit:
    """Material parameters from a specimen's file, as `klang fit`; or what such a run left (a fit.json)."""
    path = pathlib.Path(path)
    holder = None
    if path.suffix == ".json":
        data, result = _read_fit(path), path
    else:
        if output is None:
            holder = tempfile.TemporaryDirectory(prefix="klangprobe-fit-")
        folder = pathlib.Path(holder.name if holder is not None else typing.cast(Path, output))
        data = _call(["fit", str(path), "-o", str(folder), "--no-pictures", *_words(options)], threads)
        result = folder / "fit.json"
    parameters = {
        row["name"]: Parameter(row["name"], row["value"], row["std"], tuple(row["ci95"]) if row["ci95"] else None, row["identifiable"],
                               row["verdict"], row["why"], row.get("caveat", ""))
        for row in data["parameters"]
    }
    return Fit(parameters, data["judgement"]["verdict"], result, data, holder)


def synth(fit: typing.Union[Fit, Path], specimen: str = "", duration_s: float = 3.0, rate_hz: float = 48000.0,
          dims: typing.Optional[typing.Mapping[str, float]] = None) -> np.ndarray:
    """Sound of a fitted specimen after one strike, with the fit's damping, peak -3 dB; dims: the same thing of other dimensions."""
    path = fit.path if isinstance(fit, Fit) else pathlib.Path(fit)
    return _klangprobe.synth(str(path), specimen, dict(dims or {}), float(duration_s), float(rate_hz))


def bubble_info(radius_m: float, **options: typing.Any) -> dict:
    """Frequency and damping of a gas bubble, as `klang bubble info`."""
    return _call(["bubble", "info", "--radius-m", repr(float(radius_m)), *_words(options)])


def transfer(model: Path, threads: int = 0, **options: typing.Any) -> dict:
    """How each mode of a model (.vtu) sounds outside, as `klang transfer`; output is -o."""
    return _call(["transfer", os.fspath(model), *_words(options)], threads)


def scene(path: Path, output: Path, threads: int = 0, **options: typing.Any) -> dict:
    """Runs a scene of solid bodies into a folder, as `klang scene run`."""
    return _call(["scene", "run", os.fspath(path), "-o", os.fspath(output), *_words(options)], threads)
