"""Judges a CANsync line by what `candump -L` wrote of it, with the rules and numbers of the manual (M 3.1.1, 3.2.0.1, 3.2.1).

Nothing of the decoders under test is used. The software SYNC frame stands for the edge; where frames take no time, as on
vcan and on emulated controllers, the time of a line is both the frame's start and its end.
"""

import bisect
import dataclasses

SYNC = 0x080  # the software SYNC frame, which is not of the manual
ACTION, COMMAND, RESPONSE = 0x010, 0x500, 0x580
REFERENCE, ACTUAL = (0x100, 0x180), (0x300, 0x380)  # WRC1 and WRC2, RDC1 and RDC2
NAMES = {SYNC: "SYNC", ACTION: "action", COMMAND: "CC", RESPONSE: "RC", 0x100: "WRC1", 0x180: "WRC2", 0x300: "RDC1", 0x380: "RDC2"}
WORDS = (0, 2, 4, 6, 8)
LENGTHS = {SYNC: (0,), ACTION: (8,), COMMAND: (2, 4, 6, 8), RESPONSE: (2, 4, 6, 8), 0x100: WORDS, 0x180: WORDS, 0x300: WORDS, 0x380: WORDS}
SLAVES = 32


@dataclasses.dataclass(frozen=True)
class Times:
    """us after the edge, each the latest start; `answer`: tRSPTO, from the end of a command."""

    interval: int
    response: int
    actual: tuple
    command: int
    answer: int


TIMES = {
    1000000: Times(1000, 210, (520, 820), 950, 300),
    500000: Times(2000, 460, (1060, 1630), 1890, 600),
    250000: Times(4000, 900, (2100, 3290), 3810, 1100),
    125000: Times(8000, 1920, (4310, 6640), 7680, 2100),
}


@dataclasses.dataclass(frozen=True)
class Seen:
    """A frame; `at` in us, `text` as candump wrote it."""

    at: int
    text: str

    @property
    def identifier(self):
        return int(self.text.split("#")[0], 16)

    @property
    def channel(self):
        """The identifier without the number; None: none of CANsync."""
        if len(self.text.split("#")[0]) != 3 or self.text.split("#")[1].startswith("R"):
            return None
        found = self.identifier if self.identifier in (SYNC, ACTION) else self.identifier & ~0x7F
        return found if found in NAMES else None

    @property
    def number(self):
        return self.identifier & 0x7F

    @property
    def data(self):
        return bytes.fromhex(self.text.split("#")[1])


def read(lines):
    """The frames in lines of `candump -L`, by their time: what two processors took from a controller may stand in the log
    the other way round."""
    def seen(line):
        time, _, text = line.split()[:3]
        return Seen(int(time.strip("()").replace(".", "")), text)

    return sorted(map(seen, lines), key=lambda frame: frame.at)


class Judge:
    """Judges all lines at once. `wrong`: what was, in words; `slow`: answers after tRSPTO in their slot, likewise; `count`:
    frames by the name of their channel; `ways`: us from each WRC1 (0) and WRC2 (1) to its actual values.

    `tolerance`: us by which a slot may be missed, where SYNC frames are not sure to stand where the edges are."""

    def __init__(self, lines, bit_rate, tolerance=0):
        self.times = TIMES[bit_rate]
        self.tolerance = tolerance
        self.wrong, self.slow = [], []
        self.count = dict.fromkeys(NAMES.values(), 0)
        self.ways = ([], [])
        frames = read(lines)
        self.edges = [frame.at for frame in frames if frame.channel == SYNC and not frame.data]
        self._interval = None
        self._referenced = (None, None)  # edges of the newest two intervals with reference values
        self._asked = {}  # 0, 1: the telegram of reference values that may be answered in this interval
        self._sent = []  # places of the master's telegrams in this interval
        self._commands = {}  # slave -> its commands that were not answered, two at the most: (frame, edge)
        for frame in frames:
            self._frame(frame)

    def _say(self, frame, what, words=None):
        (self.wrong if words is None else words).append(f"{frame.at / 1e6:.6f} {frame.text}: {what}")

    def _edge(self, at):
        """Of the interval in which `at` lies; where edges stayed away they stand a whole interval apart. None: no edge yet."""
        index = bisect.bisect_right(self.edges, at) - 1
        if index < 0:
            return None
        return self.edges[index] + (at - self.edges[index]) // self.times.interval * self.times.interval

    def _frame(self, frame):
        channel = frame.channel
        if channel is None:
            self._say(frame, "no telegram of CANsync has this identifier")
            return
        self.count[NAMES[channel]] += 1
        if len(frame.data) not in LENGTHS[channel]:
            self._say(frame, f"{len(frame.data)} data bytes on {NAMES[channel]}")
            return
        if channel in (*ACTUAL, COMMAND, RESPONSE) and frame.number >= SLAVES:
            self._say(frame, f"there is no slave {frame.number}")
            return
        if channel == SYNC:
            return
        edge = self._edge(frame.at)
        if edge is None:
            self._say(frame, "before the first SYNC")
            return
        if edge != self._interval:
            self._interval, self._asked, self._sent = edge, {}, []
        if channel == RESPONSE:
            self._response(frame, edge)
        elif channel in ACTUAL:
            self._actual(frame, ACTUAL.index(channel), edge)
        else:
            self._of_master(frame, edge)

    def _of_master(self, frame, edge):
        place = REFERENCE.index(frame.channel) if frame.channel in REFERENCE else len(REFERENCE)
        if place in self._sent:
            self._say(frame, "a second one in this interval")
        elif self._sent and place < self._sent[-1]:
            self._say(frame, "after a telegram whose place in the interval is behind it")
        self._sent.append(place)
        if frame.channel == COMMAND:
            self._commands[frame.number] = [*self._commands.get(frame.number, [])[-1:], (frame, edge)]
        if frame.channel in REFERENCE:
            self._asked[place] = frame
            if self._referenced[0] != edge:
                self._referenced = (edge, self._referenced[0])

    def _actual(self, frame, place, edge):
        """A slave answers when it is asked, once, in its slot (M 3.1.1.1)."""
        asked = self._asked.pop(place, None)
        if asked is None or asked.number != frame.number:
            self._say(frame, "not asked in this interval, or answered before")
            return
        self.ways[place].append(frame.at - asked.at)
        if frame.at - edge > self.times.actual[place] + self.tolerance:
            self._say(frame, f"{frame.at - edge} us after the edge, later than {self.times.actual[place]} us")

    def _response(self, frame, edge):
        """One for each command, about the same thing, within tRSPTO and by tRC (M 3.2.0.1, 3.2.1.3)."""
        commands = self._commands.get(frame.number, [])
        # A command without an answer in its time was not answered.
        while len(commands) > 1 and frame.at > self._latest(*commands[0], edge):
            commands.pop(0)
        if not commands:
            self._say(frame, "no command was there, or it was answered before")
            return
        command, asked_edge = commands.pop(0)
        transfer = command.data[0] & 0x80
        same = (command.data[0] & 0x0F, command.data[1]) == (frame.data[0] & 0x0F, frame.data[1])
        if frame.data[0] & 0x80 != transfer or not (transfer or same):
            self._say(frame, f"does not answer {command.text}")
        latest = self._latest(command, asked_edge, edge)
        if frame.at > latest:
            self._say(frame, f"{frame.at - latest} us after its slot")
        elif frame.at - command.at > self.times.answer:
            self._say(frame, f"{frame.at - command.at} us after its command, later than {self.times.answer} us", self.slow)

    def _latest(self, command, asked_edge, edge):
        """Until when an answer in the interval of `edge` may start. Without reference values the line is set up, and commands
        go early; those that go late have time as in operation."""
        active = any(seen is not None and edge - seen <= self.times.interval * 3 // 2 for seen in self._referenced)
        early = not active and command.at - asked_edge <= self.times.command - self.times.answer
        slot = self.times.command if early else self.times.interval + self.times.response
        return asked_edge + slot + self.tolerance
