"""The Python package on a line of simulated drives."""

import dataclasses
import os
import pathlib
import shutil
import signal
import sys
import tempfile
import threading
import unittest

from line import LONG, PROFILES, Line, cansync

from gateway import BIT_RATE, end


class OnALine(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.gateway = cls.enterClassContext(Line())
        cls.line = cls.enterClassContext(cls.gateway.connect())

    def error(self, kind, code, words, call, *arguments, cause=cansync.Cause.NONE, **options):
        """`call` raises this kind of error, with this code, cause and these words."""
        with self.assertRaises(kind) as caught:
            call(*arguments, **options)
        self.assertIs(caught.exception.code, code)
        self.assertEqual(caught.exception.reason, str(caught.exception))
        self.assertIn(words, caught.exception.reason)
        self.assertIs(caught.exception.cause, cause)
        return caught.exception

    def lead(self, references):
        """Gives reference values until the test is over: without them no drive sends actual values."""
        stop = threading.Event()

        def run():
            while not stop.wait(0.1):
                for telegram in (1, 2):
                    references.give(telegram, [0, None, None, None], release_intervals=1000)

        thread = threading.Thread(target=run)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(stop.set)


class State(OnALine):
    def test_status_is_that_of_the_line(self):
        status = self.line.status()
        self.assertEqual((status.option_status, status.slaves_synchronized), (0x80, 0b1111))
        self.assertEqual(dataclasses.asdict(status)["state"], "run")
        self.assertEqual(len(status.reference_value), 8)
        self.assertEqual(status.reference_value[0].name, "target")
        gateway = self.line.status(cansync.GatewayStatus)
        self.assertEqual((gateway.bus, gateway.protocol, len(gateway.daemon)), (self.gateway.bus, "cansync-master", 16))
        self.assertEqual(gateway.process, self.gateway.process.pid)
        bus = self.line.status(cansync.BusStatus)
        self.assertEqual((bus.bus_interface, bus.bit_rate), ("sim", BIT_RATE))
        self.assertIs(self.line.status(cansync.RealtimeStatus).realtime_enforced, False)
        self.error(cansync.Invalid, cansync.Code.INVALID, "topic", self.line.status, cansync.Event)
        self.error(cansync.Invalid, cansync.Code.INVALID, "no topic", self.line.status, int)

    def test_slaves_have_numbers_and_names(self):
        self.assertEqual([slave.slave for slave in self.line.slaves()], [0, 1, 2, 3])
        self.assertEqual(self.line.slave("winder"), 1)
        self.assertEqual(self.line.slave_status("winder").profile, "simulated-drive")
        self.error(cansync.Invalid, cansync.Code.INVALID, "no slave has this name", self.line.slave, "nobody")
        self.error(cansync.Timeout, cansync.Code.TIMEOUT, "no SlaveStatus of slave 9", self.line.slave_status, 9, timeout=0.1)

    def test_no_daemon_is_an_error_with_a_remedy(self):
        error = self.error(cansync.NotConnected, cansync.Code.NO_DAEMON, "is cansyncd running",
                           cansync.connect, "nobody", domain=self.gateway.domain, timeout=0.1)
        self.assertIsInstance(error, ConnectionError)

    def test_without_a_name_the_only_bus_is_taken(self):
        with cansync.connect("", domain=self.gateway.domain, timeout=LONG) as line:
            self.assertEqual(line.read(1, 100).raw, 4400)

    def test_a_closed_client_says_so(self):
        line = self.gateway.connect()
        job = line.submit_read(1, 100)
        job.result(LONG)
        line.close()
        line.close()
        self.error(cansync.Invalid, cansync.Code.INVALID, "closed", line.status)
        self.assertEqual(job.result().raw, 4400)  # a job is whole without its client


# Wrong in the width, as after another firmware: the drive has a doubleword there.
WRONG_WIDTH = """
[profile]
name = "of-another-firmware"

[[parameter]]
number = 430
name = "offset"
format = "word"
signed = true
factor = 0.1
access = "read-write"
"""


class Parameters(OnALine):
    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        profile = folder / "of-another-firmware.toml"
        profile.write_text(WRONG_WIDTH)
        shutil.copy(PROFILES / "simulated-drive.toml", folder)
        cls.gateway = cls.enterClassContext(Line("--set", f"slave.3.profile={profile}"))
        cls.line = cls.enterClassContext(cansync.connect(cls.gateway.bus, domain=cls.gateway.domain, timeout=LONG,
                                                         profiles=f"{folder}"))

    def test_a_width_that_is_not_the_profiles_is_an_error(self):
        before = self.line.read(3, 430).raw
        code = cansync.Code.DOUBLEWORD_EXPECTED
        self.error(cansync.SlaveError, code, "doubleword", self.line.read, 3, "offset")
        self.error(cansync.SlaveError, cansync.Code.SLAVE_ERROR, "slave: ", self.line.write, 3, "offset", -5)
        self.assertEqual(self.line.read(3, 430).raw, before)
        whatever = self.line.submit_read(3, "offset", format=1).result(LONG)
        self.assertEqual((whatever.value, whatever.name, whatever.doubleword), (before, "", True))

    def test_by_number_values_are_raw(self):
        self.line.write(2, 403, 65526)
        read = self.line.read(2, 403)
        self.assertEqual((read.value, read.raw, read.doubleword, read.name), (65526, 65526, False, ""))
        self.error(cansync.Invalid, cansync.Code.INVALID, "whole number", self.line.write, 2, 403, 1.5)
        self.error(cansync.Invalid, cansync.Code.INVALID, "number", self.line.read, 2, -1)

    def test_by_name_values_are_in_their_unit(self):
        self.line.write("winder", "torque-offset", -12.34)
        read = self.line.read("winder", "torque-offset")
        self.assertEqual((read.number, read.raw, read.name, read.unit), (403, 65413, "torque-offset", "%"))
        self.assertAlmostEqual(read.value, -12.3)
        self.assertEqual(str(read), "-12.3 %")

    def test_the_profile_is_there(self):
        parameters = self.line.parameters("winder")
        self.assertEqual([each.number for each in parameters], sorted(each.number for each in parameters))
        offset = self.line.parameter("winder", "torque-offset")
        self.assertIn(offset, parameters)
        self.assertEqual((offset.signed, offset.factor, offset.minimum), (True, 0.1, -1000))
        self.assertEqual(self.line.parameter(1, 4095).name, "")

    def test_what_the_profile_does_not_allow_is_not_sent(self):
        code = cansync.Code.REFUSED
        self.error(cansync.Refused, code, "client: ", self.line.write, 1, "torque-offset", 1000,
                   cause=cansync.Cause.PROFILE)
        self.error(cansync.Refused, code, "read-only", self.line.write, 1, "device-type", 1,
                   cause=cansync.Cause.PROFILE)
        self.error(cansync.Invalid, cansync.Code.INVALID, "no parameter 'nothing'", self.line.read, 1, "nothing")
        self.error(cansync.Invalid, cansync.Code.INVALID, "has no profile", self.line.read, 2, "torque-offset")

    def test_refusals_and_errors_of_the_slave(self):
        self.error(cansync.Refused, cansync.Code.REFUSED, "daemon: slave 9: not configured", self.line.read, 9, 100,
                   cause=cansync.Cause.SLAVE_NOT_CONFIGURED)
        error = self.error(cansync.SlaveError, cansync.Code.SLAVE_ERROR, "slave: ", self.line.read, 0, 3999)
        self.assertNotEqual(error.error_code, 0)

    def test_every_error_says_whether_asking_again_helps(self):
        error = self.error(cansync.Refused, cansync.Code.REFUSED, "4096", self.line.read, 0, 4096, cause=cansync.Cause.FIELD)
        self.assertIs(error.retry, cansync.Retry.NEVER)
        jobs = [self.line.submit_upload(3, 0x1000, 1 << 20) for _ in range(65)]
        error = self.error(cansync.Refused, cansync.Code.REFUSED, "queue full", jobs[-1].result,
                           cause=cansync.Cause.CLIENT_LIMIT)
        self.assertIs(error.retry, cansync.Retry.SOON)
        for job in jobs[:-1]:
            job.cancel()
        for job in jobs[:-1]:
            self.assertRaises(cansync.Error, job.result, LONG)

    def test_many_at_once(self):
        jobs = [self.line.submit_read(slave, 103) for slave in range(4) for _ in range(8)]
        self.assertEqual([job.result(LONG).raw for job in jobs], [slave for slave in range(4) for _ in range(8)])

    def test_threads_share_a_client(self):
        found = [None] * 4

        def work(slave):
            found[slave] = [self.line.read(slave, 103).raw for _ in range(10)]

        threads = [threading.Thread(target=work, args=(slave,)) for slave in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(LONG)
        self.assertEqual(found, [[slave] * 10 for slave in range(4)])


class Transfers(OnALine):
    def test_down_and_up_with_progress(self):
        data, told = bytes(range(256)) * 4, []
        self.line.download(2, 0x1000, data, lambda done, total: told.append((done, total)))
        self.assertEqual(self.line.upload(2, 0x1000, len(data)), data)
        self.assertEqual(told[-1][1], len(data))
        self.assertEqual(told, sorted(told))

    def test_cancelled(self):
        job = self.line.submit_upload(3, 0x1000, 1 << 20)
        self.error(cansync.Timeout, cansync.Code.TIMEOUT, "still open", job.result, 0.001)
        job.cancel()
        self.error(cansync.Cancelled, cansync.Code.CANCELLED, "", job.result, LONG)

        def stop(done, total):
            raise StopIteration

        self.assertRaises(StopIteration, self.line.upload, 3, 0x1000, 1 << 20, stop)

    def test_refused(self):
        self.error(cansync.Refused, cansync.Code.REFUSED, "address", self.line.upload, 2, 0x10, 4,
                   cause=cansync.Cause.ADDRESS)


class Topics(OnALine):
    def test_actual_values_come_while_references_are_given(self):
        self.lead(self.enterContext(self.line.references(3)))
        first = self.line.actual_values("winder", LONG)
        self.assertEqual((first.slave, first.slave_name), (1, "winder"))
        with self.line.follow(cansync.ActualValues, timeout=LONG) as stream:
            slaves = set()
            while slaves != {0, 1, 2, 3}:
                slaves.add(next(stream).slave)
            self.assertEqual(stream.dropped, 0)
        # The status tells it once a second.
        self.assertTrue(any(status.reference_release[0].strength == 3
                            for status in self.line.follow(cansync.MasterStatus, timeout=LONG)))

    def test_events_of_the_past_are_told(self):
        # A computer that stands still adds warnings of its own, so this asks for the one event alone.
        found = next(event for event in self.line.follow(cansync.Event, timeout=LONG)
                     if event.code == "all_synchronized")
        self.assertIs(found.severity, cansync.EventSeverity.INFO)

    def test_a_callback_is_called_until_it_is_closed(self):
        come, codes = threading.Event(), []

        def callback(event):
            codes.append(event.code)
            come.set()

        with self.line.subscribe(cansync.Event, callback):
            self.assertTrue(come.wait(LONG))
        self.assertTrue(codes)

    def test_what_a_callback_raises_is_told_and_harms_nothing(self):
        told, come = [], threading.Event()
        before, threading.excepthook = threading.excepthook, lambda hook: (told.append(hook.exc_value), come.set())
        self.addCleanup(setattr, threading, "excepthook", before)
        with self.line.subscribe(cansync.MasterStatus, lambda status: 1 / 0):
            self.assertTrue(come.wait(LONG))
        self.assertIsInstance(told[0], ZeroDivisionError)
        self.assertEqual(self.line.read(1, 103).raw, 1)

    def test_a_callback_cannot_wait(self):
        come, found = threading.Event(), []

        def callback(status):
            try:
                self.line.read(1, 103)
            except cansync.Error as error:
                found.append(error)
            come.set()

        with self.line.subscribe(cansync.MasterStatus, callback):
            self.assertTrue(come.wait(LONG))
        self.assertIn("may not wait", str(found[0]))

    def test_a_callback_can_close_itself(self):
        come, box = threading.Event(), []

        def callback(status):
            if box:
                box[0].close()
                come.set()

        box.append(self.line.subscribe(cansync.MasterStatus, callback))
        self.assertTrue(come.wait(LONG))

    def test_the_oldest_are_dropped_and_counted(self):
        events = self.line.follow(cansync.Event, depth=2)
        all_of_them = self.line.follow(cansync.Event, timeout=LONG)
        while next(all_of_them).code != "all_synchronized":
            pass
        self.gateway_waits_until(lambda: events.dropped > 0)
        events.close()
        self.assertLessEqual(len(list(events)), 2)

    def gateway_waits_until(self, condition):
        for _ in self.line.follow(cansync.MasterStatus, timeout=LONG):
            if condition():
                return

    def test_a_closed_stream_ends_who_waits(self):
        stream = self.line.follow(cansync.Interval)  # which is not switched on
        ended = threading.Event()

        def follow():
            list(stream)
            ended.set()

        thread = threading.Thread(target=follow)
        thread.start()
        stream.close()
        self.assertTrue(ended.wait(LONG))
        thread.join(LONG)

    def test_timing_and_wrong_topics(self):
        self.assertEqual(len(self.line.follow(cansync.Timing).get(LONG).slot), 6)
        self.error(cansync.Invalid, cansync.Code.INVALID, "allowed MasterStatus", self.line.follow, int)


class Commands(OnALine):
    def test_control_words_and_broadcasts(self):
        self.line.control_word("winder", 0x0F)
        self.assertEqual(self.line.read("winder", "control-word").raw, 0x0F)
        self.line.broadcast(["winder", 2], 200, data_byte=1)
        self.error(cansync.Refused, cansync.Code.REFUSED, "daemon: ", self.line.broadcast, [], 200,
                   cause=cansync.Cause.NO_SLAVES)
        self.error(cansync.Refused, cansync.Code.REFUSED, "not configured", self.line.control_word, 9, 1,
                   cause=cansync.Cause.SLAVE_NOT_CONFIGURED)

    def test_settings(self):
        self.line.set_mode(cansync.Mode.RUN)
        self.line.polling(one=2)
        self.line.cursors(transfer=cansync.AUTOMATIC)
        self.line.map_actuals(3, [0x01, 0x03, 0, 0, 0, 0, 0, 0])
        events = self.line.follow(cansync.SlaveStatus, timeout=LONG)
        self.assertTrue(any(each.slave == 3 and each.actual_mapping[:3] == b"\1\3\0" for each in events))
        self.line.polling(one=cansync.AUTOMATIC)
        self.error(cansync.Invalid, cansync.Code.INVALID, "allowed 8", self.line.map_references, [1])
        self.error(cansync.Refused, cansync.Code.REFUSED, "", self.line.release, 1,
                   cause=cansync.Cause.NOT_HELD)


class Reload(OnALine):
    def test_a_name_is_that_of_the_slave_that_has_it_now(self):
        self.assertEqual(self.line.slave("winder"), 1)
        path = pathlib.Path(self.gateway.config)
        text = path.read_text(encoding="utf-8")
        third = "[[slave]]\nnumber = 3\n"
        self.assertIn(third, text)
        path.write_text(text.replace('"winder"', '"unwinder"').replace(third, third + 'name = "winder"\n'), encoding="utf-8")
        os.kill(self.gateway.process.pid, signal.SIGHUP)
        for status in self.line.follow(cansync.SlaveStatus, timeout=LONG):
            if (status.slave, status.name) == (1, "unwinder"):
                break
        for status in self.line.follow(cansync.SlaveStatus, timeout=LONG):
            if (status.slave, status.name) == (3, "winder"):
                break
        self.assertEqual((self.line.slave("winder"), self.line.slave("unwinder")), (3, 1))
        come, found = threading.Event(), []
        with self.line.subscribe(cansync.MasterStatus, lambda status: (found.append(self.line.slave("winder")), come.set())):
            self.assertTrue(come.wait(LONG))
        self.assertEqual(found[0], 3)


class Restart(OnALine):
    def test_nothing_is_given_after_a_restart_until_it_is_taken_up(self):
        self.error(cansync.Invalid, cansync.Code.INVALID, "strength", self.line.references, -1)
        with self.line.references() as references:
            references.give(1, [7])
            before = self.line.status(cansync.GatewayStatus).daemon
            end(self.gateway.process)
            self.gateway.__enter__()
            for status in self.line.follow(cansync.GatewayStatus, timeout=LONG):
                if status.daemon != before:
                    break
            self.error(cansync.TakeUp, cansync.Code.TAKE_UP, "started anew", references.give, 1, [7])
            self.error(cansync.TakeUp, cansync.Code.TAKE_UP, "started anew", references.give, 1, [7])
            references.take_up()
            references.give(1, [7])
            self.line.wait_active(LONG)
            mapping = list(self.line.status().reference_mapping)
            number = self.line.status().mapping_number
            self.line.map_references(mapping[:3] + [0] + mapping[4:])
            for status in self.line.follow(cansync.MasterStatus, timeout=LONG):
                if status.mapping_number != number:
                    break
            self.error(cansync.TakeUp, cansync.Code.TAKE_UP, "mapping", references.give, 1, [7])
            self.error(cansync.Invalid, cansync.Code.INVALID, "1 to 4", references.give, 1, [])
            self.error(cansync.Invalid, cansync.Code.INVALID, "", references.give, 1, [1 << 40])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])
