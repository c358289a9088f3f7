"""Parameters by number or name."""

from __future__ import annotations

import dataclasses
import enum
import typing

from ._link import text


class Access(enum.IntEnum):
    """What may be done with a parameter."""

    READ_WRITE = 0
    READ_ONLY = 1
    NONE = 2


@dataclasses.dataclass(slots=True, frozen=True)
class Parameter:
    """What a slave's drive profile says of a parameter (docs/profiles.md): value = raw number * factor + offset.

    doubleword: 32 bits, else 16; None: no profile says
    minimum, maximum: raw numbers that may be written; None: all that the format holds
    """

    number: int
    name: str
    unit: str
    group: str
    text: str
    doubleword: bool | None
    signed: bool
    factor: float
    offset: float
    access: Access
    volatile: bool
    minimum: int | None
    maximum: int | None

    @classmethod
    def _of(cls, c: typing.Any) -> Parameter:
        limits = (c.minimum, c.maximum) if c.limited else (None, None)
        return cls(c.number, text(c.name), text(c.unit), text(c.group), text(c.text),
                   None if c.doubleword < 0 else bool(c.doubleword),
                   bool(c.is_signed), c.factor, c.offset, Access(c.access), bool(c.is_volatile), *limits)


@dataclasses.dataclass(slots=True, frozen=True)
class Value:
    """A parameter as it was read.

    value: in `unit` when it was asked for by name, else the raw value
    raw: as on the bus, without sign
    doubleword: 32 bits; else 16
    name, unit: of the slave's profile; empty when it was asked for by number
    intervals: from the first telegram to the answer
    """

    number: int
    value: float
    raw: int
    doubleword: bool
    name: str
    unit: str
    intervals: int

    def __str__(self) -> str:
        return f"{self.value:.10g} {self.unit}".rstrip()
