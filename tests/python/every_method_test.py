"""Every public method of the package's classes ends within a time, whatever the daemon does and from whatever callback.

The methods are taken from the classes: a new one is called without a line here. One with a parameter that has neither a
default nor a value in VALUES fails the test.
"""

import inspect
import os
import signal
import sys
import threading
import time
import typing
import unittest

from line import LONG, Line, cansync

from gateway import end_at_once

# By the name of a parameter. Waits are short; a transfer's monitoring time is the daemon's, and with that its end.
VALUES = {"slave": "winder", "number_or_name": 100, "parameter": 100, "value": 1, "address": 0x100, "size": 4, "data": b"\1\2\3\4",
          "word": 0x87, "slaves": [1], "action": 130, "mode": cansync.Mode.RUN, "mapping": [1, 0, 0, 0, 0, 0, 0, 0],
          "topic": cansync.MasterStatus, "callback": lambda sample: None, "timeout": 0.05, "telegram": 1, "values": [0]}
# Seconds after which a call has no end. The longest that is documented is a request that nobody answers: its monitoring time
# and five seconds.
MOST = 40.0
# They end what the others are called on.
ENDS = {"close"}


def methods(one: object) -> list[tuple[str, typing.Callable[[], object]]]:
    """The public methods of an object, ready to be called."""
    found = []
    for name, method in inspect.getmembers(one, inspect.ismethod):
        if name.startswith("_") or name in ENDS:
            continue
        given = {}
        for parameter in inspect.signature(method).parameters.values():
            if parameter.name in VALUES:
                given[parameter.name] = VALUES[parameter.name]
            elif parameter.default is parameter.empty:
                raise AssertionError(f"{type(one).__name__}.{name}: parameter {parameter.name} has no value in VALUES")
        found.append((f"{type(one).__name__}.{name}", lambda method=method, given=given: method(**given)))
    return found


def call_all(line: cansync.Client, where: str, faults: list[str]) -> None:
    """Calls everything from this thread."""
    objects: list[object] = [line]
    for make in (lambda: line.references(), lambda: line.submit_read("winder", 100, timeout=0.05),
                 lambda: line.follow(cansync.MasterStatus, timeout=0.05)):
        try:
            objects.append(make())
        except cansync.Error:
            pass  # nobody is there, or it is a callback, where the same is called as a method
    for one in objects:
        for name, call in methods(one):
            began, words = time.monotonic(), ""
            try:
                call()
            except cansync.Error as error:
                words = str(error)
            if time.monotonic() - began > MOST:
                faults.append(f"{where}: {name} took {time.monotonic() - began:.1f} s")
            if "data model" in words or "it speaks" in words:  # the daemon is of this build
                faults.append(f"{where}: {name} says: {words}")
        if hasattr(one, "close") and one is not line:
            one.close()


class Every(unittest.TestCase):
    def setUp(self):
        self.gateway = self.enterContext(Line())
        self.line = self.enterContext(self.gateway.connect())
        self.faults = []

    def call_all_while(self, where, daemon_does):
        """From two threads."""
        threads = [threading.Thread(target=call_all, args=(self.line, where, self.faults)) for _ in range(2)]
        for thread in threads:
            thread.start()
        daemon_does(threads)
        for thread in threads:
            thread.join(5 * LONG)
            self.assertFalse(thread.is_alive(), where)
        self.assertEqual(self.faults, [])

    def test_with_a_daemon_that_answers(self):
        self.call_all_while("answers", lambda threads: None)

    def test_with_a_daemon_that_stands_still(self):
        os.kill(self.gateway.process.pid, signal.SIGSTOP)
        self.addCleanup(os.kill, self.gateway.process.pid, signal.SIGCONT)
        self.call_all_while("stands still", lambda threads: None)

    def test_with_a_daemon_that_dies_and_comes_back(self):
        def die_and_come_back(threads):
            while any(thread.is_alive() for thread in threads):
                time.sleep(0.3)
                end_at_once(self.gateway.process)
                time.sleep(0.3)
                self.gateway.__enter__()

        self.call_all_while("dies and comes back", die_and_come_back)

    def test_with_a_daemon_that_is_gone(self):
        end_at_once(self.gateway.process)
        call_all(self.line, "gone", self.faults)
        self.assertEqual(self.faults, [])
        self.gateway.__enter__()

    def test_from_each_callback_and_beside_it(self):
        for topic in (cansync.MasterStatus, cansync.SlaveStatus, cansync.GatewayStatus, cansync.BusStatus,
                      cansync.RealtimeStatus, cansync.Event, cansync.Timing):
            with self.subTest(topic=topic.__name__):
                done = threading.Event()
                beside = threading.Thread(target=call_all, args=(self.line, f"beside a callback of {topic.__name__}", self.faults))

                def callback(sample, done=done, beside=beside, name=topic.__name__):
                    if beside.ident is None:
                        beside.start()
                        call_all(self.line, f"in a callback of {name}", self.faults)
                        done.set()

                with self.line.subscribe(topic, callback):
                    self.assertTrue(done.wait(LONG))
                    beside.join(5 * LONG)
                    self.assertFalse(beside.is_alive())
        self.line.upload("winder", 0x100, 4, progress=lambda done, total: call_all(self.line, "in a progress", self.faults))
        self.assertEqual(self.faults, [])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])
