"""Drives that are not the ones expected: two of one number, an exchanged pair, one that is not configured."""

import unittest

from canline import Master, Simulator, create_interface, delete_interface

SERIAL = 102  # of a simulated drive: 1000 and its number
IN_SETUP = 0x0043


class Exchanged(Master):
    """A line whose drives 0 and 1 have changed places."""

    def role(self):
        return super().role().replace("number = 0\n", f'number = 0\nexpect = ["{SERIAL}=1001"]\n').replace(
            "number = 1\n", f'number = 1\nexpect = ["{SERIAL}=1000"]\n')


class WhichDrive(unittest.TestCase):
    def setUp(self):
        create_interface()
        self.addCleanup(delete_interface)

    def test_two_drives_of_one_number_keep_the_line_from_run(self):
        with Simulator(slaves="0-1"), Simulator(slaves="1-1"), Master(2) as daemon:
            event = daemon.wait_event("duplicate_slave")[0]
            self.assertEqual((event["slave"], event["severity"]), (1, "error"))
            status = daemon.wait_status("it is named", lambda s: s["slaves_duplicate"] == 0b10)
            self.assertEqual(status["option_status"], IN_SETUP)
            self.assertIn("two drives answer as slave 1", daemon.run("doctor").stdout.decode())
            self.assertEqual(daemon.objects("slaves", 1)[0]["state"], "held")

    def test_an_exchanged_pair_is_held_and_a_stranger_is_named(self):
        with Simulator(slaves="0-2,9"), Exchanged(3) as daemon:
            daemon.wait_event("unknown_slave")
            daemon.wait_status("both are held", lambda s: s["slaves_wrong"] == 0b011 and s["slaves_unknown"] == 1 << 9)
            daemon.wait_status("the third is ready, and run is not entered",
                               lambda s: s["slaves_released"] == 0b100 and s["option_status"] == IN_SETUP)
            held = daemon.objects("slaves", 0)[0]["held_reason"]
            self.assertEqual(held, f"not the drive expected: parameter {SERIAL}, expected 1001 (0x3E9), found 1000 (0x3E8)")


if __name__ == "__main__":
    unittest.main()
