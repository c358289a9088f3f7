"""The handle of the C face behind a Client: one call at a time, waits that end with Ctrl-C, and an end in order."""

from __future__ import annotations

import contextlib
import threading
import time
import typing

from ._native import ffi, lib
from .codes import Code
from .errors import error_of

SLICE = 0.02  # seconds; how long Ctrl-C may take where something is looked at again and again
JOB_SLICE_MS = 50  # likewise, where the library waits

_thread = threading.local()  # callback: inside a callback of the library; interrupt: what ended a wait


def text(pointer: typing.Any) -> str:
    """A text of the library."""
    return str(ffi.string(pointer).decode("utf-8", "replace"))


def in_callback() -> bool:
    """True on the library's thread, which must not wait for what it brings itself."""
    return getattr(_thread, "callback", False)


def must_not_wait() -> None:
    """Raises where a wait would never end."""
    if in_callback():
        raise error_of(Code.INVALID, "client: a callback may not wait: hand what came to another thread, or use follow()")


def _keep_interrupt(kind: object, value: BaseException, trace: object) -> None:
    _thread.interrupt = value


@ffi.def_extern(error=0, onerror=_keep_interrupt)  # type: ignore[misc]
def python_go_on(user: typing.Any) -> int:
    """Asked by the library while it waits; Ctrl-C comes here, and nothing is waited for from then on."""
    return 0 if getattr(_thread, "interrupt", None) is not None else 1


@ffi.def_extern()  # type: ignore[misc]
def python_on_sample(user: typing.Any, sample: typing.Any) -> None:
    """On the library's thread; cffi has taken the interpreter's lock."""
    receiver = ffi.from_handle(user)
    _thread.callback = True
    try:
        receiver.arrived(sample)
    except BaseException as error:  # it must not get into the library
        threading.excepthook(threading.ExceptHookArgs((type(error), error, error.__traceback__, threading.current_thread())))
    finally:
        _thread.callback = False


@contextlib.contextmanager
def interruptible() -> typing.Iterator[None]:
    """Raises what ended a wait of the library in it: Ctrl-C, or what another handler of a signal has raised."""
    _thread.interrupt = None
    yield
    if _thread.interrupt is not None:
        raise _thread.interrupt


class Link:
    """One handle. The functions of the library that take it are called with `call` alone."""

    def __init__(self, options: dict[str, typing.Any]) -> None:
        self._lock = threading.RLock()
        self._handle = lib.cansync_new()
        self._receivers: set[typing.Any] = set()
        if self._handle == ffi.NULL:
            raise MemoryError
        keep = {key: ffi.new("char[]", value.encode()) if isinstance(value, str) else value for key, value in options.items()}
        try:
            given = ffi.new("cansync_options *", dict(keep, go_on=lib.python_go_on))
            self.call(lib.cansync_connect, given)
        except BaseException:
            self.close()
            raise

    def call(self, function: typing.Callable[..., int], *arguments: typing.Any, missing: bool = False) -> bool:
        """Calls and raises what its result stands for; with `missing`, CANSYNC_NO_DATA gives False."""
        with self._lock:
            with interruptible():
                result = function(self._open(), *arguments)
            if result == Code.DONE:
                return True
            if result == Code.NO_DATA and missing:
                return False
            raise error_of(result, text(lib.cansync_last_error(self._handle)), lib.cansync_last_cause(self._handle))

    def make(self, function: typing.Callable[..., typing.Any], *arguments: typing.Any) -> typing.Any:
        """Calls what gives an object of the library."""
        with self._lock:
            made = function(self._open(), *arguments)
            if made == ffi.NULL:
                raise error_of(Code.INVALID, text(lib.cansync_last_error(self._handle)))
            return made

    def subscribe(self, receiver: typing.Any, topic: int, user: typing.Any) -> typing.Any:
        """Follows a topic for a receiver, which is closed with the link."""
        with self._lock:
            made = self.make(lib.cansync_subscribe, topic, lib.python_on_sample, user)
            self._receivers.add(receiver)
            return made

    def unsubscribe(self, receiver: typing.Any, native: typing.Any) -> None:
        """Ends it; waits for its callback."""
        lib.cansync_unsubscribe(native)
        self._receivers.discard(receiver)

    def poll(self, seconds: float, look: typing.Callable[[], bool]) -> bool:
        """Looks again and again until it is true or the time is over; False then."""
        end = time.monotonic() + seconds
        while not look():
            must_not_wait()
            left = end - time.monotonic()
            if left <= 0:
                return False
            time.sleep(min(SLICE, left))
        return True

    def _open(self) -> typing.Any:
        if self._handle is None:
            raise error_of(Code.INVALID, "client: it is closed")
        return self._handle

    @property
    def closed(self) -> bool:
        return self._handle is None

    def close(self) -> None:
        """Ends everything. From a callback, where nothing may wait for it, on a thread of its own."""
        if in_callback():
            threading.Thread(target=self.close).start()
            return
        with self._lock:  # from here on nobody begins anything
            handle, self._handle = self._handle, None
            receivers = list(self._receivers)
        for receiver in receivers:
            receiver.close()
        if handle is not None:
            lib.cansync_free(handle)
