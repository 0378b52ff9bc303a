"""The language of a report: every text in English, with the German ones in `german.toml`.

`say` writes a sentence of the report, and `word` a text that a result or a figure brings along.
"""

import re
import sys
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from importlib.resources import files
from typing import Any

from gearbow._types import Language

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_language: ContextVar[Language] = ContextVar("language", default="en")
#: Names that the user gave, which are no words.
_names: ContextVar[Collection[str]] = ContextVar("names", default=())


@contextmanager
def speaking(language: Language, names: Collection[str]) -> Iterator[None]:
    """Write texts in a language, and names of the user as they are."""
    tokens = _language.set(language), _names.set(names)
    try:
        yield
    finally:
        _language.reset(tokens[0])
        _names.reset(tokens[1])


def language() -> Language:
    """Give the language of the report that is written."""
    return _language.get()


@cache
def german() -> Mapping[str, dict[str, str]]:
    """Give the German "sentences" of the report and "words" of results by the English ones."""
    text = files(__package__).joinpath("german.toml").read_text("utf-8")
    found: dict[str, dict[str, str]] = tomllib.loads(text)
    return found


def say(text: str, /, **values: Any) -> str:
    """Write a sentence or heading of the report, with values in its places."""
    template = german()["sentences"][text] if language() == "de" else text
    return template.format(**values)


def word(text: str) -> str:
    """Translate a text of a result: words, a name with a unit, or a sentence with values."""
    if language() == "en" or text in _names.get():
        return text
    words = german()["words"]
    if text in words:
        return words[text]
    name, bracket, unit = text.partition(" [")
    if bracket and name in words:
        return f"{words[name]}{bracket}{unit}"
    for pattern, template in _patterns():
        found = pattern.fullmatch(text)
        if found:
            return template.format(**{key: word(value) for key, value in found.groupdict().items()})
    # Lists of motions or orders.
    return ", ".join(map(word, text.split(", "))) if ", " in text else text


@cache
def _patterns() -> tuple[tuple[re.Pattern[str], str], ...]:
    """Give what a text with values looks like, and its translation."""
    found = []
    for text, translation in german()["words"].items():
        if "{" in text:
            parts = re.split(r"\{(\w+)\}", text)
            fixed = [re.escape(part) for part in parts[::2]]
            groups = [f"(?P<{name}>.+?)" for name in parts[1::2]] + [""]
            pairs = zip(fixed, groups, strict=True)
            pattern = "".join(piece for pair in pairs for piece in pair)
            found.append((re.compile(pattern, re.DOTALL), translation))
    return tuple(found)
