"""A program of Fast DDS 2.x, as Debian 12 has it, against the daemon with dds.types = "final"."""

import os
import select
import subprocess
import time
import unittest

from gateway import LONG, NEVER_MISSING_REFERENCES, Gateway, end, wait_for

CLIENT = os.environ["FASTDDS_CLIENT"]
HERE = os.path.dirname(os.path.abspath(__file__))
PROFILE = os.path.join(HERE, "..", "..", "tools", "examples", "fastdds_profile.xml")
SLAVES = 32


class FastDdsTest(unittest.TestCase):
    def client(self, *arguments):
        process = subprocess.Popen([CLIENT, str(self.gateway.domain), self.gateway.bus, *map(str, arguments)],
                                   env=self.gateway.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, bufsize=0)
        self.addCleanup(self.end, process)
        return process

    @staticmethod
    def end(process):
        process.kill()
        process.communicate(timeout=LONG)

    def line(self, process):
        """The next line of a client; whatever it said, when it has ended."""
        self.assertTrue(select.select([process.stdout], [], [], LONG)[0], "the client says nothing")
        return process.stdout.readline().decode().strip()


class FinalTypes(FastDdsTest):
    @classmethod
    def setUpClass(cls):
        cls.gateway = Gateway(slaves=SLAVES, bit_rate=1000000, options=["--set", "dds.types=final", *NEVER_MISSING_REFERENCES],
                              extra="[process]\npoll_without_reference = true\n")
        cls.gateway.environment.update(CANSYNC_TYPES="final", FASTRTPS_DEFAULT_PROFILES_FILE=PROFILE)
        cls.enterClassContext(cls.gateway)

    def test_1_state_parameters_transfers_and_a_cancel(self):
        process = self.client("use")
        out = process.communicate(timeout=LONG)[0].decode()
        print(out)
        self.assertEqual(process.returncode, 0, out)

    def released_of(self, strength):
        """Waits until reference values are released of the writer with that strength, and no other."""
        def look(status):
            release = status["reference_release"][0]
            return release["state"] == "released" and release["strength"] == strength \
                and f"'fastdds-{strength}'" in release["writer"]
        self.gateway.wait_status(f"the values of strength {strength} are released", look)

    def follows(self, value):
        """Waits until the drives have the position that was given."""
        def look():
            slave = self.gateway.json("watch", 0, "--count", 1)[0]
            return slave["values"][0]["raw"] == value
        wait_for(f"a drive is at {value}", look)

    def test_2_a_writer_of_reference_values_is_heard_until_a_stronger_one_comes(self):
        weak = self.client("lead", 10, 1000)
        self.assertEqual(self.line(weak), "leads")
        self.released_of(10)
        self.follows(1000)
        strong = self.client("lead", 20, 2000)
        self.assertEqual(self.line(strong), "leads")
        self.released_of(20)
        self.follows(2000)
        equal = self.client("lead", 20, 3000)
        self.assertEqual(self.line(equal), "leads")
        # The status names the weak one, which waits longest.
        wait_for("it is told that the equal one waits", lambda: [
            event for event in self.gateway.json("events")
            if event["code"] == "writer_waits" and f"process {equal.pid} " in event["text"].split(" waits for ")[0]])
        self.follows(2000)
        equal.kill()
        strong.kill()
        self.released_of(10)
        self.follows(1000)

    def test_3_our_own_programs_with_the_other_types_are_told_so(self):
        environment = dict(self.gateway.environment)
        del self.gateway.environment["CANSYNC_TYPES"]
        try:
            result = self.gateway.run("--timeout", 3, "status")
        finally:
            self.gateway.environment = environment
        self.assertEqual(result.returncode, 6, result.stderr)
        self.assertIn('dds.types', result.stderr)

    def test_4_a_clean_stop_is_seen_at_once(self):
        process = self.client("look")
        self.assertEqual(self.line(process), "there")
        began = time.monotonic()
        self.assertEqual(end(self.gateway.process), 0)
        ended = time.monotonic() - began
        self.assertEqual(self.line(process), "gone")
        took = time.monotonic() - began
        print(f"the daemon ended {ended:.3f} s after SIGTERM, which was seen after {took:.3f} s")
        # By the daemon's last words, not by its lease of 5 s.
        self.assertLess(took - ended, 2.5)


class AppendableTypes(FastDdsTest):
    @classmethod
    def setUpClass(cls):
        cls.gateway = Gateway(slaves=1)
        cls.gateway.environment.update(FASTRTPS_DEFAULT_PROFILES_FILE=PROFILE)
        cls.enterClassContext(cls.gateway)

    def test_what_matches_nothing_is_named_though_the_other_side_says_that_it_matched(self):
        process = self.client("look")
        self.assertEqual(self.line(process), "there")

        def told():
            return [event for event in self.gateway.json("events") if event["code"] == "dds_incompatible"]

        event = wait_for("the daemon tells of it", told)[0]
        self.assertIn("a reader of topic GatewayStatus of ", event["text"])
        self.assertIn(f"process {process.pid} on host ", event["text"])
        # Behind the name Fast DDS tells a number.
        self.assertNotRegex(event["text"], r"on host \S*:\d")
        self.assertIn("data representation (offered XCDR2, asked for XCDR1)", event["text"])
        self.assertRegex(event["participant"], "^[0-9a-f]{32}$")

        def found():
            doctor = self.gateway.run("doctor", "--json").stdout.decode()
            return "dds_incompatible" in doctor

        wait_for("doctor finds it", found)


if __name__ == "__main__":
    unittest.main()
