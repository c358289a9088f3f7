"""cansync-sim on a real kernel, with a master of a few lines."""

import subprocess
import unittest

from canline import CANSYNC_SIM, INTERFACE, LONG, SYNC, Candump, Process, Simulator, Wire, create_interface, delete_interface, ip


class SimulatorOnVcan(unittest.TestCase):
    def setUp(self):
        create_interface()

    def read_number(self, wire, slave):
        """Reads parameter 103, the slave number, and returns the answer's data."""
        return wire.ask(f"{0x500 + slave:03X}#70670000")

    def test_every_slave_answers_parameters(self):
        with Simulator(slaves="0-31"), Wire() as wire:
            for slave in range(32):
                wire.send(SYNC + "#")
                self.assertEqual(self.read_number(wire, slave), f"0067{slave:02X}000000")

    def test_actual_values_of_the_polled_slave(self):
        with Simulator(), Wire() as wire:
            # An answer past its slot is left out, and here nobody keeps the slots: again until both come.
            answers = set()
            while len(answers) < 2:
                wire.send(SYNC + "#")
                wire.send("102#0000000000000000")
                wire.send("182#0000000000000000")
                while (answer := wire.receive(0.2)) is not None:
                    answers.add(answer)
            self.assertEqual(sorted(answer[:4] for answer in answers), ["302#", "382#"])
            self.assertIn("302#0000000000000000", answers, "position and speed of a drive that stands")

    def test_a_simulated_master_brings_simulated_drives_to_active_operation(self):
        with Simulator(), Candump() as log, Simulator("--master", "--reference", "0=74565") as master:
            for slave in range(4):
                master.wait_text(f"slave {slave}: released")
            master.wait_text("state: run")
            log.wait_for_frame("010#FFFFFFFF02010000")
            log.wait_for_frame("101#4523010000000000")
            self.assertEqual(master.stop(), 0)
        self.assertRegex(master.text(), "master in state 'run', [1-9][0-9]* SYNC")

    def test_a_device_of_a_script(self):
        with open("/dev/shm/device.toml", "w", encoding="utf-8") as file:
            file.write('[[answer]]\nto = "601#40"\nframe = "581#4301"\nafter_ms = 1\n[[answer]]\nto = "18DAF110#R"\nframe = "18DA10F1#02"\n'
                       '[[periodic]]\nframe = "181#00"\nevery_ms = 20\ncounting_byte = 0\n')
        with Process(CANSYNC_SIM, INTERFACE, "--device", file.name) as device, Candump() as log, Wire() as wire:
            device.wait_text("2 answers, 1 frame sent again and again")
            for asked, answer in (("601#40AA", "581#4301"), ("18DAF110#R", "18DA10F1#02")):
                wire.send(asked)
                log.wait_for_frame(answer)
            log.wait_for_frame("181#03")
            self.assertEqual(device.stop(), 0)
            counted = [int(frame[4:], 16) for frame in log.frames() if frame.startswith("181#")]
        self.assertRegex(device.text(), r"\d+ frames? received, \d+ sent, 0 not sent")
        self.assertEqual(counted, list(range(counted[0], counted[0] + len(counted))))

    def test_fault_script(self):
        with open("/dev/shm/faults.toml", "w", encoding="utf-8") as file:
            file.write('[[fault]]\nkind = "wrong_answer"\nslave = 1\ncount = 1\n'
                       '[[fault]]\nkind = "inject"\nframe = "7AB#0102"\nfrom = 1\ncount = 1\n'
                       '[[fault]]\nkind = "silent"\nslave = 3\n')
        with Simulator("--faults", file.name), Candump() as log, Wire() as wire:
            wire.send(SYNC + "#")
            self.assertEqual(self.read_number(wire, 1), "006801000000", "names the next parameter")
            self.assertEqual(self.read_number(wire, 1), "006701000000")
            wire.send(SYNC + "#")
            self.assertEqual(wire.receive_from("7AB"), "7AB#0102")
            wire.send("503#70670000")
            # Whoever is silent can only be seen by what others answer after it.
            self.assertEqual(self.read_number(wire, 2), "006702000000")
            self.assertEqual([frame for frame in log.frames() if frame.startswith("583#")], [])

    def test_impossible_faults_are_refused(self):
        with open("/dev/shm/faults.toml", "w", encoding="utf-8") as file:
            file.write('[[fault]]\nkind = "corrupted"\n')
        result = subprocess.run([CANSYNC_SIM, INTERFACE, "--faults", file.name], capture_output=True, text=True,
                                timeout=LONG)
        self.assertEqual(result.returncode, 2)
        self.assertIn("faults.toml:2:8: kind = \"corrupted\": a drive cannot destroy a frame", result.stderr)

    def test_missing_interface_is_an_error_with_its_remedy(self):
        delete_interface()
        result = subprocess.run([CANSYNC_SIM, INTERFACE], capture_output=True, text=True, timeout=LONG)
        self.assertEqual(result.returncode, 1)
        self.assertIn("vcan0 does not exist", result.stderr)
        self.assertIn("ip link add dev vcan0 type vcan", result.stderr)

    def test_cable_pulled_and_interface_deleted(self):
        with Simulator() as simulator:
            ip("link", "set", INTERFACE, "down")
            simulator.wait_text("vcan0 is down; waiting")
            ip("link", "set", INTERFACE, "up")
            simulator.wait_text("vcan0 is up")
            with Wire() as wire:
                self.assertEqual(self.read_number(wire, 3), "006703000000")
            delete_interface()
            simulator.wait_text("vcan0 does not exist; waiting")
            create_interface()
            simulator.wait_text("vcan0 is up", count=2)
            with Wire() as wire:
                self.assertEqual(self.read_number(wire, 3), "006703000000")
            # One line for each state: the new interface may have been seen before it was up.
            self.assertLessEqual(simulator.text().count("waiting for it"), 3, simulator.text())

    def test_survives_garbage_and_ends_with_a_summary(self):
        with Simulator() as simulator:
            # Every kind of frame, as fast as it goes; identifiers of CANsync and lengths 0..8 among them.
            subprocess.run(["cangen", INTERFACE, "-n", "1500", "-g", "0", "-m", "-i"], check=True, timeout=LONG)
            with Wire() as wire:
                wire.send(SYNC + "#")
                self.assertEqual(self.read_number(wire, 2), "006702000000")
            self.assertEqual(simulator.stop(), 0, simulator.text())
            self.assertIn("4 drives, ", simulator.text().splitlines()[-1])
