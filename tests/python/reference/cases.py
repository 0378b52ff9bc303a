"""Many cases as one test, which reports every case that fails."""

from __future__ import annotations

import functools
import inspect
import reprlib
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import pytest


def each_case(
    names: str | Sequence[str],
    cases: Iterable[Any],
    ids: Iterable[str] | Callable[[Any], object] = reprlib.repr,
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Run a test with every case; it takes the arguments of `pytest.mark.parametrize`.

    All cases share the fixtures. `ids` are the labels of the cases, or give the label of a value.
    """
    keys = names.replace(",", " ").split() if isinstance(names, str) else list(names)
    rows = [tuple(case) if len(keys) > 1 else (case,) for case in cases]
    if callable(ids):
        labels = [
            ", ".join(str(ids(value) or reprlib.repr(value)) for value in row) for row in rows
        ]
    else:
        labels = list(ids)
    given = [
        (label, dict(zip(keys, row, strict=True))) for label, row in zip(labels, rows, strict=True)
    ]
    if not given:
        raise ValueError("a test without cases cannot fail")

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(test)
        def with_every_case(*owner: Any, **fixtures: Any) -> None:
            failures: list[tuple[str, BaseException]] = []
            for label, case in given:
                try:
                    test(*owner, **fixtures, **case)
                except (Exception, pytest.fail.Exception) as error:  # noqa: BLE001  # reported below
                    failures.append((label, error))
            if failures:
                texts = [f"{label}: {type(one).__name__}: {one}" for label, one in failures]
                lines = "\n".join(text.replace("\n", "\n    ") for text in texts)
                raise AssertionError(
                    f"{len(failures)} of {len(given)} cases fail:\n{lines}"
                ) from failures[0][1]

        arguments = inspect.signature(test).parameters.values()
        with_every_case.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
            [each for each in arguments if each.name not in keys]
        )
        return with_every_case

    return decorate
