# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Values that callers choose by name."""
from typing import Any, Mapping


def choose(what: str, name: str, choices: Mapping[str, Any]) -> Any:
    """Returns the value of `name`; ValueError for an unknown name."""
    if name not in choices:
        raise ValueError(f"{what} is one of {', '.join(filter(None, choices))}, not {name!r}")
    return choices[name]
