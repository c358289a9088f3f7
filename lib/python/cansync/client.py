"""The connection to a bus."""

from __future__ import annotations

import typing
import weakref

from ._link import Link, in_callback, must_not_wait
from ._native import ffi, lib
from .codes import Code, Mode
from .errors import NotConnected, error_of
from .jobs import Job, Progress
from .parameters import Parameter, Value
from .references import References
from .streams import Stream, Subscription
from .topics import NUMBERS, ActualValues, MasterStatus, SlaveStatus

T = typing.TypeVar("T")
Slave = typing.Union[int, str]  # number 0..31, or name in the daemon's configuration

AUTOMATIC = -128
NOBODY = -1
UNCHANGED = -2

_FIRST = 2.0  # seconds; how long what the daemon has kept is waited for
_VALUE = 7  # element of a parameter
_AS_SLAVE_SAYS = 2  # format of a parameter


def _milliseconds(seconds: float | None) -> int:
    """0 is the daemon's default."""
    return 0 if seconds is None else max(1, round(seconds * 1000))


def connect(bus: str = "can0", *, domain: int = 0, interface: str = "lo", name: str = "python", timeout: float = 5.0,
            security: str | None = None, profiles: str | None = None, final_types: bool = False) -> Client:
    """Waits until a daemon serves the bus and gives the connection to it.

    bus: the bus's name in the daemon's configuration; "" takes the only bus of the domain;
        "plc2/can0": no daemon of another computer than plc2 is asked
    domain, interface: DDS domain 0..230 and network interface, as in the daemon's section [dds]
    name: shown in the daemon's journal, at most 64 characters
    timeout: seconds for which the daemon is looked for; NotConnected is raised then
    security: folder of this program's identity (docs/security.md); None: without DDS Security
    profiles: folder of drive profiles, looked into before the standard ones (docs/profiles.md)
    final_types: the daemon's dds.types is "final" (docs/dds-api.md)
    """
    options: dict[str, typing.Any] = {"bus": bus, "domain": domain, "interface": interface, "client_name": name,
                                      "wait_ms": _milliseconds(timeout), "final_types": int(final_types)}
    options |= {key: given for key, given in (("security", security), ("profiles", profiles)) if given is not None}
    return Client(Link(options))


class Client:
    """One connection to one bus, made by :func:`connect`; a context manager that closes it.

    Slaves are given by number 0..31 or by name. Every method may be called from any thread, but those that wait not from
    a callback. Times are in seconds. A method that waits ends at once with Ctrl-C, and cancels what it has asked for.
    """

    def __init__(self, link: Link) -> None:
        self._link = link
        # Also when the interpreter ends: before that nothing of the library may run any more.
        self._end = weakref.finalize(self, link.close)

    def close(self) -> None:
        """Ends the connection and everything that was followed. Requests go on in the daemon."""
        self._end()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- state

    @typing.overload
    def status(self) -> MasterStatus: ...

    @typing.overload
    def status(self, topic: type[T]) -> T: ...

    def status(self, topic: typing.Any = MasterStatus) -> typing.Any:
        """What the daemon that is there told last, at most about a second old. That it was killed, or its network is cut, is known
        after 5 s.

        topic: MasterStatus, the line; GatewayStatus, which daemon serves it; BusStatus, the CAN interface; RealtimeStatus.
        For the first sample of a daemon it waits at most 2 s, but not in a callback. NotConnected: at once when no daemon is
        there, or none came.
        """
        return self._sample(topic, 0, _FIRST)

    def slave_status(self, slave: Slave, timeout: float = 2.0) -> SlaveStatus:
        """The newest status of a configured slave. Timeout when none comes within `timeout`."""
        return typing.cast(SlaveStatus, self._sample(SlaveStatus, self.slave(slave), timeout))

    def slaves(self, timeout: float = 2.0) -> list[SlaveStatus]:
        """The newest status of every configured slave, by number."""
        configured = self.status().slaves_configured
        return [self.slave_status(slave, timeout) for slave in range(32) if configured >> slave & 1]

    def actual_values(self, slave: Slave, timeout: float = 0.5) -> ActualValues:
        """The newest actual values of a slave. Timeout when none come within `timeout`."""
        return typing.cast(ActualValues, self._sample(ActualValues, self.slave(slave), timeout))

    def wait_active(self, timeout: float = 30.0) -> None:
        """Waits until the line is in run and every configured slave synchronized. Timeout; NotConnected: in the end no daemon
        was there."""
        reason: list[Exception] = []

        def active() -> bool:
            try:
                return self._link.call(lib.cansync_wait_active, 0)
            except (NotConnected, TimeoutError) as error:
                reason[:] = [error]
                return False

        if not self._link.poll(timeout, active):
            if isinstance(reason[0], NotConnected):
                raise reason[0]
            raise error_of(Code.TIMEOUT, f"client: not within {timeout} s: {str(reason[0]).removeprefix('client: ')}")

    def slave(self, number_or_name: Slave) -> int:
        """The number of a slave. Invalid, with the names there are, when there is none of this name."""
        if isinstance(number_or_name, int):
            return number_or_name
        if number_or_name[:1].isdigit():
            found = ffi.new("uint32_t *")
            self._link.call(lib.cansync_find_slave, number_or_name.encode(), found)  # waits for nothing
            return int(found[0])
        # Each time anew: a reload of the daemon may give the name to another slave.
        known: dict[str, int] = {}
        statuses: list[SlaveStatus] = []
        twice: list[str] = []  # each slave has a sample of its own: while names are exchanged two bear the same one

        def look() -> bool:
            statuses[:] = self._known_slaves()
            known.clear()
            twice.clear()
            for status in statuses:
                if status.name:
                    twice.extend([status.name] if status.name in known else [])
                    known[status.name] = status.slave
            return number_or_name in known and number_or_name not in twice or len(statuses) == self.status().slaves_configured.bit_count()

        if not in_callback():
            self._link.poll(_FIRST, look)
        elif not look():
            must_not_wait()
        if number_or_name not in known and len(statuses) < self.status().slaves_configured.bit_count():
            raise error_of(Code.INVALID, f"client: slave '{number_or_name}': the daemon has not told the names of all slaves yet; "
                           "ask again, or give a number")
        if number_or_name not in known:
            names = ", ".join(known) or "a name, but no slave has one"
            raise error_of(Code.INVALID, f"client: slave '{number_or_name}': no slave has this name; allowed 0..31 or {names}")
        if number_or_name in twice:
            raise error_of(Code.INVALID, f"client: slave '{number_or_name}': two slaves bear this name at the moment; ask again, "
                           "or give a number")
        return known[number_or_name]

    def follow(self, topic: type[T], *, depth: int = 10000, timeout: float | None = None) -> Stream[T]:
        """An iterator over a topic: one of the classes of :mod:`cansync.topics`. What is known comes first.

        depth: so many samples wait at most; the oldest are dropped then, and counted
        timeout: seconds after which the iterator raises Timeout when nothing comes
        """
        return Stream(self, self._link, topic, depth, timeout)

    def subscribe(self, topic: type[T], callback: typing.Callable[[T], object]) -> Subscription:
        """Calls `callback` for each sample of a topic. It runs on a thread of the library: see :class:`Subscription`."""
        return Subscription(self._link, topic, callback)

    # --- parameters

    def read(self, slave: Slave, parameter: int | str, *, timeout: float | None = None) -> Value:
        """Reads a parameter by number 0..4095, or by the name it has in the slave's profile.

        timeout: monitoring time; None: the daemon's
        """
        must_not_wait()
        return self.submit_read(slave, parameter, timeout=timeout)._finish()

    def write(self, slave: Slave, parameter: int | str, value: float, *, timeout: float | None = None) -> None:
        """Writes a parameter: by name `value` is in its unit, and what the profile does not allow is refused before
        anything is sent; by number it is the raw value.

        After OutcomeUnknown read it back: whether the slave took it is not known.
        """
        must_not_wait()
        self.submit_write(slave, parameter, value, timeout=timeout)._finish()

    def submit_read(self, slave: Slave, parameter: int | str, *, timeout: float | None = None, sub_slave: int = 0,
                    element: int = _VALUE, format: int = _AS_SLAVE_SAYS) -> Job[Value]:
        """Like `read`, without waiting. sub_slave: participant below the slave; element: 0..7; format: 0 word, 1 doubleword."""
        number = self.slave(slave)
        info = self._find(number, parameter) if isinstance(parameter, str) else None
        if info is not None:
            format = self._format(info, element, format)
        request = {"slave": number, "number": parameter if info is None else info.number, "sub_slave": sub_slave,
                   "element": element, "format": format, "timeout_ms": _milliseconds(timeout)}

        def value_of(reply: typing.Any) -> Value:
            # What the profile says holds for values of its own format.
            fits = info is not None and bool(reply.doubleword) == bool(info.doubleword)
            value = lib.cansync_to_unit(info, reply.value) if fits else reply.value
            known = Parameter._of(info) if fits else None
            return Value(request["number"], value, reply.value, bool(reply.doubleword), known.name if known else "",
                         known.unit if known else "", reply.intervals)

        return self._submit_parameter(request, value_of)

    def submit_write(self, slave: Slave, parameter: int | str, value: float, *, timeout: float | None = None,
                     sub_slave: int = 0, element: int = _VALUE, format: int = _AS_SLAVE_SAYS) -> Job[None]:
        """Like `write`, without waiting; the rest as for `submit_read`."""
        number = self.slave(slave)
        if isinstance(parameter, str):
            info, raw = self._find(number, parameter), ffi.new("uint32_t *")
            self._link.call(lib.cansync_from_unit, info, value, raw)
            parameter, value, format = info.number, raw[0], self._format(info, element, format)
        elif value != int(value):
            raise error_of(Code.INVALID, f"client: value {value}: a raw value is a whole number")
        return self._submit_parameter({"write": 1, "slave": number, "number": parameter, "value": int(value),
                                       "sub_slave": sub_slave, "element": element, "format": format,
                                       "timeout_ms": _milliseconds(timeout)}, lambda reply: None)

    def parameter(self, slave: Slave, number_or_name: int | str) -> Parameter:
        """What the slave's profile says of a parameter; of a number that it does not have, an empty name."""
        return Parameter._of(self._find(self.slave(slave), str(number_or_name)))

    def parameters(self, slave: Slave) -> list[Parameter]:
        """Every parameter of the slave's profile, by number."""
        number = self.slave(slave)
        found: list[Parameter] = []
        self._hear(number)
        info = ffi.new("cansync_parameter_info *")
        while self._link.call(lib.cansync_list_parameter, number, len(found), info, missing=True):
            found.append(Parameter._of(info))
        return found

    # --- transfers

    def upload(self, slave: Slave, address: int, size: int, progress: Progress | None = None) -> bytes:
        """Reads `size` bytes (1..16777216) from a start address (0x100 and more) of a slave.

        progress: called with bytes done and in total, on this thread; what it raises cancels the transfer
        """
        must_not_wait()
        return self.submit_upload(slave, address, size)._finish(progress)

    def download(self, slave: Slave, address: int, data: bytes, progress: Progress | None = None) -> None:
        """Writes 1..16777216 bytes to a start address of a slave. When it fails the slave may hold a part."""
        must_not_wait()
        self.submit_download(slave, address, data)._finish(progress)

    def submit_upload(self, slave: Slave, address: int, size: int, *, timeout: float | None = None, sub_slave: int = 0,
                      block_size: int = 0) -> Job[bytes]:
        """Like `upload`, without waiting. timeout: monitoring time of a block; block_size: bytes of one, 0: the slave's."""
        return self._submit_transfer({"slave": self.slave(slave), "address": address, "size": size, "sub_slave": sub_slave,
                                      "block_size": block_size, "timeout_ms": _milliseconds(timeout)},
                                     lambda reply: bytes(ffi.buffer(reply.data, reply.size)))

    def submit_download(self, slave: Slave, address: int, data: bytes, *, timeout: float | None = None, sub_slave: int = 0,
                        block_size: int = 0) -> Job[None]:
        """Like `download`, without waiting; the rest as for `submit_upload`."""
        return self._submit_transfer({"download": 1, "slave": self.slave(slave), "address": address, "size": len(data),
                                      "data": ffi.from_buffer(data), "sub_slave": sub_slave, "block_size": block_size,
                                      "timeout_ms": _milliseconds(timeout)}, lambda reply: None)

    # --- reference values

    def references(self, strength: int = 0) -> References:
        """The writer of reference values; a client has one. strength: 0 and more, or cansync.TAKE_OVER.

        A telegram has one writer at a time, which keeps it until it gives it up, is lost, or a stronger one comes.
        """
        return References(self._link, strength)

    # --- commands: each waits until it was on the bus, or is in effect

    def control_word(self, slave: Slave, word: int, *, timeout: float | None = None) -> None:
        """Control word 0..65535 to a slave. Cancelled: a newer word, or a stop, took its place. OutcomeUnknown: it was not
        seen on the bus; look at the slave's status before it is sent again."""
        self._command(lib.CANSYNC_COMMAND_CONTROL_WORD, slave=self.slave(slave), control_word=word,
                      timeout_ms=_milliseconds(timeout))

    def broadcast(self, slaves: typing.Iterable[Slave], action: int, *, priority: int = 2, data_byte: int = 0,
                  data_word: int = 0, timeout: float | None = None) -> None:
        """Action command 1 (control word in `data_word`) or 128..255 to a group of slaves.

        priority: 0 (before everything else), 1 or 2
        """
        mask = 0
        for slave in slaves:
            mask |= 1 << self.slave(slave)
        self._command(lib.CANSYNC_COMMAND_BROADCAST, priority=priority, slave_mask=mask, action=action,
                      data_byte=data_byte, data_word=data_word, timeout_ms=_milliseconds(timeout))

    def set_mode(self, mode: Mode, *, force: bool = False) -> None:
        """Changes the mode of the line. force: Mode.RUN also when slaves are missing."""
        self._command(lib.CANSYNC_COMMAND_MODE, mode=int(mode), force=force)

    def release(self, slave: Slave, *, force: bool = False) -> None:
        """Lets a slave that was away and is held out be used again. force: without its check."""
        self._command(lib.CANSYNC_COMMAND_RELEASE, slave=self.slave(slave), force=force)

    def polling(self, one: int = UNCHANGED, two: int = UNCHANGED, maximum_slave: int = UNCHANGED) -> None:
        """Which slave WRC1 and WRC2 ask for actual values: 0..31, AUTOMATIC or NOBODY. Lost when the daemon is started
        anew, like the next three."""
        self._command(lib.CANSYNC_COMMAND_POLLING, one=one, two=two, three=maximum_slave)

    def cursors(self, control_word: int = UNCHANGED, parameter: int = UNCHANGED, transfer: int = UNCHANGED) -> None:
        """Which slave the command channel serves, for each kind of job: 0..31, AUTOMATIC or NOBODY."""
        self._command(lib.CANSYNC_COMMAND_CURSORS, one=control_word, two=parameter, three=transfer)

    def map_references(self, mapping: typing.Sequence[int]) -> None:
        """Mapping of the reference values: 8 register bytes, words 0..3 of telegram 1, then of telegram 2. Another one
        than that in force ends what is released until :meth:`References.take_up`."""
        self._command(lib.CANSYNC_COMMAND_MAP_REFERENCES, mapping=self._mapping(mapping))

    def map_actuals(self, slave: Slave, mapping: typing.Sequence[int]) -> None:
        """How the actual value telegrams of a slave are read; it must be what the slave itself sends by."""
        self._command(lib.CANSYNC_COMMAND_MAP_ACTUALS, slave=self.slave(slave), mapping=self._mapping(mapping))

    # --- inside

    def _sample(self, topic: typing.Any, slave: int, timeout: float) -> typing.Any:
        if topic not in NUMBERS:
            raise error_of(Code.INVALID, f"client: {topic!r} is no topic")
        out = ffi.new(f"{topic._struct} *")
        size = ffi.sizeof(topic._struct)

        def look() -> bool:
            return self._link.call(lib.cansync_get_sample, NUMBERS[topic], slave, 0, out, size, missing=True)

        if not self._link.poll(timeout, look):
            if topic not in (SlaveStatus, ActualValues):
                raise error_of(Code.NO_DAEMON, f"client: the daemon has told no {topic.__name__} within {timeout} s")
            raise error_of(Code.TIMEOUT, f"client: no {topic.__name__} of slave {slave} within {timeout} s; is it "
                                         "configured, and the line in run?")
        return topic._of(out)

    def _known_slaves(self) -> list[SlaveStatus]:
        """Of those that are known; waits for nothing."""
        configured, known = self.status().slaves_configured, []
        for slave in range(32):
            out = ffi.new(f"{SlaveStatus._struct} *")
            if configured >> slave & 1 and self._link.call(lib.cansync_get_sample, NUMBERS[SlaveStatus], slave, 0, out,
                                                           ffi.sizeof(SlaveStatus._struct), missing=True):
                known.append(SlaveStatus._of(out))
        return known

    def _hear(self, slave: int) -> None:
        """Waits for the first status of a slave here, where Ctrl-C ends it and callbacks go on, not in the library."""
        if 0 <= slave < 32 and self.status().slaves_configured >> slave & 1:
            self.slave_status(slave)

    def _find(self, slave: int, parameter: str) -> typing.Any:
        self._hear(slave)
        info = ffi.new("cansync_parameter_info *")
        self._link.call(lib.cansync_find_parameter, slave, parameter.encode(), info)
        return info

    @staticmethod
    def _format(info: typing.Any, element: int, format: int) -> int:
        """Of a value by name that of the profile: a drive that has another one says so, and nothing is written."""
        known = info.doubleword >= 0  # a number without a profile has none
        return int(info.doubleword) if known and format == _AS_SLAVE_SAYS and element == _VALUE else format

    def _submit_parameter(self, request: dict[str, typing.Any], convert: typing.Callable[[typing.Any], T]) -> Job[T]:
        return self._submit(lib.cansync_submit_parameter, "cansync_parameter_request *", request, convert)

    def _submit_transfer(self, request: dict[str, typing.Any], convert: typing.Callable[[typing.Any], T]) -> Job[T]:
        return self._submit(lib.cansync_submit_transfer, "cansync_transfer_request *", request, convert)

    def _command(self, kind: int, **members: typing.Any) -> None:
        must_not_wait()
        job = self._submit(lib.cansync_submit_command, "cansync_command_request *", dict(members, kind=kind),
                           lambda reply: None)
        job._finish()

    def _submit(self, function: typing.Any, pointer: str, request: dict[str, typing.Any],
                convert: typing.Callable[[typing.Any], T]) -> Job[T]:
        try:
            native = ffi.new(pointer, request)
        except OverflowError as error:
            raise error_of(Code.INVALID, f"client: {request}: {error}") from None
        return Job(self, self._link.make(function, native), convert)

    @staticmethod
    def _mapping(mapping: typing.Sequence[int]) -> bytes:
        if len(mapping) != 8:
            raise error_of(Code.INVALID, f"client: mapping of {len(mapping)} bytes: allowed 8")
        return bytes(mapping)
