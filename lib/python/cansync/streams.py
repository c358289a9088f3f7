"""Topics that are followed: callbacks, and iterators on top of them."""

from __future__ import annotations

import collections
import threading
import time
import typing
import weakref

from ._link import SLICE, Link, in_callback, must_not_wait
from ._native import ffi
from .codes import Code
from .errors import error_of
from .topics import NUMBERS

T = typing.TypeVar("T")


class _Receiver:
    """What the library calls; known to it from its making until `close`."""

    def __init__(self, link: Link, topic: type, callback: typing.Callable[[typing.Any], object]) -> None:
        if topic not in NUMBERS:
            raise error_of(Code.INVALID, f"client: {topic!r}: allowed {', '.join(each.__name__ for each in NUMBERS)}")
        self._link = link
        self._pointer = f"{topic._struct} *"  # type: ignore[attr-defined]
        self._convert = topic._of  # type: ignore[attr-defined]
        self._callback = callback
        self._handle = ffi.new_handle(self)
        self._lock = threading.Lock()
        self.on_close: typing.Callable[[], None] = lambda: None
        with self._lock:  # who closes it meanwhile waits
            self._native = link.subscribe(self, NUMBERS[topic], self._handle)

    def arrived(self, sample: typing.Any) -> None:
        self._callback(self._convert(ffi.cast(self._pointer, sample)))

    def close(self) -> None:
        if in_callback():  # the library would wait for this very callback
            threading.Thread(target=self.close).start()
            return
        with self._lock:
            native, self._native = self._native, None
        if native is not None:
            self._link.unsubscribe(self, native)
            self.on_close()


class Subscription:
    """Calls a function for each sample until it is closed, or its client is. Dropping it does not end it.

    The function runs on a thread of the library: it must be short and must not wait for anything of the same client.
    What it raises goes to ``threading.excepthook``.
    """

    def __init__(self, link: Link, topic: type[T], callback: typing.Callable[[T], object]) -> None:
        self._receiver = _Receiver(link, topic, callback)

    def close(self) -> None:
        """Ends it; the function is not running any more then. Inside that function: soon."""
        self._receiver.close()

    def __enter__(self) -> Subscription:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Stream(typing.Generic[T]):
    """An iterator over the samples of a topic; ends when it or its client is closed.

    dropped: samples thrown away, the oldest first, because more than `depth` were waiting
    """

    def __init__(self, client: object, link: Link, topic: type[T], depth: int, timeout: float | None) -> None:
        if depth < 1:
            raise error_of(Code.INVALID, f"client: depth {depth}: allowed 1 and more")
        waiting: collections.deque[T] = collections.deque()
        changed = threading.Condition()
        self._waiting, self._changed, self._timeout = waiting, changed, timeout
        self._client = client  # which stays open as long as it is followed
        self._dropped = dropped = [0]
        self._closed = closed = [False]

        # Neither of these knows the stream: one that nobody holds any more ends.
        def keep(sample: T) -> None:
            with changed:
                if len(waiting) == depth:
                    waiting.popleft()
                    dropped[0] += 1
                waiting.append(sample)
                changed.notify()

        def end() -> None:
            with changed:
                closed[0] = True
                changed.notify_all()

        self._receiver = _Receiver(link, topic, keep)
        self._receiver.on_close = end
        self._end = weakref.finalize(self, self._receiver.close)

    @property
    def dropped(self) -> int:
        return self._dropped[0]

    def get(self, timeout: float | None = None) -> T:
        """The next sample. Timeout when none comes within so many seconds; None: waits for ever. Invalid when closed."""
        must_not_wait()
        end = None if timeout is None else time.monotonic() + timeout
        with self._changed:
            while not self._waiting:
                if self._closed[0]:
                    raise error_of(Code.INVALID, "client: it is closed")
                left = None if end is None else end - time.monotonic()
                if left is not None and left <= 0:
                    raise error_of(Code.TIMEOUT, f"client: nothing came within {timeout} s")
                # The interpreter sees a signal that came just before this wait, or to another thread, only after it.
                self._changed.wait(SLICE if left is None else min(left, SLICE))
            return self._waiting.popleft()

    def __iter__(self) -> Stream[T]:
        return self

    def __next__(self) -> T:
        try:
            return self.get(self._timeout)
        except ValueError:
            raise StopIteration from None

    def close(self) -> None:
        """Ends it; what is waiting can still be taken."""
        self._end()

    def __enter__(self) -> Stream[T]:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
