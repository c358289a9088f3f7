"""Frames of random bytes, decoded by `cansync can dump --dbc` and by canmatrix with the same DBC file, say the same.

The files come from a seed: signals of either order of bytes, with and without a sign, floating point numbers, factors and
offsets, names of values, multiplexers and multiplexers below multiplexers, identifiers of 11 and 29 bits.
Usage: canmatrix_test.py [FILES [FIRST_SEED]]; CANSYNC names the program. Debian's own Python runs it.
"""
import decimal
import json
import os
import pathlib
import random
import struct
import subprocess
import sys
import tempfile

import canmatrix.formats

FRAMES = 40  # of each message
FACTORS = ("1", "1", "0.5", "0.1", ".25", "-2", "1e-3", "0.03125", "100")
OFFSETS = ("0", "0", "-40", "0.5", "1000", "-.125")


def sawtooth(bit):
    """The number in a DBC file of the bit that comes as `bit`-th when bytes are read from their highest bits on."""
    return 8 * (bit // 8) + 7 - bit % 8


class Message:
    """A message with its lines of a DBC file."""

    def __init__(self, dice, number):
        self.length = dice.randint(1, 8)
        self.number = dice.randrange(0x20000000) | 0x80000000 if dice.random() < 0.4 else dice.randrange(0x800)
        self.name = f"M{number}"
        self.signals = []
        self.ranges = []
        self.others = []
        shape = dice.choice(("plain", "plain", "one", "two")) if self.length >= 3 else "plain"
        if shape != "plain":
            self.signals.append(" SG_ Mux M : 0|3@1+ (1,0) [0|0] \"\" X")
        if shape == "two":
            self.signals.append(" SG_ Below m1M : 3|3@1+ (1,0) [0|0] \"\" X")
            self.ranges.append(f"SG_MUL_VAL_ {self.number} Below Mux 1-1;")
        for i in range(dice.randint(1, 6)):
            self.signal(dice, f"S{i}", shape)

    def signal(self, dice, name, shape):
        bits = 8 * self.length
        floating = dice.random() < 0.15 and bits >= 32
        length = dice.choice((32, 64) if bits == 64 else (32,)) if floating else dice.randint(1, min(bits, 64))
        first = dice.randint(0, bits - length)
        little = dice.random() < 0.5
        sign = "-" if floating or dice.random() < 0.5 else "+"
        chosen = ""
        if shape == "one" and dice.random() < 0.7:
            chosen = f" m{dice.randrange(8)}"
        elif shape == "two":
            below = dice.random() < 0.6
            value = dice.randrange(8)
            chosen = f" m{value}"
            last = min(7, value + dice.randrange(3))
            self.ranges.append(f"SG_MUL_VAL_ {self.number} {name} {'Below' if below else 'Mux'} {value}-{last};")
        factor, offset = (1, 0) if floating else (dice.choice(FACTORS), dice.choice(OFFSETS))
        self.signals.append(f" SG_ {name}{chosen} : {first if little else sawtooth(first)}|{length}@{int(little)}{sign} "
                            f"({factor},{offset}) [0|0] \"u\" X")
        if floating:
            self.others.append(f"SIG_VALTYPE_ {self.number} {name} : {length // 32};")
        elif dice.random() < 0.3:
            self.others.append(f"VAL_ {self.number} {name} 0 \"zero\" 1 \"one\" ;")
            self.others.append(f"VAL_ {self.number} {name} 3 \"three\" ;")

    def frames(self, dice):
        for _ in range(FRAMES):
            data = bytearray(dice.randbytes(self.length))
            if dice.random() < 0.5:  # so that multiplexers and names of values are met
                data[0] = dice.randrange(64)
            yield bytes(data)


def dbc_text(messages):
    lines = ["VERSION \"\"", "", "NS_ :", "", "BS_:", "", "BU_: ECU", ""]
    for message in messages:
        lines += [f"BO_ {message.number} {message.name}: {message.length} ECU", *message.signals, ""]
    for message in messages:
        lines += message.others
    for message in messages:
        lines += message.ranges
    return "\n".join(lines) + "\n"


def same(ours, decoded):
    """Exactly what is not scaled, else to a thousandth of a step, or within what a double can hold.

    JSON has no number for NaN and infinity."""
    theirs = decimal.Decimal(decoded.phys_value)
    if ours is None or not theirs.is_finite():
        return ours is None and not theirs.is_finite()
    if decoded.signal.is_float:  # as many digits as give the same bytes again
        kind = "<f" if decoded.signal.size == 32 else "<d"
        return struct.pack(kind, float(ours)) == struct.pack(kind, float(theirs))
    if decoded.signal.factor == 1 and decoded.signal.offset == 0:
        return ours == theirs
    allowed = abs(decoded.signal.factor) / 1000 + abs(theirs) * decimal.Decimal("1e-15")
    return abs(decimal.Decimal(ours) - theirs) <= allowed


def ours(folder, dbc, frames):
    log = folder / "frames.log"
    with log.open("w", encoding="ascii") as out:
        for i, (message, data) in enumerate(frames):
            extended = message.number >= 0x80000000
            identifier = f"{message.number & 0x1FFFFFFF:0{8 if extended else 3}X}"
            out.write(f"({i // 1000}.{i % 1000:03}000) can0 {identifier}#{data.hex().upper()}\n")
    run = subprocess.run([os.environ["CANSYNC"], "can", "dump", log, "--dbc", dbc, "--json"], capture_output=True,
                         check=False, text=True)
    assert run.returncode == 0, run.stderr
    # Numbers as they are written: 64 bits are more than a double holds.
    return [json.loads(line, parse_float=str) for line in run.stdout.splitlines()]


def compare(seed, folder):
    dice = random.Random(seed)
    messages, numbers = [], set()
    for i in range(dice.randint(1, 6)):
        message = Message(dice, i)
        if message.number not in numbers:
            numbers.add(message.number)
            messages.append(message)
    dbc = folder / "random.dbc"
    dbc.write_text(dbc_text(messages), encoding="ascii")
    matrix = canmatrix.formats.loadp_flat(str(dbc), dbcImportEncoding="ascii")
    frames = [(message, data) for message in messages for data in message.frames(dice)]
    read = ours(folder, dbc, frames)
    assert len(read) == len(frames), (len(read), len(frames))
    values = 0
    for (message, data), line in zip(frames, read):
        expected = matrix.frame_by_name(message.name).decode(data)
        where = f"seed {seed}, {message.name}, {data.hex()}"
        assert line["message"] == message.name, (where, line)
        got = {signal["name"]: signal for signal in line["signals"]}
        assert set(got) == set(expected), (where, sorted(got), sorted(expected))
        for name, decoded in expected.items():
            assert same(got[name]["value"], decoded), (where, name, got[name], decoded.phys_value)
            # The DBC documents name raw values, by their bits; canmatrix's own `named_value` compares them with the scaled one.
            bits = 2 ** decoded.signal.size
            names = {int(raw) % bits: word for raw, word in decoded.signal.values.items() if int(raw) < bits}
            named = names.get(decoded.raw_value % bits, "") if names else ""
            assert got[name]["word"] == named, (where, name, got[name], named)
            values += 1
    return values


def main():
    files = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    with tempfile.TemporaryDirectory() as folder:
        values = sum(compare(seed, pathlib.Path(folder)) for seed in range(first, first + files))
    print(f"{files} files, {values} values, all the same")
    assert values > 40 * files, values


if __name__ == "__main__":
    main()
