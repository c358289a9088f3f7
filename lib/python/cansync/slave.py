"""The application behind a daemon that is a slave (bus.protocol = "cansync-slave")."""

from __future__ import annotations

import dataclasses
import threading
import time
import typing
import weakref

from ._link import JOB_SLICE_MS, interruptible, text
from ._native import ffi, lib
from .codes import Code, Mode, SlaveEventKind, SlaveFault
from .errors import error_of

_VALUES = 4  # of one telegram
_WORDS = 8  # of both telegrams


@dataclasses.dataclass(frozen=True)
class SlaveEvent:
    """What came; members that its kind does not name are 0 or empty.

    kind: what it is, and which members mean something
    time_ns: CLOCK_REALTIME of the telegram's last bit, in nanoseconds
    interval: number of the interval in which it came
    job: number of a parameter job or block
    number: parameter, start address, command, or number of a slave
    element: of a parameter, 0..7; 7 is the value
    sub_slave: 0: this slave
    write: the master writes `value`
    doubleword: format of a write
    value: of a write, raw
    download: to the slave; else from it
    whole: the block goes as a whole; else telegram by telegram
    length: of a block in bytes; an upload may leave it to the slave: 0
    offset, telegram_bytes: of a telegram in its block
    answered: the answer was on the bus, the block was moved; else dropped, cancelled, refused
    data_byte, data_word: of an action
    values: raw, by the slave's mapping; of telegram 1 values 0..3, of telegram 2 4..7
    words: bit n: value n comes as its low word alone
    arrived, ever: bit 0, 1: telegram 1, 2 came with this, came at least once
    data: of a download
    """

    kind: SlaveEventKind
    time_ns: int
    interval: int
    job: int
    number: int
    element: int
    sub_slave: int
    write: bool
    doubleword: bool
    value: int
    download: bool
    whole: bool
    length: int
    offset: int
    telegram_bytes: int
    answered: bool
    data_byte: int
    data_word: int
    values: tuple[int, ...]
    words: int
    arrived: int
    ever: int
    data: bytes


@dataclasses.dataclass(frozen=True)
class SlaveState:
    """State of the slave, as the daemon told last; docs/status-topics.md (SlaveSideStatus) says what each is."""

    slave_number: int
    option_status: int
    cansync_status: int
    status_word: int
    activated: bool
    synchronized: bool
    fault: SlaveFault
    reaction: int
    interval: int
    interval_ns: int
    missing_edges: int
    missing_references: int
    actual_sent: tuple[int, ...]
    actual_late: tuple[int, ...]
    status_parameter: int
    reference_mapping: tuple[int, ...]
    actual_mapping: tuple[int, ...]
    application: str


def _plain(value: typing.Any, kind: str) -> typing.Any:
    """A member of a C struct as Python has it."""
    if kind.startswith("char"):
        return text(value)
    if "[" in kind:
        return tuple(value)
    return value


def _members(struct: typing.Any) -> dict[str, typing.Any]:
    fields = [field for field in ffi.typeof(struct).item.fields if field[0] not in ("data", "data_size")]
    return {name: _plain(getattr(struct, name), field.type.cname) for name, field in fields}


def connect_slave(bus: str = "can0", *, domain: int = 0, interface: str = "lo", name: str = "python", timeout: float = 5.0,
                  security: str | None = None, final_types: bool = False) -> Application:
    """Waits until a daemon serves the bus as a slave and gives the connection to it. The arguments are those of `connect`."""
    options: dict[str, typing.Any] = {"bus": bus, "domain": domain, "interface": interface, "client_name": name,
                                      "wait_ms": max(1, round(timeout * 1000)), "final_types": int(final_types)}
    if security is not None:
        options["security"] = security
    return Application(options)


class Application:
    """A connection to a slave, made by :func:`connect_slave`; a context manager that gives everything back and closes it.

    While something is taken over, :meth:`receive` must be called at least twice a second: the daemon takes who is silent
    for two seconds for gone. Every method may be called from any thread, one at a time.
    """

    def __init__(self, options: dict[str, typing.Any]) -> None:
        self._lock = threading.RLock()
        handle = lib.cansync_application_new()
        if handle == ffi.NULL:
            raise MemoryError
        self._handle = handle
        self._open = [True]
        self._end = weakref.finalize(self, Application._free, handle, self._open)
        keep = {key: ffi.new("char[]", value.encode()) if isinstance(value, str) else value for key, value in options.items()}
        try:
            self._call(lib.cansync_application_connect, ffi.new("cansync_options *", dict(keep, go_on=lib.python_go_on)))
        except BaseException:
            self.close()
            raise

    @staticmethod
    def _free(handle: typing.Any, is_open: list[bool]) -> None:
        is_open[0] = False
        lib.cansync_application_free(handle)

    def _call(self, function: typing.Callable[..., int], *arguments: typing.Any) -> int:
        """Calls and raises what its result stands for, but for CANSYNC_NO_DATA."""
        with self._lock:
            if not self._open[0]:
                raise error_of(Code.INVALID, "client: it is closed")
            with interruptible():
                result = function(self._handle, *arguments)
            if result in (Code.DONE, Code.NO_DATA):
                return result
            raise error_of(result, text(lib.cansync_application_last_error(self._handle)),
                           lib.cansync_application_last_cause(self._handle))

    def close(self) -> None:
        """Gives back what was taken over and released, and ends the connection."""
        with self._lock:
            self._end()

    def __enter__(self) -> Application:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def state(self) -> SlaveState:
        """What the daemon told last of its slave. NotConnected while no daemon is there."""
        out = ffi.new("cansync_slave_state *")
        if self._call(lib.cansync_application_get_state, out) == Code.NO_DATA:
            raise error_of(Code.NO_DATA, "client: the daemon tells nothing of its slave yet")
        members = _members(out)
        members["fault"] = SlaveFault(members["fault"])
        for name in ("activated", "synchronized"):
            members[name] = bool(members[name])
        return SlaveState(**members)

    def receive(self, timeout: float = 0.0) -> SlaveEvent | None:
        """The next thing that came, oldest first; None when nothing comes within `timeout`.

        NotConnected while no daemon is there; it may come back. Of more than 1000 that nobody takes the oldest are dropped.
        """
        end = time.monotonic() + timeout
        out = ffi.new("cansync_slave_event *")
        while True:
            left = max(0, round((end - time.monotonic()) * 1000))
            if self._call(lib.cansync_application_receive, min(left, JOB_SLICE_MS), out) == Code.DONE:
                break
            if left == 0:
                return None
        members = _members(out)
        members["data"] = bytes(ffi.buffer(out.data, out.data_size))
        members["kind"] = SlaveEventKind(members["kind"])
        for name in ("write", "doubleword", "download", "whole", "answered"):
            members[name] = bool(members[name])
        return SlaveEvent(**members)

    def take_over(self, parameters: typing.Iterable[int] = (), *, sub_slaves: bool = False, blocks: bool = False,
                  strength: int = 1) -> None:
        """Takes over parameters 0..4095, those of sub-slaves, and uploads and downloads, instead of what was before.

        Nothing of all gives everything back. strength: a program keeps what it has until a stronger one comes; the first call's counts.
        """
        numbers = list(parameters)
        try:
            given = ffi.new("uint16_t[]", numbers)
        except OverflowError as error:
            raise error_of(Code.INVALID, f"client: {error}") from None
        self._call(lib.cansync_application_take_over, given, len(numbers), int(sub_slaves), int(blocks), strength)

    def answer(self, asked: SlaveEvent, value: int = 0, *, doubleword: bool = False) -> None:
        """To PARAMETER: a write is done, or a read has this raw value in this format; a word is -32768..65535."""
        if not -0x80000000 <= value <= 0xFFFFFFFF:
            raise error_of(Code.INVALID, f"client: value {value}: allowed -2147483648..4294967295")
        self._call(lib.cansync_application_answer, asked.job, value & 0xFFFFFFFF, int(doubleword))

    def refuse(self, asked: SlaveEvent, error: int) -> None:
        """A parameter job or a block fails with this error number: 1..0xFFFF, of a block 0x0100 and over."""
        of_parameter = asked.kind == SlaveEventKind.PARAMETER
        self._call(lib.cansync_application_refuse if of_parameter else lib.cansync_application_refuse_block, asked.job, error)

    def allow(self, asked: SlaveEvent, data: bytes = b"", *, length: int = 0) -> None:
        """To BLOCK: it may be moved. A whole upload brings all its data; another one may fix its length, 0: as asked."""
        self._call(lib.cansync_application_allow_block, asked.job, data, len(data), length)

    def take(self, asked: SlaveEvent) -> None:
        """To BLOCK_DATA: the download was taken."""
        self._call(lib.cansync_application_take_block, asked.job)

    def step(self, asked: SlaveEvent, data: bytes = b"") -> None:
        """To BLOCK_STEP: done; of an upload with as many bytes as were asked for."""
        self._call(lib.cansync_application_step_block, asked.job, data, len(data))

    def release(self, telegram: int, values: typing.Sequence[int | None], *, wait_intervals: int = 2) -> None:
        """Releases raw actual values of telegram 1 (0..3) or 2 (4..7) for one telegram; None: keeps its last value.

        wait_intervals: for so many intervals, 1..1000, it waits for the master to ask
        TakeUp after a restart of the daemon: nothing is released until :meth:`take_up`.
        """
        if not 1 <= len(values) <= _VALUES:
            raise error_of(Code.INVALID, f"client: {len(values)} values: a telegram has 1 to {_VALUES}")
        valid = sum(1 << place for place, value in enumerate(values) if value is not None)
        try:
            raw = ffi.new("int32_t[4]", [value or 0 for value in values])
            self._call(lib.cansync_application_release, telegram, raw, valid, wait_intervals)
        except OverflowError as error:
            raise error_of(Code.INVALID, f"client: {error}") from None

    def take_up(self, strength: int = 0) -> None:
        """What is released from now on is meant for the daemon that is there now."""
        self._call(lib.cansync_application_take_up, strength)

    def set_mode(self, mode: Mode) -> None:
        """Sets the slave's mode; from waiting for start first SETUP, then RUN. Waits for the reply."""
        self._call(lib.cansync_application_set_mode, int(mode))

    def set_mapping(self, references: typing.Sequence[int], actual_values: typing.Sequence[int]) -> None:
        """Register bytes of WRC1, WRC2 and of RDC1, RDC2, eight each. Waits for the reply."""
        self._call(lib.cansync_application_set_mapping, _registers(references), _registers(actual_values))

    def listen(self, other: int, actual_values: typing.Sequence[int]) -> None:
        """How the actual values of slave `other` are listened to: register bytes; all 0: not any more."""
        self._call(lib.cansync_application_listen, other, _registers(actual_values))


def _registers(given: typing.Sequence[int]) -> typing.Any:
    if len(given) != _WORDS:
        raise error_of(Code.INVALID, f"client: {len(given)} register bytes: allowed {_WORDS}")
    try:
        return ffi.new("uint8_t[8]", list(given))
    except OverflowError as error:
        raise error_of(Code.INVALID, f"client: {error}") from None
