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
import shutil
import tempfile
import typing
import warnings
import weakref

import numpy as np

from . import _arguments, _klangprobe
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


def _material(function: str, material: typing.Any) -> str:
    if isinstance(material, typing.Mapping):
        return _arguments.assignments(function, "material", material)
    try:
        return _arguments.path(function, "material", material)
    except ValueError:
        raise _arguments.wrong(function, "material", "a preset, a fit.json, or a dict of numbers by name", material) from None


def _call(words: typing.List[str], threads: int = 0) -> dict:
    """Runs a command and gives its --json; what it warns of is a Python warning."""
    with tempfile.TemporaryDirectory(prefix="klangprobe-") as folder:
        result = pathlib.Path(folder, "result.json")
        try:
            said = _klangprobe.call([*words, "--quiet", "--threads", str(threads), "--json", str(result)])
        except (ValueError, Error) as error:
            raise type(error)(_arguments.in_words_of_python(str(error))) from None
        for warning in said:
            warnings.warn(_arguments.in_words_of_python(warning), stacklevel=3)
        return json.loads(result.read_text(encoding="utf-8"))


def modes(shape: str, dims: typing.Mapping[str, float], material: Material = "aluminium", count: int = 10, threads: int = 0,
          **options: typing.Any) -> Modes:
    """Eigenfrequencies of a body, free unless support says otherwise, none missing. material: a preset, a fit.json, or {"youngs_modulus_pa": ..}; further options as of `klang
    modes` (output is -o).

    >>> bar = {"length_m": 0.2, "width_m": 0.02, "height_m": 0.005}
    >>> klangprobe.modes("box", bar, "steel", count=3, support="clamped:x=min").frequency_hz
    """
    data = _call(["modes", "--shape", _arguments.text("modes", "shape", shape), "--dims", _arguments.assignments("modes", "dims", dims), "--material",
                  _material("modes", material), "--count", str(_arguments.integer("modes", "count", count)),
                  *_arguments.words("modes", "modes", options, own=("shape", "dims", "material", "count", "threads", "mesh"))],
                 _arguments.integer("modes", "threads", threads))
    return Modes(np.array([mode["frequency_hz"] for mode in data["modes"]]), data.get("none_missing"), data)


def _samples(x: typing.Any) -> np.ndarray:
    try:
        samples = np.asarray(x)
        if samples.dtype.kind in "fiu" and samples.ndim in (1, 2):
            return samples.astype(float)
    except ValueError:  # rows of different lengths
        pass
    raise _arguments.wrong("analyze", "x", "an array of real numbers, frames or frames x channels", x)


def analyze(x: typing.Any, rate: float, a4_hz: float = 440.0, band_hz: typing.Tuple[float, float] = (20.0, 20000.0)) -> Analysis:
    """Partials of a recording with their standard deviations. x: frames, or frames x channels, full scale 1."""
    samples, rate = _samples(x), _arguments.number("analyze", "rate", rate)
    if not isinstance(band_hz, (tuple, list, np.ndarray)) or len(band_hz) != 2:
        raise _arguments.wrong("analyze", "band_hz", "two numbers, (lowest, highest)", band_hz)
    low_hz, high_hz = (_arguments.number("analyze", f"band_hz[{i}]", band_hz[i]) for i in (0, 1))
    data = json.loads(_klangprobe.analyze(samples, rate, _arguments.number("analyze", "a4_hz", a4_hz), low_hz, high_hz))
    known = {field.name for field in dataclasses.fields(Partial)}
    partials = [Partial(**{key: value for key, value in row.items() if key in known}) for row in data["partials"]]
    return Analysis(partials, data.get("explained_energy"), data)


class _Folder:
    """A folder that goes with the object."""

    def __init__(self) -> None:
        self.name = tempfile.mkdtemp(prefix="klangprobe-fit-")
        self.remove = weakref.finalize(self, shutil.rmtree, self.name, ignore_errors=True)


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
    """Material parameters from a specimen's file, as `klang fit`; or what such a run left (a fit.json, which takes no options)."""
    path = pathlib.Path(_arguments.path("fit", "path", path))
    words = _arguments.words("fit", "fit", options, own=("output", "threads", "pictures", "no_pictures"))
    n_threads = _arguments.integer("fit", "threads", threads)
    holder = None
    if path.suffix == ".json":
        if output is not None or words:
            raise ValueError(f"fit: {path} is the result of a fit already: output and options belong to a specimen's file (.toml)")
        data, result = _read_fit(path), path
    else:
        if output is None:
            holder = _Folder()
        folder = pathlib.Path(holder.name if holder is not None else _arguments.path("fit", "output", output))
        try:
            data = _call(["fit", str(path), "-o", str(folder), "--no-pictures", *words], n_threads)
        except BaseException:
            if holder is not None:
                holder.remove()
            raise
        result = folder / "fit.json"
    parameters = {
        row["name"]: Parameter(row["name"], row["value"], row["std"], tuple(row["ci95"]) if row["ci95"] else None, row["identifiable"],
                               row["verdict"], row["why"], row.get("caveat", ""))
        for row in data["parameters"]
    }
    return Fit(parameters, data["judgement"]["verdict"], result, data, holder)


def synth(fit: typing.Union[Fit, Path], specimen: str = "", duration_s: float = 3.0, rate_hz: float = 48000.0,
          dims: typing.Optional[typing.Mapping[str, float]] = None) -> np.ndarray:
    """Sound of a fitted specimen after one strike, with the fit's damping, peak -3 dB; dims: the same thing of other dimensions. Where no damping was
    measured a loss factor of 1/1000 is assumed, with a warning."""
    path = str(fit.path) if isinstance(fit, Fit) else _arguments.path("synth", "fit", fit)
    changed = {} if dims is None else _arguments.values("synth", "dims", dims)
    name, length_s = _arguments.text("synth", "specimen", specimen), _arguments.number("synth", "duration_s", duration_s)
    try:
        return _klangprobe.synth(path, name, changed, length_s, _arguments.number("synth", "rate_hz", rate_hz))
    except (ValueError, Error) as error:
        raise type(error)(_arguments.in_words_of_python(str(error))) from None


def bubble_info(radius_m: float, **options: typing.Any) -> dict:
    """Frequency and damping of a gas bubble, as `klang bubble info`."""
    return _call(["bubble", "info", "--radius-m", repr(_arguments.number("bubble_info", "radius_m", radius_m)),
                  *_arguments.words("bubble_info", "bubble info", options, own=("radius_m",))])


def transfer(model: Path, output: typing.Optional[Path] = None, threads: int = 0, **options: typing.Any) -> dict:
    """How each mode of a model (.vtu) sounds outside, as `klang transfer`; output: the file for the transfer (.vtu)."""
    if output is not None:
        options = {"output": output, **options}
    return _call(["transfer", _arguments.path("transfer", "model", model), *_arguments.words("transfer", "transfer", options, own=("threads",))],
                 _arguments.integer("transfer", "threads", threads))


def scene(path: Path, output: Path, threads: int = 0, **options: typing.Any) -> dict:
    """Runs a scene of solid bodies into a folder, as `klang scene run`."""
    return _call(["scene", "run", _arguments.path("scene", "path", path), "-o", _arguments.path("scene", "output", output),
                  *_arguments.words("scene", "scene run", options, own=("output", "threads"))], _arguments.integer("scene", "threads", threads))
