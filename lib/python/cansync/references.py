"""Reference values."""

from __future__ import annotations

import typing

from ._link import Link
from ._native import ffi, lib
from .codes import Code
from .errors import error_of

_VALUES = 4  # of one telegram

TAKE_OVER = -2**31
"""In the place of a strength: one more than that of whoever has it now, so that this program takes over."""


class References:
    """Gives reference values; made by :meth:`Client.references`. A context manager that gives the telegrams up.

    After a restart of the daemon, or another mapping, nothing is given any more, and :meth:`give` raises TakeUp, until
    the program has looked at the line and calls :meth:`take_up`.
    """

    def __init__(self, link: Link, strength: int) -> None:
        self._link = link
        self._strength = strength
        self.take_up()

    def take_up(self) -> None:
        """What is given from now on is meant for the daemon and the mapping in force now. Waits at most 2 s for a daemon that
        takes values; other calls of this client wait meanwhile. NotConnected: there was none."""
        self._link.call(lib.cansync_take_references, self._strength)

    def give(self, telegram: int, values: typing.Sequence[int | None], *, release_intervals: int = 1,
             from_interval: int = 0) -> None:
        """Gives raw values of telegram 1 (reference values 0..3) or 2 (4..7); None: keeps its last value.

        release_intervals: in so many intervals in a row they are released; 1: exactly once
        from_interval: the first of them; 0: the next

        Does not wait. Bad values are reported by the daemon as an event. TakeUp: nothing was given. Refused: nothing was
        given, because another writer has the telegram that is no weaker; it is taken when that one has gone.
        """
        if not 1 <= len(values) <= _VALUES:
            raise error_of(Code.INVALID, f"client: {len(values)} values: a telegram has 1 to {_VALUES}")
        valid = sum(1 << place for place, value in enumerate(values) if value is not None)
        try:
            raw = ffi.new("int32_t[4]", [value or 0 for value in values])
            self._link.call(lib.cansync_give_references, telegram, raw, valid, release_intervals, from_interval)
        except OverflowError as error:
            raise error_of(Code.INVALID, f"client: {error}") from None

    def leave(self) -> None:
        """Gives both telegrams up: their release ends at once, and the next values of another writer are taken."""
        if not self._link.closed:
            self._link.call(lib.cansync_leave_references)

    def __enter__(self) -> References:
        return self

    def __exit__(self, *_: object) -> None:
        self.leave()
