"""The daemon as a cluster: a slave beside a simulated master above, the master of simulated drives below."""

import json
import unittest

from gateway import LONG, wait_for
from verb_case import DaemonTest

CONFIG = """
[bus]
protocol = "cansync-cluster"
name = "{bus}"
bit_rate = 250000
[dds]
domain = {domain}

[upper.slave]
number = 5
lock_time_ms = 50
[upper.sync]
holdover_ms = 100
[upper.sim]
fault_script = "faults.toml"
[[upper.sim.job]]       # the master above writes a parameter of the drive with CANsync number 101
number = 1
sub_slave = 101
parameter = 1000
value = 77
every = 40

[lower.sim]
lock_time_ms = 100
[[lower.slave]]
number = 0
[[lower.slave]]
number = 1
name = "winder"

[[sub_slave]]
number = 101
slave = 1

[[lead]]                # its reference value 0 is reference value 4 below
number = 4
value = 0
"""
# SYNC above is away for a while, longer than the holdover.
FAULTS = """
[[fault]]
kind = "missing_sync"
from = 600
to = 680
"""


class Cluster(DaemonTest):
    CONFIG = CONFIG
    FILES = {"faults.toml": FAULTS}

    def on(self, level, *arguments):
        """A verb on one of the two buses."""
        return self.place.run("--bus", f"{self.place.bus}.{level}", *arguments)

    def one(self, level, *arguments):
        """The only object of a verb."""
        result = self.on(level, *arguments, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def codes(self, level):
        """The codes of the events so far, and the texts."""
        lines = self.on(level, "events", "--json").stdout.splitlines()
        return [(event["code"], event["text"]) for event in map(json.loads, lines)]

    def test_both_buses_are_served_as_those_of_a_slave_and_of_a_master(self):
        self.assertEqual(self.on("lower", "wait", "run", "--timeout", LONG).returncode, 0)
        upper = wait_for("it is synchronized", lambda: (s := self.one("upper", "status"))["synchronized"] and s)
        lower = self.one("lower", "status")
        self.assertEqual((upper["protocol"], upper["slave_number"]), ("cansync-slave", 5))
        self.assertEqual((lower["protocol"], lower["process"]), ("cansync-master", upper["process"]))
        self.assertEqual(self.on("upper", "slave", "references").returncode, 0)

    def test_a_file_that_is_not_taken_is_told_on_both_buses(self):
        wait_for("it runs", lambda: self.on("upper", "status").returncode == 0)
        self.reload_something_wrong()
        for level in ("upper", "lower"):
            wait_for(f"the {level} bus tells it", lambda: "reload_refused" in dict(self.codes(level)))

    def test_the_master_above_writes_a_parameter_of_a_drive_below(self):
        read = lambda: self.on("lower", "read", "winder", "1000", "--json")
        wait_for("the drive has it", lambda: (r := read()).returncode == 0 and json.loads(r.stdout)["value"] == 77)

    def test_the_lead_axis_gives_its_telegram_and_nobody_else_may(self):
        wait_for("it gives", lambda: ("references_released", 2) in [
            (code, int(text.split("telegram ")[1][0])) for code, text in self.codes("lower") if code == "references_released"])
        refused = self.on("lower", "set", "4=5", "--seconds", "0.3")
        self.assertIn("telegram 2 is given by the lead axis, and no program may", refused.stderr)
        shown = self.on("lower", "status").stdout.decode()
        self.assertRegex(shown, "reference telegram 2  .*given by the lead axis\n")
        self.assertEqual([one["writer"] for one in self.one("lower", "status")["reference_release"]], ["", "the lead axis"])

    def test_the_status_of_the_slave_says_what_the_cluster_does(self):
        status = wait_for("jobs went down and values were given", lambda: (s := self.one("upper", "status"))["jobs_below"] > 1
                          and s["lead_given"][1] > 10 and s)
        self.assertEqual((status["cluster_number"], status["lead_given"][0], status["unknown_below"]), (0, 0, 0))
        self.assertIn(status["cluster_state"], ("active", "setting_up", "waiting_for_sync"))
        self.assertRegex(self.on("upper", "status").stdout.decode(), "cluster .* jobs and 0 blocks went down, .*lead axis: WRC2 given")

    def test_the_lower_bus_stops_with_the_sync_above_and_begins_again(self):
        def course():
            texts = [text for code, text in self.codes("lower") if code == "state_changed"]
            stopped = next((n for n, text in enumerate(texts) if "'run' to 'start-up'" in text), len(texts))
            return any("to 'run'" in text for text in texts[stopped:])
        wait_for("the lower bus was stopped and is active again", course)
        self.assertIn("sync_lost", {code for code, _ in self.codes("upper")})
        # More than once where the machine stood still for longer than the holdover.
        wait_for("it is counted", lambda: self.one("upper", "status")["sync_stops"] >= 1)


if __name__ == "__main__":
    unittest.main()
