"""What goes wrong: one exception for each way a call can end other than done."""

from __future__ import annotations

from ._native import lib
from .codes import Cause, Code, Retry


class Error(Exception):
    """A call that did not end as wanted. ``str(error)`` is the reason: who said no, why, and what is allowed.

    code: how it ended, a :class:`Code`
    cause: why it was refused, a :class:`Cause`; NONE when it ended otherwise
    reason: the same for people, for example "daemon: slave 9: not configured; allowed 0..3"
    error_code: the slave's own error code; 0: none
    """

    def __init__(self, code: Code, reason: str, cause: Cause = Cause.NONE, error_code: int = 0) -> None:
        super().__init__(reason)
        self.code = code
        self.reason = reason
        self.cause = cause
        self.error_code = error_code

    @property
    def retry(self) -> Retry:
        """Whether it helps to ask the same again."""
        return Retry(lib.cansync_retry(self.code, self.cause))


class Refused(Error):
    """Not accepted, by the daemon or by this library; nothing was sent."""


class SlaveError(Error):
    """The slave answered with an error code (``error_code``), or wants another format of the value."""


class Timeout(Error, TimeoutError):
    """No answer of the slave in the monitoring time, or what was waited for did not come in time."""


class OutcomeUnknown(Error):
    """Whether it was done is not known: no answer to a write, a lost slave, or the daemon has gone."""


class Cancelled(Error):
    """It was cancelled, the master was stopped, or a newer control word took its place."""


class NotConnected(Error, ConnectionError):
    """No daemon serves the bus, DDS could not be set up, or the client is closed."""


class NoData(Error):
    """Nothing is known yet, or there is no more."""


class Invalid(Error, ValueError):
    """A wrong argument."""


class TakeUp(Error):
    """The daemon was started anew, or the reference mapping changed: no reference value is given until
    :meth:`References.take_up` is called, after a look at the line."""


_CLASSES: dict[Code, type[Error]] = {
    Code.REFUSED: Refused,
    Code.SLAVE_ERROR: SlaveError,
    Code.TIMEOUT: Timeout,
    Code.NO_ANSWER: OutcomeUnknown,
    Code.WORD_EXPECTED: SlaveError,
    Code.DOUBLEWORD_EXPECTED: SlaveError,
    Code.VALUE_TOO_WIDE: SlaveError,
    Code.CANCELLED: Cancelled,
    Code.MASTER_STOPPED: Cancelled,
    Code.SLAVE_LOST: OutcomeUnknown,
    Code.NO_REPLY: OutcomeUnknown,
    Code.NO_DAEMON: NotConnected,
    Code.SETUP_FAILED: NotConnected,
    Code.NO_DATA: NoData,
    Code.INVALID: Invalid,
    Code.FAILED: Error,
    Code.TAKE_UP: TakeUp,
    Code.REPLACED: Cancelled,
}


def error_of(code: int, reason: str, cause: int = Cause.NONE, error_code: int = 0) -> Error:
    """The exception that stands for a result of the C face."""
    return _CLASSES[Code(code)](Code(code), reason, Cause(cause), error_code)
