"""The daemon as a slave answers the simulated master's parameter jobs and transfers."""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import unittest

from gateway import CANSYNCD, LONG, Place, end, identities, wait_for

CONFIG = """
[bus]
protocol = "cansync-slave"
name = "{bus}"
bit_rate = 250000
[dds]
domain = {domain}
{security}
[slave]
number = 5
lock_time_ms = 50
{extra}
[sim]
trace = "{trace}"
"""

TABLE = """
[[parameter]]
number = 400
value = 7
maximum = 100
[[parameter]]
number = 401
format = "doubleword"
value = 0x12345678
access = "read_only"
"""


OWN = """
[[parameter]]
number = 400
value = 55
[[parameter]]
number = 500
format = "doubleword"
value = 0x89ABCDEF
"""
CANCELLED = 0x0103  # nothing of the block moved for the slave's monitoring time
READ_OF_THE_TABLE = "019007000000"
READ_OF_THE_APPLICATION = "019037000000"


def jobs(*kinds):
    """What the simulated master asks again and again."""
    return "".join(f"[[sim.job]]\nnumber = {number}\nevery = 20\n{kind}\n" for number, kind in enumerate(kinds))


class Slave:
    """A daemon that is a slave beside a simulated master; a context manager."""

    def __init__(self, text, extra="", security=""):
        self.place = Place()
        self.folder = tempfile.TemporaryDirectory(prefix="cansync_test_")
        self.trace = os.path.join(self.folder.name, "trace")
        self.config = os.path.join(self.folder.name, "bus.toml")
        with open(self.config, "w", encoding="utf-8") as file:
            file.write(CONFIG.format(bus=self.place.bus, domain=self.place.domain, trace=self.trace, extra=extra,
                                     security=security) + text)

    def __enter__(self):
        with open(os.path.join(self.folder.name, "log"), "wb") as log:
            self.process = subprocess.Popen([CANSYNCD, self.config], stdout=log, stderr=log)
        return self

    def __exit__(self, *_):
        self.place.look_no_more()
        end(self.process)
        self.folder.cleanup()

    def frames(self, identifier):
        """The data of every frame of this identifier that is in the trace so far."""
        with open(self.trace, encoding="ascii") as file:
            return re.findall(rf" {identifier:03X}#([0-9A-F]*)\n", file.read())

    def answers(self):
        return self.frames(0x585)

    def wait_for_answers(self, what, *wanted):
        """Until each of the answers has come again from now on."""
        wait_for("the line runs", lambda: os.path.exists(self.trace))
        before = len(self.answers())
        wait_for(what, lambda: set(wanted) <= set(self.answers()[before:]))

    def status(self):
        """The daemon's status, or None while it cannot be had."""
        return self.place.look("status", daemon=self.process.pid)

    def wait_for_status(self, what, condition=lambda status: True):
        return wait_for(what, lambda: (status := self.status()) and condition(status) and status, pause=0.1)

    def wait_for_event(self, code, *words):
        """With one of the words in its text."""
        def there():
            lines = self.place.run("events", "--json").stdout.splitlines()
            found = [event["text"] for event in map(json.loads, lines) if event["code"] == code]
            return any(one in text for text in found for one in words)
        wait_for(f"event {code}: {words}", there)

    def serve(self, *arguments):
        """`cansync serve` with OWN."""
        path = os.path.join(self.folder.name, "own.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(OWN)
        return self.place.start("slave", "serve", path, "--json", *arguments)


class ParameterTable(unittest.TestCase):
    def test_the_table_answers_without_an_application(self):
        asked = jobs("parameter = 400", "parameter = 400\nvalue = 100", "parameter = 400\nvalue = 101", "parameter = 401",
                     "parameter = 401\nvalue = 1", "parameter = 399", "bytes = 20")
        with Slave(TABLE + asked) as slave:
            # M 3.2.3.7: the value; above its maximum; a doubleword; not changeable; not available now; not possible.
            expected = {"01900700" + "0000", "01906400" + "0000", "2190FDFF" + "0000", "019178563412" + "0000",
                        "2191FCFF" + "0000", "218FFAFF" + "0000", "A0000401"}
            wait_for("all are answered", lambda: os.path.exists(slave.trace) and expected <= set(slave.answers()))
            status = slave.wait_for_status("it is shown")
            self.assertEqual((status["parameters"], status["application"]), (2, ""))


class Profile(unittest.TestCase):
    """A profile gives numbers, formats, limits and names."""

    FILE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "config", "profiles", "simulated-drive.toml")

    def test_it_answers_without_an_application_and_names_what_one_answers(self):
        # 401: a doubleword of at least 1; its own value at the start; below the profile's minimum; a number it does not have.
        own = "[[parameter]]\nnumber = 401\nvalue = 9\n"
        asked = jobs("parameter = 401", "parameter = 401\nvalue = 0", "parameter = 999", "parameter = 301")
        with Slave(own + asked, extra=f'profile = "{self.FILE}"') as slave:
            slave.wait_for_answers("the table answers", "019109000000" + "0000", "23E7FAFF0000")
            status = slave.wait_for_status("it is synchronized", lambda status: status["synchronized"])
            self.assertEqual(status["profile"], "simulated-drive")
            self.assertRegex(status["profile_hash"], "^[0-9a-f]{64}$")
            with slave.place.start("slave", "serve", "--profile", self.FILE, "--json", "--count", "2") as serving:
                out, err = serving.communicate(timeout=LONG)
            self.assertEqual(serving.returncode, 0, err)
            self.assertEqual({json.loads(line)["name"] for line in out.splitlines()}, {"speed-limit"})

    def test_what_contradicts_it_is_told_with_its_place(self):
        slave = Slave("[[parameter]]\nnumber = 401\nformat = \"word\"\n", extra=f'profile = "{self.FILE}"')
        with slave.folder:
            result = subprocess.run([CANSYNCD, "--check", slave.config], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(result.returncode, 78, result.stderr)
        self.assertIn("parameter.401.format: found another format than that of speed-limit in the profile", result.stderr)


class Application(unittest.TestCase):
    def test_it_takes_numbers_over_and_gives_them_back(self):
        with Slave(TABLE + jobs("parameter = 400", "parameter = 500", "parameter = 401")) as slave:
            slave.wait_for_answers("the table answers", READ_OF_THE_TABLE, "21F4FAFF0000")
            with slave.serve() as serving:
                slave.wait_for_answers("busy, then the application", "4190", READ_OF_THE_APPLICATION, "01F4EFCDAB890000",
                                       "019178563412" + "0000")
                kinds = {(found["kind"], found["number"], found["raw"], found["error_code"])
                         for found in (serving.next_object() for _ in range(6))}
                self.assertEqual(kinds, {("read", 400, 55, 0), ("read", 500, 0x89ABCDEF - 2**32, 0)})
                status = slave.wait_for_status("it is shown", lambda s: s["jobs_answered"] > 0)
                self.assertEqual(status["taken_over"], 2)
                self.assertIn("cansync", status["application"])
                self.assertRegex(slave.place.run("status").stdout.decode(), r"(?m)^parameters +2 in .*; 2 taken over by ")
                serving.send_signal(signal.SIGINT)
                serving.communicate(timeout=LONG)
                self.assertEqual(serving.returncode, 0)
            slave.wait_for_event("application_lost", "gives up")
            slave.wait_for_answers("the table answers again", READ_OF_THE_TABLE, "21F4FAFF0000")
            slave.wait_for_status("nobody is there", lambda s: s["application"] == "")

    def test_when_it_is_killed_the_slave_answers_as_configured(self):
        error = "\n[[parameter]]\nnumber = 500\nformat = \"doubleword\"\nerror_without_application = 0xFFFF\n"
        with Slave(TABLE + error + jobs("parameter = 400", "parameter = 500")) as slave, slave.serve() as serving:
            slave.wait_for_answers("the application answers", READ_OF_THE_APPLICATION, "01F4EFCDAB890000")
            serving.kill()
            # DDS cannot tell a program that was killed from one that is suspended.
            slave.wait_for_event("application_lost", "is silent", "has gone without giving up")
            slave.wait_for_answers("the table and the error", READ_OF_THE_TABLE, "21F4FFFF0000")

    def test_its_open_job_ends_when_it_stands_still_and_when_it_dies(self):
        # What is written is not what is read: a write that came before the application would change the table's value.
        with Slave(TABLE + jobs("parameter = 400", "parameter = 500\nvalue = 9"), "answer_time_ms = 500") as slave, \
                slave.serve() as serving:
            before = slave.wait_for_status("it is shown")["jobs_dropped"]

            def stands_still():
                serving.send_signal(signal.SIGCONT)
                slave.wait_for_answers("the application answers", READ_OF_THE_APPLICATION)
                serving.send_signal(signal.SIGSTOP)
                # Its open read of 400 is the table's now, what is open of 500 an error.
                slave.wait_for_answers("answered without it", READ_OF_THE_TABLE, "21F4FAFF0000")
                answered = slave.wait_for_status("it is shown")["interval"]
                later = slave.wait_for_status("a later one is shown", lambda s: s["interval"] > answered)
                # None is where the application was missed on a slow machine while nothing was asked of it.
                return later["jobs_dropped"] > before

            wait_for("its job is dropped", stands_still)
            slave.wait_for_event("application_lost", "is silent")
            serving.send_signal(signal.SIGCONT)
            slave.wait_for_answers("it continues, and is asked again", READ_OF_THE_APPLICATION)
            serving.kill()
            slave.wait_for_status("it is missed, and nothing is open", lambda s: s["application"] == ""
                                  and s["jobs"] == s["jobs_answered"] + s["jobs_dropped"])

    def test_a_stronger_one_answers_and_a_weaker_one_takes_over_when_it_dies(self):
        with Slave(TABLE + jobs("parameter = 500")) as slave:
            with slave.serve("--strength", 5) as weaker:
                slave.wait_for_answers("the weaker answers", "01F4EFCDAB890000")
                path = os.path.join(slave.folder.name, "stronger.toml")
                with open(path, "w", encoding="utf-8") as file:
                    file.write("[[parameter]]\nnumber = 500\nvalue = 2\n")
                with slave.place.start("slave", "serve", path, "--json", "--strength", 6) as stronger:
                    slave.wait_for_answers("the stronger answers", "01F402000000")
                    slave.wait_for_event("application_began", "in place of")
                    stronger.send_signal(signal.SIGINT)
                    answered = [json.loads(line) for line in stronger.communicate(timeout=LONG)[0].splitlines()]
                slave.wait_for_answers("the weaker answers again", "01F4EFCDAB890000")
                weaker.send_signal(signal.SIGINT)
                mine = {one["job"] for one in map(json.loads, weaker.communicate(timeout=LONG)[0].splitlines()) if not one["dropped"]}
                others = {one["job"] for one in answered if not one["dropped"]}
                self.assertTrue(mine and others)
                self.assertFalse(mine & others, "each job was answered by one of them, and is shown by that one")

    def test_who_is_not_heard_is_told(self):
        with tempfile.TemporaryDirectory() as folder, Slave(TABLE) as slave:
            own, status_word = os.path.join(folder, "own.toml"), os.path.join(folder, "status.toml")
            with open(own, "w", encoding="utf-8") as file:
                file.write(OWN)
            with open(status_word, "w", encoding="utf-8") as file:
                file.write("[[parameter]]\nnumber = 301\n")
            def says(words, *arguments):
                with open(os.path.join(folder, "said"), "w+", encoding="utf-8") as said:
                    with slave.place.start("slave", "serve", *arguments, stderr=said) as server:
                        wait_for(words, lambda: words in open(said.name, encoding="utf-8").read())
                        end(server)
            says("the daemon does not take this application; `cansync events` has the reason", status_word)
            with slave.place.start("slave", "serve", own, "--strength", 5) as stronger:
                says("this application waits", own)
                end(stronger)

    def test_the_file_is_checked(self):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("[[parameter]]\nnumber = 1\nvalue = 65536\n")
            file.flush()
            result = Place().run("slave", "serve", file.name)
            self.assertEqual(result.returncode, 2)
            self.assertIn(f"{file.name}:3:9: parameter.1.value: found 65536; allowed: 0..65535", result.stderr)


class Blocks(unittest.TestCase):
    def moved(self, length, options):
        down = f"bytes = {length}\ndownload = true"
        up = f"bytes = {length}"
        with Slave(TABLE + jobs(down, up), options) as slave:
            slave.wait_for_answers("not possible without an application", "A0000401")
            with slave.serve("--blocks") as serving:
                done = set()
                while len(done) < 2:
                    found = serving.next_object()
                    if found["error_code"] == 0:
                        done.add((found["kind"], found["number"], found["raw"]))
                self.assertEqual(done, {("download", 0x100, length), ("upload", 0x100, length)})
                status = slave.wait_for_status("it is counted", lambda s: s["blocks_done"] >= 2)
                self.assertTrue(status["takes_blocks"])
                serving.kill()
            slave.wait_for_answers("not possible when it is gone", "A0000401")
            # Byte n is n: the last telegram of the upload brings the end of it.
            tail = "".join(f"{n % 256:02X}" for n in range(length - length % 6, length))
            self.assertTrue(any(answer[4:].startswith(tail) for answer in slave.answers()), tail)

    def test_an_upload_of_less_than_lies_there_is_refused_where_it_goes_as_a_whole(self):
        with Slave(jobs("bytes = 400\ndownload = true", "bytes = 20"), "block_limit = 1000") as slave, \
                slave.serve("--blocks") as serving:
            seen = []
            while ("download", 0) not in seen or seen[-1] != ("upload", 0x0104):
                found = serving.next_object()
                seen.append((found["kind"], found["error_code"]))
            self.assertNotIn(("upload", 0), seen)
            slave.wait_for_answers("not possible", "A0000401")
            serving.kill()

    def test_blocks_are_kept_under_16_start_addresses(self):
        # Different periods: else a full queue of the master would leave out the same ones each time.
        asked = "".join(f"[[sim.job]]\nnumber = {n}\nevery = {50 + n}\nbytes = 6\ndownload = true\naddress = {0x100 + n}\n"
                        for n in range(17))
        with Slave(asked) as slave, slave.serve("--blocks") as serving:
            done, refused = set(), set()
            while len(done | refused) < 17:
                found = serving.next_object()
                if found["error_code"] == CANCELLED:  # the machine was too slow for it; the master tries again
                    continue
                self.assertIn(found["error_code"], (0, 0x0104))
                (refused if found["error_code"] else done).add(found["number"])
            self.assertEqual((len(done), len(refused)), (16, 1))
            self.assertEqual(done & refused, set(), "one that is there may be replaced")
            serving.kill()

    def test_a_block_of_299_bytes_goes_as_a_whole(self):
        self.moved(299, "block_limit = 300")

    def test_a_longer_one_goes_telegram_by_telegram(self):
        self.moved(400, "block_limit = 1000")

    def test_without_the_area_a_short_one_does_too(self):
        self.moved(20, "block_area = false")


class Secured(unittest.TestCase):
    def test_an_engineer_answers_and_an_operator_releases(self):
        with tempfile.TemporaryDirectory(prefix="cansync_security_") as folder:
            authority = identities(folder)
            slave = Slave(TABLE + jobs("parameter = 400"), security=f'security = "{authority}/daemon"')
            become = lambda role: slave.place.become(os.path.join(authority, role))
            become("viewer")
            with slave:
                wait_for("the viewer sees values", lambda: slave.place.run("slave", "references").returncode == 0)
                result = slave.place.run("slave", "actual", "0=1", "--seconds", 1)
                self.assertIn("no right to write topic ActualRelease", result.stderr)
                become("operator")
                with slave.place.start("slave", "actual", "0=1") as writer:
                    slave.wait_for_status("released", lambda s: s["released"][0] > 0)
                    end(writer)
                path = os.path.join(folder, "own.toml")
                with open(path, "w", encoding="utf-8") as file:
                    file.write(OWN)
                result = slave.place.run("slave", "serve", path)
                self.assertIn("no right to write topic ApplicationAnswer", result.stderr)
                become("engineer")
                self.assertEqual(slave.place.run("slave", "serve", path, "--count", 1).returncode, 0)


class ActualValues(unittest.TestCase):
    def test_when_their_writer_is_killed_none_is_sent_any_more(self):
        with Slave("") as slave:
            slave.wait_for_status("it is synchronized", lambda s: s["synchronized"])
            with slave.place.start("slave", "actual", "0=1000", "--rate", 50, "--wait", 1000) as writing:
                slave.wait_for_status("they go out", lambda s: s["actual_sent"][0] > 3)
                writing.kill()
            slave.wait_for_event("actual_writer_lost", "is silent", "has gone without giving up")
            # The withdrawal follows within an interval; what was asked for before is on the bus by then.
            began = slave.wait_for_status("it is shown")["interval"]
            first = slave.wait_for_status("some intervals pass", lambda s: s["interval"] > began + 5)
            later = slave.wait_for_status("more pass", lambda s: s["interval"] > first["interval"] + 50)
            self.assertEqual(later["actual_sent"], first["actual_sent"])
            self.assertGreater(later["not_released"][0], first["not_released"][0] + 40)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *filter(None, sys.argv[1:])])
