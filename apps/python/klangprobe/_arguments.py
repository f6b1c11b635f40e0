"""Arguments as the functions of klangprobe take them, and complaints in their words: a ValueError of one line that names the argument, what was given and what
is accepted."""
from __future__ import annotations

import os
import re
import typing

import numpy as np

from . import _klangprobe

Values = typing.Mapping[str, float]


def wrong(function: str, argument: str, accepted: str, given: typing.Any) -> ValueError:
    shown = " ".join(repr(given).split())
    return ValueError(f"{function}: {argument} must be {accepted}, not {shown if len(shown) <= 80 else shown[:77] + '...'}")


def number(function: str, argument: str, value: typing.Any) -> float:
    if not isinstance(value, (bool, np.bool_, str, bytes)):
        try:
            return float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    raise wrong(function, argument, "a number", value)


def integer(function: str, argument: str, value: typing.Any) -> int:
    if not isinstance(value, (bool, np.bool_)):
        try:
            return int(value.__index__())
        except (AttributeError, TypeError):
            pass
    raise wrong(function, argument, "an integer", value)


def text(function: str, argument: str, value: typing.Any) -> str:
    if not isinstance(value, str) or not _is_plain(value):
        raise wrong(function, argument, "a text", value)
    return value


def path(function: str, argument: str, value: typing.Any) -> str:
    try:
        name = os.fspath(value)
    except TypeError:
        name = None
    if not isinstance(name, str) or not _is_plain(name):
        raise wrong(function, argument, "a path (str or os.PathLike)", value)
    return name


def values(function: str, argument: str, given: typing.Any) -> typing.Dict[str, float]:
    if not isinstance(given, typing.Mapping):
        raise wrong(function, argument, 'a dict of numbers by name ({"length_m": 0.2})', given)
    return {text(function, f"a name in {argument}", name): number(function, f'{argument}["{name}"]', value) for name, value in given.items()}


def assignments(function: str, argument: str, given: typing.Any) -> str:
    return ",".join(f"{name}={value!r}" for name, value in values(function, argument, given).items())


def words(function: str, command: str, options: typing.Mapping[str, typing.Any], own: typing.Collection[str] = ()) -> typing.List[str]:
    """rate_hz=8000 as --rate-hz 8000; True is a flag, a list a repeated option, None left out. own: options that the function gives itself."""
    known = {name: takes for name, takes in _klangprobe.options(command).items() if name not in {"help", "version", "json", "quiet", "verbose", *own}}
    result: typing.List[str] = []
    for name, value in options.items():
        if name not in known:
            raise ValueError(f"{function}: {name} is no option (accepted: {', '.join(known)})" + _klangprobe.did_you_mean(name, list(known)))
        option = "--" + name.replace("_", "-")
        for one in value if isinstance(value, (list, tuple)) else [value]:
            if one is None or (isinstance(one, (bool, np.bool_)) and not one):
                continue
            if isinstance(one, (bool, np.bool_)) != (not known[name]):
                raise wrong(function, name, "a value" if known[name] else "True or False", one)
            result += [option] if not known[name] else [option + "=" + _word(function, name, one)]
    return result


def in_words_of_python(message: str) -> str:
    """The command's flags as arguments: --rate-hz is rate_hz, -o is output."""
    message = re.sub(r"(?<![\w-])--([a-z][a-z0-9]*(?:-[a-z0-9]+)*)", lambda flag: flag[1].replace("-", "_"), message)
    message = re.sub(r"(?<![\w-])-o(?![\w-])", "output", message)
    return " ".join(message.removeprefix("command line: ").split())


def _is_plain(value: str) -> bool:
    return "\0" not in value and all(not 0xD800 <= ord(c) <= 0xDFFF for c in value)


def _word(function: str, argument: str, value: typing.Any) -> str:
    if isinstance(value, typing.Mapping):
        return assignments(function, argument, value)
    if isinstance(value, str):
        return text(function, argument, value)
    if isinstance(value, os.PathLike):
        return path(function, argument, value)
    if isinstance(value, (int, float, np.number)):
        return repr(value.item() if isinstance(value, np.number) else value)
    raise wrong(function, argument, "a text, a number, a path or a list of such", value)
