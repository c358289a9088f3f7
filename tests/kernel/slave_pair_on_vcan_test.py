"""Master and slave of ours as two daemons on vcan0."""

import unittest

from canline import INTERFACE, create_interface
from slave_pair import SlavePair


class PairOnVcan(SlavePair, unittest.TestCase):
    interfaces = (INTERFACE, INTERFACE)
    tolerance = 500

    def setUp(self):
        create_interface()
