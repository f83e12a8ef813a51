"""Checks the arguments of sensors and adapters, and the options that they pass on to the renderer."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Mapping
from typing import Any

from . import _core
from .errors import ArgumentTypeError, UsageError


def integers(values: Any, name: str) -> list[int]:
    """The items of a list of integers. Raises ArgumentTypeError for anything else."""
    try:
        return [operator.index(value) for value in values]
    except TypeError:
        raise ArgumentTypeError(f"{name} must be a list of integers, not {values!r:.60}") from None


def numbers(values: Any, name: str, count: int) -> list[float]:
    """The items of a list of so many numbers. Raises UsageError for anything else."""
    try:
        items = list(values)
    except TypeError:
        items = []
    if isinstance(values, str) or len(items) != count:
        raise UsageError(f"{name} must be {count} numbers, not {values!r}")
    return [_core.number_of(item, name) for item in items]


def require(value: Any, kind: type, name: str) -> None:
    """Raises ArgumentTypeError unless the value is an instance of the class."""
    if not isinstance(value, kind):
        raise ArgumentTypeError(f"{name} must be a {kind.__name__}, not {type(value).__name__}")


def reject_options(options: Mapping[str, Any], names: Iterable[str], reason: str) -> None:
    """Raises UsageError if the options set one of these names to another value than None or False.

    reason: the beginning of the message, a main clause with a subject in the singular
    """
    for name in names:
        value = options.get(name)
        if value is not None and value is not False:
            raise UsageError(f"{reason}, so it has no option {name}")
