"""The metrics file of a running daemon: both formats' parsers take it, and its numbers are those of the topics."""

import math
import os
import re
import sys
import tempfile
import unittest

from gateway import Gateway, wait_for

# Debian's packages, whichever interpreter runs this; after its own.
sys.path.append("/usr/lib/python3/dist-packages")
from prometheus_client.openmetrics.parser import text_string_to_metric_families as parse_openmetrics
from prometheus_client.parser import text_string_to_metric_families as parse_text

SECONDS = 10**9


def documented():
    """(metric, type, labels, source) of each row of docs/metrics.md that a master has."""
    path = os.path.join(os.path.dirname(__file__), "..", "..", "docs", "metrics.md")
    with open(path, encoding="utf-8") as file:
        text = file.read().split("\n## Of a slave\n")[0]
    return re.findall(r"(?m)^\| `(\w+)` \| (\w+) \| ([\w, ]*) \| `([^`]+)` \|", text)


# What goes up and down from moment to moment, so that a look before and one after prove nothing.
CHANGING = {"cansync_slave_last_response_seconds", "cansync_open_parameter_jobs", "cansync_open_transfers"}


def value_of(look, source, labels, metric):
    """The number that `cansync` shows for the source; None when it shows none."""
    topic, _, member = source.partition(".")
    sample = look.get(topic)
    if topic == "SlaveStatus":
        sample = sample[labels["slave"]]
    if sample is None:
        return None
    member = member.replace("...", labels.get("kind", labels.get("reason", "")))
    value = next((sample[key] for key in (member, member + "_ns", member + "_interval") if key in sample), None)
    if "state" in labels and isinstance(value, str):
        return int(value == labels["state"])
    if not isinstance(value, (int, float)):
        return None
    if metric.startswith("cansync_slaves_"):
        return bin(value).count("1")
    return value / SECONDS if metric.endswith("_seconds") else value


class Metrics(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="cansync_metrics_")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.file = os.path.join(cls.folder.name, "line.prom")
        cls.gateway = Gateway(slaves=3, extra=f'[metrics]\nfile = "{cls.file}"\nperiod_s = 1\n')
        cls.gateway.__enter__()
        cls.addClassCleanup(cls.gateway.__exit__)

    def text(self):
        with open(self.file, encoding="utf-8") as file:
            return file.read()

    def newer(self):
        """The file's text, written later than now."""
        before = os.stat(self.file).st_ino, os.stat(self.file).st_mtime_ns

        def renewed():
            now = os.stat(self.file)
            return (now.st_ino, now.st_mtime_ns) != before

        wait_for("the metrics file is written again", renewed)
        return self.text()

    def with_timing(self):
        """The file as soon as a second's timing is in it."""
        return wait_for("the file has the timing", lambda: "lateness_seconds_count" in self.newer() and self.text())

    def samples(self, text):
        """(name, labels) of each sample, with its value."""
        return {(sample.name, tuple(sorted(sample.labels.items()))): sample.value
                for family in parse_openmetrics(text) for sample in family.samples}

    def test_both_formats(self):
        text = self.with_timing()
        strict = {family.name: family for family in parse_openmetrics(text)}
        older = {sample.name: sample for family in parse_text(text) for sample in family.samples}
        self.assertTrue(text.endswith("# EOF\n"))
        for family in strict.values():
            self.assertTrue(family.documentation, family.name)
            self.assertIn(family.type, ("gauge", "counter", "histogram"), family.name)
            for sample in family.samples:
                self.assertEqual(sample.labels["bus"], self.gateway.bus)
                self.assertIn(sample.name, older)
            for unit in ("seconds", "ratio", "bits_per_second"):
                if family.name.endswith("_" + unit):
                    self.assertEqual(family.unit, unit)
        self.assertEqual(os.stat(self.file).st_mode & 0o777, 0o644)

    def test_the_histogram_counts_up(self):
        histogram = [family for family in parse_openmetrics(self.with_timing()) if family.type == "histogram"]
        self.assertEqual([family.name for family in histogram], ["cansync_sync_lateness_seconds"])
        buckets = [(float(s.labels["le"]), s.value) for s in histogram[0].samples if s.name.endswith("_bucket")]
        rest = {s.name.rsplit("_", 1)[1]: s.value for s in histogram[0].samples if not s.name.endswith("_bucket")}
        self.assertEqual([bound for bound, _ in buckets], [2**n / 10**6 for n in range(15)] + [math.inf])
        counts = [count for _, count in buckets]
        self.assertEqual(counts, sorted(counts))
        self.assertEqual(counts[-1], rest["count"])
        self.assertGreater(rest["count"], 0)
        least = sum((high - low) * bound for low, high, bound in
                    zip(counts, counts[1:], [bound for bound, _ in buckets[:-1]]))
        self.assertGreaterEqual(rest["sum"], least * 0.999999)

    def test_every_metric_is_the_topics(self):
        """What a topic said before and after the file was written has the file's number between."""
        self.with_timing()
        before = self.look()
        metrics = self.samples(self.newer())
        after = self.look()
        sources = {metric: (kind, source) for metric, kind, _, source in documented()}
        compared = set()
        for (metric, pairs), value in metrics.items():
            if metric.startswith("cansync_sync_lateness_seconds"):
                continue
            kind, source = sources[metric]
            first, last = (value_of(look, source, dict(pairs), metric) for look in (before, after))
            if first is None or last is None or metric in CHANGING:
                continue
            compared.add(metric)
            if kind == "counter" or metric.endswith("interval"):
                self.assertTrue(first <= value <= last, f"{metric} {pairs}: {first} <= {value} <= {last}")
            elif first == last:
                self.assertEqual(value, first, f"{metric} {pairs}")
        self.assertGreaterEqual(len(compared), 50, sorted(compared))

    def look(self):
        status = self.gateway.status()
        return {**dict.fromkeys(("GatewayStatus", "BusStatus", "RealtimeStatus", "MasterStatus"), status),
                "SlaveStatus": {str(slave["slave"]): slave for slave in self.gateway.json("slaves")}}

    def test_what_is_documented_is_there_and_the_other_way_round(self):
        present = {re.sub("_(bucket|sum|count)$", "", name) for name, _ in self.samples(self.with_timing())}
        # Slots without a telegram have no start.
        rows = {metric for metric, _, _, _ in documented()}
        self.assertEqual({m for m in present ^ rows if not m.startswith("cansync_slot_start_")}, set())


class Failures(unittest.TestCase):
    def test_a_folder_that_is_missing_stops_nothing(self):
        with tempfile.TemporaryDirectory(prefix="cansync_metrics_") as folder:
            path = os.path.join(folder, "later", "line.prom")
            with Gateway(slaves=1, extra=f'[metrics]\nfile = "{path}"\nperiod_s = 1\n') as gateway:
                codes = lambda: [event["code"] for event in gateway.json("events")]
                wait_for("the failure is told", lambda: "metrics_not_written" in codes())
                self.assertIn("later/line.prom cannot be written: No such file or directory", gateway.log_text())
                os.mkdir(os.path.dirname(path))
                wait_for("the file is there", lambda: os.path.exists(path))
                wait_for("the end is told", lambda: "metrics_written_again" in codes())
                self.assertEqual(codes().count("metrics_not_written"), 1, "told once")
                with open(path, encoding="utf-8") as file:
                    failures = re.search(r"metrics_write_failures_total\S* (\d+)", file.read())
                self.assertGreaterEqual(int(failures[1]), 1)
                self.assertEqual(gateway.stop(), 0)
                self.assertFalse(os.path.exists(path), "nobody renews it any more")


if __name__ == "__main__":
    unittest.main(verbosity=2)
