"""The journal: every entry can be found by its fields, and explains itself."""

import unittest

from machine import *


class Journal(unittest.TestCase):
    def test_1_who_wrote_a_parameter(self):
        run("cansync", "write", "axis-1", "20", "1234", expect=None)
        entries = wait_for("the entry of the write", lambda: journal("BUS=vcan0", "SLAVE=1", "PARAMETER=20"))
        self.assertTrue(entries[-1]["CLIENT"], entries[-1])
        self.assertEqual(entries[-1]["_SYSTEMD_UNIT"], SERVICE)

    def test_2_events_by_name_and_id(self):
        entries = wait_for("an event", lambda: journal("EVENT=slave_responds"))
        self.assertIn(entries[-1]["SLAVE"], ("0", "1"))
        same = journal(f"MESSAGE_ID={entries[-1]['MESSAGE_ID']}")
        self.assertEqual({entry["EVENT"] for entry in same}, {"slave_responds"})

    def test_3_the_catalog_explains_cause_and_remedy(self):
        entry = journal("EVENT=slave_responds")[-1]
        text = run("journalctl", "--catalog", "--no-pager", f"MESSAGE_ID={entry['MESSAGE_ID']}")
        self.assertRegex(text, "Subject: .*vcan0")
        self.assertIn("Remedy:", text)
