"""A program on a terminal of our own: keys go in, and what the screen shows comes out (python3-pyte)."""

import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import termios
import time

import pyte

LONG = 120  # seconds after which something has certainly gone wrong, also on a loaded machine
KIND = "screen-256color"  # TERM; pyte does not know the repeating of characters that xterm is told to do
KEYS = {"up": "\x1bOA", "down": "\x1bOB", "right": "\x1bOC", "left": "\x1bOD", "escape": "\x1b", "enter": "\r",
        "ctrl-c": "\x03", "backspace": "\x7f"}


class Screen(pyte.Screen):
    """pyte's screen, and the scrolling that ncurses tells a terminal of this kind to do."""

    def scroll_down(self, count=1):
        self._at(self.margins.top if self.margins else 0, self.reverse_index, count)

    def scroll_up(self, count=1):
        self._at(self.margins.bottom if self.margins else self.lines - 1, self.index, count)

    def _at(self, line, move, count):
        """Moves the lines from this one on and leaves the cursor where it is."""
        before, self.cursor.y = self.cursor.y, line
        for _ in range(max(count, 1)):
            move()
        self.cursor.y = before


class Stream(pyte.ByteStream):
    csi = dict(pyte.ByteStream.csi, S="scroll_up", T="scroll_down")
    events = pyte.ByteStream.events | {"scroll_up", "scroll_down"}


class Terminal:
    """A program that runs on a terminal of this size; a context manager."""

    def __init__(self, arguments, environment, columns=120, rows=32):
        self.screen = Screen(columns, rows)
        self.stream = Stream(self.screen)
        self.everything = b""
        self.side, other = pty.openpty()
        self.before = termios.tcgetattr(other)
        self._set_size(other, columns, rows)
        # Its own session with the terminal as the controlling one: Ctrl-C and a new size reach it as signals.
        self.process = subprocess.Popen(arguments, env=environment, stdin=other, stdout=other, stderr=other,
                                        start_new_session=True,
                                        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))
        self.other = other  # kept open: what the program left there can be read after its end

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait(LONG)
        os.close(self.other)
        os.close(self.side)

    @staticmethod
    def _set_size(descriptor, columns, rows):
        fcntl.ioctl(descriptor, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def resize(self, columns, rows):
        self.screen.resize(rows, columns)
        self._set_size(self.side, columns, rows)

    def press(self, *keys):
        for key in keys:
            os.write(self.side, KEYS.get(key, key).encode())

    def take(self, seconds=0.1):
        """Takes what the program writes, for at most that long."""
        if select.select([self.side], [], [], seconds)[0]:
            part = os.read(self.side, 65536)
            self.everything += part
            self.stream.feed(part)

    def text(self):
        return "\n".join(line.rstrip() for line in self.screen.display)

    def wait(self, what, condition):
        """The first true result of `condition`, which is asked with the text of the screen."""
        deadline = time.monotonic() + LONG
        while not (result := condition(self.text())):
            if time.monotonic() > deadline:
                raise AssertionError(f"not within {LONG} s: {what}; the screen shows\n{self.text()}")
            self.take()
        return result

    def end(self, send=None):
        """Waits for the program's end, after a signal if wanted; its exit code."""
        if send is not None:
            self.process.send_signal(send)
        deadline = time.monotonic() + LONG
        while self.process.poll() is None:
            if time.monotonic() > deadline:
                raise AssertionError(f"does not end; the screen shows\n{self.text()}")
            self.take()
        while select.select([self.side], [], [], 0)[0]:
            self.take(0)
        return self.process.returncode

    def restored(self):
        """True when the terminal is as the program found it: its modes, the cursor, the screen before."""
        left = self.everything.rfind(b"\x1b[?1049l")
        return (termios.tcgetattr(self.other) == self.before and left > self.everything.rfind(b"\x1b[?1049h")
                and self.everything.rfind(b"\x1b[?25h") > self.everything.rfind(b"\x1b[?25l")
                or self._describe())

    def _describe(self):
        raise AssertionError(f"modes {termios.tcgetattr(self.other)} instead of {self.before}; "
                             f"the last output: {self.everything[-200:]}")


TERMINATE = signal.SIGTERM
