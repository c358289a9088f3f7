"""CANsync lines that cansyncd serves.

    import cansync

    with cansync.connect("can0") as line:
        print(line.status().state)
        print(line.read("winder", "speed-limit"))
        line.write("winder", "speed-limit", 1500)
        for values in line.follow(cansync.ActualValues):
            print(values.slave, values.scaled[0])

:func:`connect` gives a :class:`Client`, whose methods are what can be done. What the daemon publishes are the classes of
:mod:`cansync.topics`. Whatever does not end as wanted raises an :class:`Error`. docs/python.md tells more.
"""

from ._link import text as _text
from ._native import lib as _lib
from .client import AUTOMATIC, NOBODY, UNCHANGED, Client, connect
from .codes import Cause, Code, Mode, Retry, SlaveEventKind, SlaveFault
from .errors import (Cancelled, Error, Invalid, NoData, NotConnected, OutcomeUnknown, Refused, SlaveError, TakeUp,
                     Timeout)
from .jobs import Job
from .parameters import Access, Parameter, Value
from .references import TAKE_OVER, References
from .slave import Application, SlaveEvent, SlaveState, connect_slave
from .streams import Stream, Subscription
from .topics import *  # noqa: F403
from .topics import __all__ as _topics

__version__ = _text(_lib.cansync_version())
__all__ = [
    "AUTOMATIC", "Access", "Application", "Cancelled", "Cause", "Client", "Code", "Error", "Invalid", "Job", "Mode", "NOBODY", "NoData",
    "NotConnected", "OutcomeUnknown", "Parameter", "Refused", "References", "Retry", "SlaveError", "SlaveEvent", "SlaveEventKind",
    "SlaveFault", "SlaveState", "Stream", "Subscription", "TAKE_OVER", "TakeUp", "Timeout", "UNCHANGED", "Value", "connect", "connect_slave",
]
__all__ += _topics
