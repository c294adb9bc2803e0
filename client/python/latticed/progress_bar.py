# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""Progress of uploads, downloads and exports; by default shown only on a terminal."""
from __future__ import annotations

import sys
import time
from typing import Callable, Optional, TextIO, Union

# Called with the bytes done and the bytes in all.
ProgressFunction = Callable[[int, int], None]
# True: a bar on standard error. False: none. None: a bar if standard error is a terminal.
Progress = Optional[Union[bool, ProgressFunction]]

_WIDTH = 30
_SECONDS_BETWEEN = 0.1


class ProgressBar:
    """One line, which is redrawn at most ten times a second. The call with all bytes done ends it."""

    def __init__(self, label: str, out: TextIO | None = None) -> None:
        self._label = label
        self._out = out or sys.stderr
        self._drawn = float("-inf")

    def __call__(self, done: int, total: int) -> None:
        now, complete = time.monotonic(), done >= total
        if not complete and now - self._drawn < _SECONDS_BETWEEN:
            return
        self._drawn = now
        share = done / total if total else 1.0
        filled = int(share * _WIDTH)
        bar = "#" * filled + "-" * (_WIDTH - filled)
        scale, unit = (1e6, "MB") if total >= 1e6 else (1e3, "kB")
        text = f"\r{self._label} [{bar}] {share:4.0%} of {total / scale:.1f} {unit}"
        self._out.write(text + ("\n" if complete else ""))
        self._out.flush()


def progress_function(progress: Progress, label: str) -> ProgressFunction:
    """The function to call for `progress`."""
    if callable(progress):
        return progress
    if progress or (progress is None and sys.stderr is not None and sys.stderr.isatty()):
        return ProgressBar(label)
    return lambda done, total: None
