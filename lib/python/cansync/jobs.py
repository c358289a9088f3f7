"""Requests on their way."""

from __future__ import annotations

import time
import typing

from ._link import JOB_SLICE_MS, must_not_wait, text
from ._native import ffi, lib
from .codes import Code
from .errors import error_of

T = typing.TypeVar("T")
Progress = typing.Callable[[int, int], object]


class Job(typing.Generic[T]):
    """A request on its way: wait for its result, or cancel it. Every method may be called from any thread.

    At most 64 may be open for a client. Every job ends, also when its reply never comes (docs/client-library.md).
    """

    def __init__(self, client: object, native: typing.Any, convert: typing.Callable[[typing.Any], T]) -> None:
        self._client = client  # which stays open as long as its jobs
        self._native = ffi.gc(native, lib.cansync_job_free)
        self._convert = convert

    def done(self) -> bool:
        """True when it has ended."""
        return bool(lib.cansync_job_wait(self._native, 0))

    def progress(self) -> tuple[int, int]:
        """Bytes done and in total of a transfer, as the daemon told last; (0, 0) before it has."""
        numbers = ffi.new("uint32_t[2]")
        lib.cansync_job_progress(self._native, numbers, numbers + 1)
        return numbers[0], numbers[1]

    def cancel(self) -> None:
        """Asks the daemon to cancel it; :meth:`result` then raises Cancelled, unless it had ended before."""
        lib.cansync_job_cancel(self._native)

    def result(self, timeout: float | None = None, progress: Progress | None = None) -> T:
        """Waits for the end and gives what was asked for; raises an Error when it ended otherwise.

        timeout: seconds for which this waits; Timeout is raised then, and the job stays open
        progress: called with bytes done and in total, on this thread, whenever they have changed
        """
        end = None if timeout is None else time.monotonic() + timeout
        told = (0, 0)
        while True:
            left = JOB_SLICE_MS if end is None else max(0, min(JOB_SLICE_MS, int((end - time.monotonic()) * 1000)))
            if not self.done():
                must_not_wait()
            ended = lib.cansync_job_wait(self._native, left)
            if progress is not None and (now := self.progress()) != told:
                told = now
                progress(*now)
            if ended:
                return self._reply()
            if end is not None and time.monotonic() >= end:
                raise error_of(Code.TIMEOUT, f"client: the request is still open after {timeout} s")

    def _reply(self) -> T:
        reply = ffi.new("cansync_reply *")
        lib.cansync_job_reply(self._native, reply)
        if reply.result != Code.DONE:
            raise error_of(reply.result, text(reply.reason), reply.cause, reply.error_code)
        return self._convert(reply)

    def _finish(self, progress: Progress | None = None) -> T:
        """The result for who has no job in hand: what ends the wait, such as Ctrl-C, cancels the request."""
        try:
            return self.result(progress=progress)
        except BaseException:
            if not self.done():
                self.cancel()
            raise
