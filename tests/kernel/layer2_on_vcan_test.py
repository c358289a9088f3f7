"""General frames on a real CAN socket: what cansyncd publishes and sends, against another program on the bus."""

import select
import signal
import unittest

from canline import Candump, GeneralFrames, Wire, create_interface
from gateway import wait_for

RANGES = """[[receive]]
number = 0
first = 0x100
last = 0x1FF
[[receive]]
number = 1
extended = true
kinds = "remote"
"""


class FramesOnVcan(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        create_interface()
        cls.log = cls.enterClassContext(Candump())
        cls.daemon = cls.enterClassContext(GeneralFrames(RANGES))
        cls.wire = cls.enterClassContext(Wire())

    def sent(self, *arguments):
        """The object of a frame that was sent."""
        return self.daemon.objects("can", "send", *arguments)[0]

    def test_frames_of_every_kind_are_on_the_bus_as_candump_sees_them(self):
        for frame in ("7FF#0102030405060708", "18DAF110#FF", "123#R3", "001ABCDE#R"):
            self.assertEqual(self.sent(frame)["result"], "done")
            self.log.wait_for_frame(frame)
            self.assertEqual(self.log.frames().count(frame), 1, frame)

    def test_frames_of_others_come_through_the_ranges(self):
        self.sent("001#")  # the daemon runs
        with self.daemon.start("can", "dump", "--json") as frames:
            # Until the program listens.
            wait_for("a frame comes", lambda: self.wire.send("150#AA") or frames_wait(frames))
            for frame in ("0FF#01", "100#02", "18DAF110#03", "0000ABCD#R", "1FF#04"):
                self.wire.send(frame)
            found = []
            while not found or found[-1][0] != 0x1FF:
                object_ = frames.next_object()
                if object_["identifier"] != 0x150:
                    found.append((object_["identifier"], object_["extended"], object_["remote"], object_["range"]))
            frames.send_signal(signal.SIGINT)
        self.assertEqual(found, [(0x100, False, False, 0), (0xABCD, True, True, 1), (0x1FF, False, False, 0)])


def frames_wait(frames):
    """An object of the program; None when none came for a while."""
    return frames.next_object() if select.select([frames.stdout], [], [], 0.5)[0] else None
