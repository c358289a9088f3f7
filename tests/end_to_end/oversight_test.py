"""Looking after what others do, as processes: jobs, cancel, clients and buses."""

import os
import re
import signal
import tempfile
import time
import unittest

from gateway import LONG, Gateway, wait_for
from verb_case import DATA, VerbTest

# Bytes that take minutes.
MANY = 4_000_000


class Oversight(VerbTest):
    BIT_RATE = 500000

    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory())

    def path(self, name):
        return os.path.join(self.folder, name)

    def upload(self, slave, name, *options):
        return self.gateway.start("upload", slave, hex(DATA), MANY, self.path(name), *options)

    def jobs(self, fits):
        """The open jobs, once they fit."""
        return wait_for("the jobs fit", lambda: (lambda found: (found,) if fits(found) else None)(self.json("jobs")))[0]

    def ended(self, process, code):
        out, err = process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, code, err)
        return err.decode()

    def test_a_transfer_says_what_it_waits_for_and_another_may_end_it(self):
        with self.upload("winder", "first") as first:
            (running,) = self.jobs(lambda found: len(found) == 1 and found[0]["done"] > 0)
            self.assertFalse(running["waits"])
            self.assertIn("upload 4000000 bytes from", running["text"])
            self.assertIn("winder", running["text"])
            self.assertIn(f"'cansync' (cansync, process {first.pid} on host ", running["owner"])
            with self.upload("winder", "second") as second:
                _, waiting = self.jobs(lambda found: len(found) == 2)
                self.assertEqual((waiting["waits"], waiting["behind"]), (True, running["job"]))
                self.assertRegex(self.text("jobs"), rf"{waiting['job']} +behind {running['job']} ")
                # Its first words come within a second or two; then the first one is ended by somebody else.
                said = second.next_line(second.stderr).decode()
                self.assertRegex(said, rf"^cansync: waiting for job {running['job']}, upload 4000000 bytes from .*winder.* of "
                                       rf"'cansync' \(cansync, process {first.pid} on host .*\), which is at \d+ %; ")
                self.assertIn(f"`cansync cancel {running['job']}`", said)
                ended = self.one("cancel", running["job"])
                self.assertEqual(ended["result"], "done")
                self.assertIn("upload 4000000 bytes", ended["ended"])
                self.assertIn("cancel", self.ended(first, 7))
                (now,) = self.jobs(lambda found: len(found) == 1 and not found[0]["waits"])
                self.assertEqual(now["job"], waiting["job"])
                self.run_verb("cancel", now["job"])
                self.ended(second, 7)
        self.jobs(lambda found: not found)
        told = [event for event in self.json("events") if event.get("action") == "job_end"]
        self.assertIn("upload 4000000 bytes", told[-1]["old_value"])

    def test_timeout_bounds_the_wait_for_a_turn(self):
        with self.upload(0, "first") as first:
            self.jobs(lambda found: len(found) == 1 and found[0]["done"] > 0)
            began = time.monotonic()
            with self.upload(0, "second", "--timeout", "5") as second:
                said = self.ended(second, 5)
            self.assertIn("its turn did not come within 5 s (--timeout); nothing was sent", said)
            self.assertLess(time.monotonic() - began, LONG / 2)
            first.send_signal(signal.SIGINT)
            self.ended(first, 7)
        self.assertFalse(os.path.exists(self.path("second")))

    def test_a_job_that_is_not_there(self):
        self.assertIn("no request is open under that number", self.fails("cancel", 999999, code=3))
        self.assertEqual(self.one("cancel", 999999, code=3)["cause"], "unknown_job")
        self.assertIn("JOB: found 'x'", self.fails("cancel", "x", code=2))

    def test_who_is_connected(self):
        with self.gateway.start("events", "--follow") as looks, self.upload(2, "long") as asks:
            def both():
                found = {client["process"]: client for client in self.json("clients")}
                return found if {looks.pid, asks.pid} <= set(found) and found[asks.pid]["open"] == 1 else None

            found = wait_for("both are there", both)
            self.assertEqual((found[looks.pid]["name"], found[looks.pid]["open"]), ("", 0))
            self.assertEqual((found[asks.pid]["name"], found[asks.pid]["program"]), ("cansync", "cansync"))
            self.assertRegex(self.text("clients"), rf"cansync +cansync +{asks.pid} +\S+ +1\n")
            for process in (looks, asks):
                process.send_signal(signal.SIGINT)
            self.ended(asks, 7)
            self.ended(looks, 0)

    def test_the_daemons_of_all_buses(self):
        (own,) = self.json("buses")
        self.assertEqual((own["bus"], own["protocol"], own["slaves_responding"]), (self.gateway.bus, "cansync-master", 4))
        self.assertEqual(own["process"], self.gateway.process.pid)
        self.assertEqual(own["state"], "run")
        second = Gateway(slaves=2)
        second.domain = self.gateway.domain
        second.options += ["--set", f"dds.domain={self.gateway.domain}"]
        second.environment["CANSYNC_DOMAIN"] = str(self.gateway.domain)
        with second:
            found = {bus["bus"]: bus for bus in self.json("buses")}
            self.assertEqual(set(found), {self.gateway.bus, second.bus})
            self.assertEqual(found[second.bus]["slaves_configured"], 2)
            self.assertRegex(self.text("buses"), rf"{re.escape(second.bus)} +cansync-master +\S.* 2 of 2 ")


if __name__ == "__main__":
    unittest.main()
