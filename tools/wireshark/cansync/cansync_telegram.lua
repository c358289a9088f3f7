-- Frames of CANsync as tables, and in words. Pure functions without Wireshark's API; the bytes and the words
-- are those of lib/cansync/telegram/telegram.cpp and tools/cli/cansync/trace_text.cpp.
-- A frame: { id, kind = "standard" | "extended" | "remote", dlc, [0..dlc-1] = bytes }.
local names = ...
local M = {}

local function word(f, at) return f[at] + f[at + 1] * 256 end
local function doubleword(f, at) return word(f, at) + word(f, at + 2) * 65536 end
local function bit(byte, value) return math.floor(byte / value) % 2 == 1 end
local function twelve(f) return f[0] % 16 * 256 + f[1] end

local function hex(f, first, last)
  local out = {}
  for i = first, last do out[#out + 1] = string.format("%02X", f[i]) end
  return table.concat(out, " ")
end

-- The channel of an identifier, or "-".
function M.channel(id)
  if id == 0x010 then return "CC" end
  local channels = { [2] = "WRC1", [3] = "WRC2", [6] = "RDC1", [7] = "RDC2", [10] = "CC", [11] = "RC" }
  return channels[math.floor(id / 128)] or "-"
end

local function words_of(f)
  local words = {}
  for i = 0, f.dlc - 2, 2 do words[#words + 1] = word(f, i) end
  return words
end

local function decode_action(f)
  if f.dlc ~= 8 then return nil, "wrong_length" end
  if f[4] == 0 then return nil, "reserved_bits" end
  return { kind = "action", mask = doubleword(f, 0), command = f[4], data_byte = f[5], data_word = word(f, 6) }
end

local function decode_words(f, kind)
  if f.dlc % 2 ~= 0 then return nil, "wrong_length" end
  return { kind = kind, polled = kind == "reference" and f.id % 128 or nil, words = words_of(f) }
end

local function decode_parameter(f)
  if f.dlc ~= 4 and f.dlc ~= 6 and f.dlc ~= 8 then return nil, "wrong_length" end
  local t = { kind = "parameter", number = twelve(f), element = math.floor(f[0] / 16) % 8 }
  t.sub_slave = word(f, f.dlc - 2)
  t.sub_slave_at = f.dlc - 2
  t.size = (f.dlc - 4) -- bytes of the value: 0 read, 2 word, 4 doubleword
  if t.size == 2 then t.value = word(f, 2) end
  if t.size == 4 then t.value = doubleword(f, 2) end
  return t
end

local function decode_command(f)
  if f.dlc < 2 then return nil, "wrong_length" end
  if not bit(f[0], 0x80) then return decode_parameter(f) end
  local mode = math.floor(f[0] / 16) % 4
  local download = bit(f[0], 0x40)
  if mode == 0 then return nil, "reserved_bits" end
  if mode == 1 then
    if f.dlc ~= 8 then return nil, "wrong_length" end
    return { kind = "initialise", download = download, length = twelve(f), address = doubleword(f, 2),
      sub_slave = word(f, 6), sub_slave_at = 6 }
  end
  if f.dlc ~= (download and 8 or 2) then return nil, "wrong_length" end
  return { kind = download and "download" or "upload", offset = twelve(f), last = mode == 3 }
end

local function decode_reply(f)
  if f.dlc < 2 then return nil, "wrong_length" end
  local transfer, busy, failed = bit(f[0], 0x80), bit(f[0], 0x40), bit(f[0], 0x20)
  local fits
  if busy then
    fits = true
  elseif transfer then
    fits = failed and f.dlc == 4 or not failed and (f.dlc == 2 or f.dlc == 8)
  else
    fits = failed and (f.dlc == 4 or f.dlc == 6) or not failed and f.dlc % 2 == 0
  end
  if not fits then return nil, "wrong_length" end
  local t = { kind = transfer and "transfer_reply" or "parameter_reply", busy = busy, failed = failed }
  t[transfer and "offset" or "number"] = twelve(f)
  t.size = f.dlc - 2
  if failed and not busy and t.size >= 2 then t.code = word(f, 2) end
  return t
end

-- The telegram in a frame; else nil and which of names.decode_errors it is.
function M.decode(f)
  local block = math.floor(f.id / 256)
  if f.id ~= 0x010 and block ~= 1 and block ~= 3 and block ~= 5 then return nil, "not_for_us" end
  if f.kind ~= "standard" then return nil, f.kind end
  if f.id == 0x010 then return decode_action(f) end
  local channel = M.channel(f.id)
  if channel == "WRC1" or channel == "WRC2" then return decode_words(f, "reference") end
  if f.id % 128 > 31 then return nil, "wrong_slave" end
  local t, wrong
  if channel == "RDC1" or channel == "RDC2" then
    t, wrong = decode_words(f, "actual")
  elseif channel == "CC" then
    t, wrong = decode_command(f)
  else
    t, wrong = decode_reply(f)
  end
  if t then t.slave = f.id % 128 end
  return t, wrong
end

-- Length of a standard data frame on the bus in bits, interframe space not counted: with the stuff bits of
-- this very frame, which follow from its bits and its CRC (polynomial 0x4599).
function M.frame_bits(f)
  local bits = { 0 }
  local function put(value, count)
    for i = count - 1, 0, -1 do bits[#bits + 1] = math.floor(value / 2 ^ i) % 2 end
  end
  put(f.id, 11)
  put(0, 3)
  put(f.dlc, 4)
  for i = 0, f.dlc - 1 do put(f[i], 8) end
  local crc = 0
  for i = 1, #bits do
    local feed = (bits[i] + math.floor(crc / 0x4000)) % 2 == 1
    crc = crc * 2 % 0x8000
    if feed then
      local mixed = 0 -- crc exclusive-or 0x4599
      for b = 0, 14 do
        if math.floor(crc / 2 ^ b) % 2 ~= math.floor(0x4599 / 2 ^ b) % 2 then mixed = mixed + 2 ^ b end
      end
      crc = mixed
    end
  end
  put(crc, 15)
  local stuffed, same, run = 0, bits[1], 1
  for i = 2, #bits do
    run = bits[i] == same and run + 1 or 1
    same = bits[i]
    if run == 5 then
      stuffed, same, run = stuffed + 1, 1 - same, 1
    end
  end
  return #bits + stuffed + 10 -- CRC delimiter, acknowledge slot and delimiter, end of frame
end

-- "0-3,7" of a mask; "-" of an empty one.
function M.slave_set(mask)
  local out = {}
  local slave = 0
  while slave < 32 do
    local first = slave
    while slave < 32 and math.floor(mask / 2 ^ slave) % 2 == 1 do slave = slave + 1 end
    if slave - first == 1 then out[#out + 1] = tostring(first) end
    if slave - first > 1 then out[#out + 1] = first .. "-" .. slave - 1 end
    if slave == first then slave = slave + 1 end
  end
  return #out == 0 and "-" or table.concat(out, ",")
end

local function words_text(words)
  if #words == 0 then return "no words" end
  local out = { #words == 1 and "word" or "words" }
  for _, w in ipairs(words) do out[#out + 1] = string.format("0x%04X", w) end
  return table.concat(out, " ")
end

local function sub_slave_text(sub_slave)
  return (sub_slave or 0) == 0 and "" or ", sub-slave " .. sub_slave
end

local function value_text(value, size)
  if size == 2 then return string.format("%d (0x%04X, word)", value, value) end
  return string.format("%.0f (0x%08X, doubleword)", value, value)
end

-- What the payload of a parameter reply says, given the newest command to that slave: fields `value`, `size`
-- (of the value: 2, 4, or 0 when written) and `sub_slave`, each nil when it is not there.
function M.parameter_answer(t, f, asked)
  local known = asked and asked.kind == "parameter" and asked.number == t.number
  local out = {}
  if t.busy then return out end
  local function sub_slave_at(at) return t.size >= at and word(f, at) or nil end
  if t.failed then
    out.sub_slave, out.sub_slave_at = sub_slave_at(4), 4
    return out
  end
  local read
  if known then read = asked.size == 0 else read = t.size >= 4 end
  if not read then
    out.size = 0
    if known then out.sub_slave, out.sub_slave_at = sub_slave_at(2), 2 end
  elseif t.size == 6 then
    out.size, out.value, out.sub_slave, out.sub_slave_at = 4, doubleword(f, 2), sub_slave_at(6), 6
  elseif t.size >= 2 then
    out.size, out.value, out.sub_slave, out.sub_slave_at = 2, word(f, 2), sub_slave_at(4), 4
  end
  return out
end

local say = {}

function say.action(t)
  local what = t.command == 1 and string.format("control word 0x%04X", t.data_word)
      or string.format("action %d, byte 0x%02X, word 0x%04X", t.command, t.data_byte, t.data_word)
  return "broadcast to slaves " .. M.slave_set(t.mask) .. ": " .. what
end

function say.reference(t)
  local asks = t.polled > 31 and "asks nobody" or "asks slave " .. t.polled
  return "reference values, " .. asks .. ": " .. words_text(t.words)
end

function say.actual(t) return "actual values: " .. words_text(t.words) end

function say.parameter(t)
  local where = "parameter " .. t.number .. (t.element == 7 and "" or " element " .. t.element)
  if t.size == 0 then return "read " .. where .. sub_slave_text(t.sub_slave) end
  return "write " .. where .. " = " .. value_text(t.value, t.size) .. sub_slave_text(t.sub_slave)
end

function say.initialise(t)
  if M.is_cancel(t) then return "cancel transfer" .. sub_slave_text(t.sub_slave) end
  return string.format("%s of %d bytes %s 0x%08X%s", t.download and "begin download" or "begin upload", t.length,
    t.download and "to" or "from", t.address, sub_slave_text(t.sub_slave))
end

function say.upload(t)
  return "upload: asks for bytes from " .. t.offset .. (t.last and " (last)" or "")
end

function say.download(t, f)
  return "download: bytes from " .. t.offset .. (t.last and " (last)" or "") .. ": " .. hex(f, 2, 7)
end

local function error_text(code, meanings)
  return string.format("error 0x%04X, %s", code, meanings[code] or names.unknown_error)
end

function say.parameter_reply(t, f, asked)
  local where = "parameter " .. t.number
  if t.busy then return where .. ": busy, to be asked again" end
  local answer = M.parameter_answer(t, f, asked)
  local sub_slave = sub_slave_text(answer.sub_slave)
  if t.failed then return where .. ": " .. error_text(t.code, names.parameter_errors) .. sub_slave end
  if answer.size == 0 then return where .. ": written" .. sub_slave end
  if not answer.value then return where .. ": answer without a value" end
  return where .. " = " .. value_text(answer.value, answer.size) .. sub_slave
end

function say.transfer_reply(t, f, asked)
  if t.busy then return "transfer, " .. t.offset .. ": busy, to be asked again" end
  if t.failed then return "transfer, " .. t.offset .. ": " .. error_text(t.code, names.transfer_errors) end
  if t.size == 6 then return "upload: bytes from " .. t.offset .. ": " .. hex(f, 2, 7) end
  if asked and asked.kind == "initialise" then return "transfer accepted, length " .. t.offset end
  if asked and asked.kind == "download" then return "download: took bytes from " .. t.offset end
  return "transfer, " .. t.offset .. ": accepted"
end

-- The telegram that cancels a transfer.
function M.is_cancel(t)
  return t.kind == "initialise" and not t.download and t.length == 0 and t.address == 0
end

-- A telegram in words; `asked`: the newest command to the slave of an answer, or nil.
function M.words(t, f, asked) return say[t.kind](t, f, asked) end

-- A frame as it stands: identifier, length, bytes.
function M.frame_text(f)
  local id = string.format(f.extended and "0x%08X" or "0x%03X", f.id)
  return string.format("%s [%d]%s", id, f.dlc, f.dlc > 0 and " " .. hex(f, 0, f.dlc - 1) or "")
end

-- A frame that is no telegram, and why.
function M.malformed_words(f, wrong)
  return string.format("no CANsync telegram (%s): %s", names.decode_errors[wrong], M.frame_text(f))
end

return M
