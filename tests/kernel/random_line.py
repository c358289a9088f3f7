"""A line of drives that nobody knows: bit rate, slave numbers, drive types, their parameters and mappings by a seed."""

import os
import random

ASSIGNED, HIGH = 1, 2  # bits of a register byte (M 3.1.1.1)
POSITION, TEMPERATURE, ECHO = 0, 6, 7  # actual values of a simulated drive
MEANT = {0: "position", 1: "speed", 2: "following-error", 3: "setpoint", 4: "torque", 6: "temperature", 7: "echo"}
UNITS = ("mm", "inc", "rev", "N", "degC", "rpm")
# Numbers that a simulated drive has anyway, and those of its axis.
TAKEN = {*range(100, 104), *range(300, 332), *range(400, 431), *range(1000, 1040)}


def register(value, high=False):
    return ASSIGNED | (HIGH if high else 0) | value << 2


def random_mapping(chance, values, needed=()):
    """Four register bytes of some of these values, each as a word or a doubleword; `needed` as doublewords."""
    words = []
    for value in needed:
        words += [register(value), register(value, True)]
    for value in chance.sample(values, len(values)):
        if value in needed:
            continue
        wide = chance.random() < 0.5
        if len(words) + 1 + wide > 4 or chance.random() < 0.2:
            continue
        words += [register(value), register(value, True)] if wide else [register(value)]
    return words + [0] * (4 - len(words))


def carried(registers):
    """{value: is it 32 bits wide} of register bytes."""
    found = {}
    for byte in registers:
        if byte & ASSIGNED:
            found[byte >> 2] = found.get(byte >> 2, False) or bool(byte & HIGH)
    return found


class DriveType:
    """A kind of drive: what its manual would say, as a profile."""

    def __init__(self, chance, number):
        self.name = f"drive-{number}-{chance.randrange(1000)}"
        numbers = iter(chance.sample([n for n in range(1, 4096) if n not in TAKEN], 40))
        self.recognised = {next(numbers): chance.randrange(1, 65536) for _ in range(chance.randint(1, 3))}
        self.status = next(numbers)
        self.tells = {what: next(numbers) for what in
                      ("reference-mapping-1", "reference-mapping-2", "actual-mapping-1", "actual-mapping-2")}
        self.block = next(numbers) if chance.random() < 0.5 else None
        self.values = {}
        for value in MEANT:
            self.values[value] = (next(numbers), f"{MEANT[value]}-{chance.randrange(100)}", chance.choice(UNITS),
                                  chance.choice((1.0, 0.1, 0.25, 0.001, 360 / 65536)), chance.choice((0.0, 0.0, -20.0)))
        self.more = [next(numbers) for _ in range(chance.randint(0, 8))]

    def profile(self):
        known = ", ".join(f'"{number}={value}"' for number, value in self.recognised.items())
        text = f'[profile]\nname = "{self.name}"\nrecognised_by = [{known}]\n'

        def add(number, name, form, extra=""):
            return f'[[parameter]]\nnumber = {number}\nname = "{name}"\nformat = "{form}"\naccess = "read-only"\n{extra}'

        for number in self.recognised:
            text += add(number, f"model-{number}", "word", 'identity = "type"\n')
        text += add(self.status, "status", "word", 'volatile = true\ntells = "status-word"\n')
        for what, number in self.tells.items():
            text += add(number, what, "doubleword", f'tells = "{what}"\n')
        if self.block:
            text += add(self.block, "block", "word", 'tells = "block-limit"\n')
        for value, (number, name, unit, factor, offset) in self.values.items():
            text += add(number, name, "doubleword", f'signed = true\nunit = "{unit}"\nfactor = {factor!r}\n'
                                                    f"offset = {offset!r}\nvolatile = true\nactual_value = {value}\n")
        for number in self.more:
            text += add(number, f"more-{number}", "word")
        return text


class RandomLine:
    """Everything about one line; `write` puts down what its maker knows."""

    def __init__(self, seed, rates):
        chance = random.Random(seed)
        self.bit_rate = chance.choice(rates)
        self.types = [DriveType(chance, number) for number in range(chance.randint(1, 3))]
        self.decoys = [DriveType(chance, number) for number in range(7, 9)]
        self.slaves = {number: chance.choice(self.types) for number in sorted(chance.sample(range(32), chance.randint(1, 8)))}
        # The drives follow position and give back reference value 4.
        self.reference = (random_mapping(chance, [0, 1, 2, 3], [0]), random_mapping(chance, [4, 5, 6, 7], [4]))
        self.actual = {number: (random_mapping(chance, [0, 1, 2, 3]), random_mapping(chance, [4, 6, 7]))
                       for number in self.slaves}
        self.block_limit = {number: chance.choice((300, 300, 4092, chance.randint(6, 4092))) for number in self.slaves}

    def write(self, folder, interface):
        """The configuration of `cansync-sim`, with the profiles beside it; its path."""
        os.makedirs(os.path.join(folder, "profiles"))
        for kind in self.types + self.decoys:
            with open(os.path.join(folder, "profiles", kind.name + ".toml"), "w", encoding="utf-8") as file:
                file.write(kind.profile())
        text = f'[bus]\ninterface = "{interface}"\nbit_rate = {self.bit_rate}\n[process]\n'
        for n in (0, 1):
            text += f"reference_registers_{n + 1} = {self.reference[n]}\n"
        for number, kind in self.slaves.items():
            text += f'[[slave]]\nnumber = {number}\nprofile = "{kind.name}"\nstatus_parameter = {kind.status}\n'
            text += f"block_limit = {self.block_limit[number]}\n"
            for n in (0, 1):
                text += f"actual_registers_{n + 1} = {self.actual[number][n]}\n"
        path = os.path.join(folder, "drives.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def named_values(self, number):
        """{value: (name, unit, factor, offset)} of what a slave sends."""
        sent = {**carried(self.actual[number][0]), **carried(self.actual[number][1])}
        return {value: self.slaves[number].values[value][1:] for value in sorted(sent)}

    def describe(self):
        slaves = ", ".join(f"{number} {kind.name}" for number, kind in self.slaves.items())
        return f"{self.bit_rate} bit/s, {slaves}"
