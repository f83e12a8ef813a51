"""Checks the options that sensors and adapters pass on to the renderer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from .errors import UsageError


def reject_options(options: Mapping[str, Any], names: Iterable[str], reason: str) -> None:
    """Raises UsageError if the options set one of these names to another value than None or False.

    reason: the beginning of the message, a main clause with a subject in the singular
    """
    for name in names:
        value = options.get(name)
        if value is not None and value is not False:
            raise UsageError(f"{reason}, so it has no option {name}")
