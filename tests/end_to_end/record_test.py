"""`record` against the simulated line, `plot` of what it wrote, and the pictures of the documentation."""

import csv
import json
import os
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "pictures"))
from terminal import Terminal

from gateway import CANSYNC, LONG, Place, wait_for
from verb_case import VerbTest

COLUMNS = ["time", "seconds", "receive_time_ns", "interval", "slave", "name"]
SVG = "{http://www.w3.org/2000/svg}"


def texts(picture):
    """Every text of an SVG file, and the file itself."""
    root = xml.parse(picture).getroot()
    if root.tag != SVG + "svg":
        raise AssertionError(f"{picture} is no SVG")
    return ["".join(text.itertext()).strip() for text in root.iter(SVG + "text")], root


class Record(VerbTest):
    EXTRA = "[process]\npoll_without_reference = true\n"  # there is something to record without a writer

    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory())
        self.path = os.path.join(self.folder, "line.csv")

    def rows(self):
        with open(self.path, encoding="utf-8", newline="") as file:
            return list(csv.reader(file))

    def enough(self, count=50):
        wait_for("rows in the file", lambda: os.path.exists(self.path) and len(self.rows()) > count)

    def test_every_value_of_every_slave_for_a_while(self):
        summary = self.one("record", self.path, "--duration", 1)
        heading, *rows = self.rows()
        self.assertEqual(heading[:8], [*COLUMNS, "value0", "position [mm]"])
        self.assertEqual(heading[6:], summary["values"])
        self.assertEqual((summary["rows"], summary["ended"], summary["dropped"]), (len(rows), "duration", 0))
        self.assertGreaterEqual(summary["seconds"], 1)
        self.assertEqual({row[4] for row in rows}, {"0", "1", "2", "3"})
        intervals = [int(row[3]) for row in rows]
        self.assertEqual(intervals, sorted(intervals))
        self.assertEqual({row[5] for row in rows if row[4] == "1"}, {"winder"})
        for row in rows:
            self.assertEqual(row[6] != "" and row[7] != "", False, "a slave has the one or the other")
            self.assertAlmostEqual((int(row[2]) - int(rows[0][2])) / 1e9, float(row[1]), places=5)

    def test_chosen_slaves_and_values_raw_and_thinned_out(self):
        self.one("record", self.path, "winder", "--values", "position", "--raw", "--every", 5, "--duration", 1)
        heading, *rows = self.rows()
        self.assertEqual(heading[6:], ["position [raw]"])
        self.assertEqual({row[5] for row in rows}, {"winder"})
        for before, after in zip(rows, rows[1:]):
            self.assertGreaterEqual(int(after[3]) - int(before[3]), 5 * self.SLAVES)

    def test_to_standard_output(self):
        lines = self.text("record", "-", "winder", "--duration", 0.5).splitlines()
        self.assertEqual(lines[0].split(",")[:6], COLUMNS)
        self.assertGreater(len(lines), 1)

    def test_ctrl_c_ends_it_well(self):
        process = self.gateway.start("record", self.path)
        self.enough()
        _, remarks = self.interrupt(process, code=0)
        self.assertRegex(remarks, r"\d+ rows in [\d.]+ s, \d+ turns? missing")

    def test_killed_it_leaves_whole_rows_that_can_be_plotted(self):
        with self.gateway.start("record", self.path) as process:
            self.enough(200)
            process.kill()
        with open(self.path, "ab") as file:  # the worst that a kill could leave
            file.write(b"2026-01-01T00:00:00Z,1.5,17")
        result = self.run_verb("plot", self.path, "--output", os.path.join(self.folder, "p.svg"))
        self.assertIn("the last line is not complete and is left out", result.stderr)

    def test_progress_on_a_terminal(self):
        with Terminal([CANSYNC, "record", self.path], self.gateway.environment) as terminal:
            terminal.wait("progress", lambda text: " rows " in text and "Ctrl-C ends" in text)
            terminal.press("ctrl-c")
            self.assertEqual(terminal.end(), 0)

    def test_refusals(self):
        self.assertIn("--values: found 'nonsense'; allowed, of these slaves: ",
                      self.fails("record", self.path, "--values", "nonsense", code=2))
        self.assertIn("--duration: found '0'", self.fails("record", self.path, "--duration", 0, code=2))
        self.assertIn("standard output", self.fails("record", "-", "--json", code=2))
        self.assertFalse(os.path.exists(self.path), "nothing was begun")
        self.assertIn("/no/such", self.fails("record", "/no/such/file.csv", code=1))
        self.assertIn("No space left", self.fails("record", "/dev/full", code=1))


class Plot(unittest.TestCase):
    """Without a daemon."""

    RECORDING = ",".join(COLUMNS) + ",position [mm],torque [%]\n" + "".join(
        f"t,{i / 100},1,{i},{i % 2},{('winder', '')[i % 2]},{i},{-i}\n" for i in range(1000))

    def setUp(self):
        self.place = Place()
        self.folder = self.enterContext(tempfile.TemporaryDirectory())
        self.recording = os.path.join(self.folder, "line.csv")
        self.picture = os.path.join(self.folder, "plot.svg")
        self.write(self.RECORDING)

    def write(self, text):
        with open(self.recording, "w", encoding="utf-8") as file:
            file.write(text)

    def plot(self, *arguments, code=0):
        result = self.place.run("plot", self.recording, "-o", self.picture, *arguments)
        self.assertEqual(result.returncode, code, result.stderr)
        return result

    def test_a_panel_for_each_value_and_a_curve_for_each_slave(self):
        told = json.loads(self.plot("--title", "A test & more", "--json").stdout)
        self.assertEqual(told, {"file": self.recording, "output": self.picture, "slaves": [0, 1],
                                "values": ["position [mm]", "torque [%]"], "rows": 1000})
        shown, root = texts(self.picture)
        for text in ("A test & more", "position [mm]", "torque [%]", "winder", "slave 1", "time in s"):
            self.assertIn(text, shown)
        curves = [path for path in root.iter(SVG + "path") if path.get("d", "").count("L") > 400]
        self.assertEqual(len(curves), 4)

    def test_chosen_values_and_slaves(self):
        self.plot("--values", "torque", "--slaves", "winder")
        shown, _ = texts(self.picture)
        self.assertIn("torque [%]", shown)
        self.assertFalse({"position [mm]", "slave 1"} & set(shown))

    def test_png(self):
        self.picture = os.path.join(self.folder, "plot.png")
        self.plot()
        with open(self.picture, "rb") as file:
            self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")

    def test_wrong_files_are_told_with_line_and_column(self):
        self.write(self.RECORDING + "t,1,1,1,0,winder,x,1\n")
        self.assertIn(f"{self.recording}: line 1002, column 18: position [mm]: found 'x'", self.plot(code=1).stderr)
        self.write("no recording\n")
        self.assertIn("line 1, column 1", self.plot(code=1).stderr)
        self.assertIn("No such file", self.place.run("plot", "/no/such.csv", "-o", self.picture).stderr)
        self.picture = "plot.pdf"
        self.assertIn("allowed: a name that ends with .svg or .png", self.plot(code=2).stderr)

    def test_without_gnuplot_it_says_what_to_install(self):
        self.place.environment["PATH"] = self.folder
        self.assertIn("apt install gnuplot-nox", self.plot(code=1).stderr)
        self.assertFalse(os.path.exists(self.picture))


class Pictures(unittest.TestCase):
    """The pictures of docs/img are made again and hold what they are there to show."""

    @classmethod
    def setUpClass(cls):
        cls.folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        make = os.path.join(os.path.dirname(__file__), "..", "pictures", "make.py")
        result = subprocess.run([sys.executable, "-B", make, cls.folder], capture_output=True, text=True,
                                timeout=3 * LONG, check=False)
        if result.returncode != 0:
            raise AssertionError(result.stdout + result.stderr)

    def shown(self, name):
        """What the new picture and the one of the documentation both show, as one text each."""
        kept = os.path.join(os.path.dirname(__file__), "..", "..", "docs", "img", name)
        for path in (os.path.join(self.folder, name), kept):
            words, root = texts(path)
            yield " ".join(words), root

    def test_timing(self):
        for text, root in self.shown("timing.svg"):
            for part in ("SYNC", "WRC1", "RDC2", "CC", "time after SYNC in us", "500000 bit/s"):
                self.assertIn(part, text)
            self.assertGreater(len(list(root.iter(SVG + "rect"))), 10)

    def test_plot(self):
        for text, root in self.shown("plot.svg"):
            for part in ("position [rev]", "speed [rpm]", "torque [%]", "unwinder", "registration-1", "dancer-1", "time in s"):
                self.assertIn(part, text)
            curves = [path for path in root.iter(SVG + "path") if path.get("d", "").count("L") > 30]
            self.assertEqual(len(curves), 9)

    def test_watch(self):
        for text, root in self.shown("watch.svg"):
            for part in ("unwinder", "registration-1", "released", "position rev", "speed rpm", "Bus load", "p99.9",
                         "LAST EVENTS", "quit"):
                self.assertIn(part, text)
            trends = [box for box in root.iter(SVG + "rect") if box.get("fill") == "#56c8d8"]
            self.assertGreater(len({box.get("height") for box in trends}), 5, "trends that go up")

    def test_screens_of_two_sizes(self):
        for text, _ in self.shown("watch-80x24.svg"):
            for part in ("press-", "run", "unwinder", "released", "missed", "late", "left out", "wake-up", "position rev", "speed rpm",
                         "Bus load", "values further away", "LAST EVENTS", "raw"):
                self.assertIn(part, text)
        for text, _ in self.shown("watch-120x40.svg"):
            for part in ("synchronized", "unwinder", "position rev", "speed rpm", "p99.9", "AGE ms", "ANSWERS", "LAST EVENTS"):
                self.assertIn(part, text)
        for name, columns in (("slaves-80x24.svg", 80), ("slaves-120x40.svg", 120)):
            for text, root in self.shown(name):
                for part in ("$ cansync slaves", "SLAVE NAME STATE RESPONDS SYNCHRONIZED STATUS", "dancer-1", "fault", "--wide shows"):
                    self.assertIn(part, text)
                self.assertEqual(float(root.get("width")), round(columns * 8.4 + 24), name)
                red = [word for word in root.iter(SVG + "text") if word.get("fill") == "#ff6b6b"]
                self.assertIn("dancer-1", [word.text for word in red])
        for size in ("80x24", "120x40"):
            for text, _ in self.shown(f"jobs-{size}.svg"):
                for part in ("$ cansync jobs", "STATE", "upload 60000 bytes", "dancer-1", "behind ", "unwinder", "WHOSE"):
                    # A terminal breaks long lines in the middle of a word.
                    self.assertIn(part.replace(" ", ""), text.replace(" ", ""))
            for text, _ in self.shown(f"doctor-{size}.svg"):
                for part in ("idle states", "DDS places"):
                    self.assertIn(part, text)
                self.assertRegex(text, r"errors?: [^;]*drive fault")
        for text, _ in self.shown("doctor-120x40.svg"):
            for part in ("$ cansync doctor", "LEVEL TOPIC FOUND", "dancer-1", "error"):
                self.assertIn(part, text)


if __name__ == "__main__":
    unittest.main()
