-- Numbers and names of CANsync, as lib/cansync has them; tests/wireshark compares the two.
local names = {}

-- Latest starts of each channel's telegram in microseconds after SYNC, by bit rate (M 3.1.1). `interval` is
-- tSYNC, `timeout` tRSPTO: from the end of a command to the start of its answer.
names.slots = {
  [1000000] = { interval = 1000, RC = 210, WRC1 = 350, RDC1 = 520, WRC2 = 650, RDC2 = 820, CC = 950, timeout = 300 },
  [500000] = { interval = 2000, RC = 460, WRC1 = 730, RDC1 = 1060, WRC2 = 1320, RDC2 = 1630, CC = 1890, timeout = 600 },
  [250000] = { interval = 4000, RC = 900, WRC1 = 1430, RDC1 = 2100, WRC2 = 2620, RDC2 = 3290, CC = 3810, timeout = 1100 },
  [125000] = { interval = 8000, RC = 1920, WRC1 = 3020, RDC1 = 4310, WRC2 = 5350, RDC2 = 6640, CC = 7680, timeout = 2100 },
}

-- Error codes of parameter replies.
names.parameter_errors = {
  [0x0000] = "no error",
  [0xFFFF] = "unspecified error",
  [0xFFFE] = "value below the minimum",
  [0xFFFD] = "value above the maximum",
  [0xFFFC] = "element cannot be changed",
  [0xFFFB] = "no such parameter or element",
  [0xFFFA] = "data not available now",
  [0xFFF9] = "wrong data format",
}

-- Error codes of transfer replies.
names.transfer_errors = {
  [0x0000] = "no error",
  [0x0001] = "slave acknowledged a wrong block number",
  [0x0002] = "length over 300 bytes",
  [0x0100] = "slave expects the block its counter names",
  [0x0101] = "slave expects the end of the block",
  [0x0102] = "slave does not yet expect the end of the block",
  [0x0103] = "slave cancelled the transfer",
  [0x0104] = "transfer not possible",
  [0x0105] = "start address not allowed",
  [0x0107] = "block longer than the slave's maximum",
  [0x0108] = "telegram not allowed in this phase of the transfer",
}
names.unknown_error = "unknown error code"

-- Why a frame is no telegram.
names.decode_errors = {
  not_for_us = "not for us",
  extended = "extended frame",
  remote = "remote frame",
  error_frame = "error frame",
  wrong_slave = "wrong slave number",
  wrong_length = "wrong length",
  reserved_bits = "reserved bits used",
}

-- What is wrong with an answer that is a telegram.
names.unexpected = {
  wrong_answer = "other answer than asked for",
  duplicate = "duplicate",
}

return names
