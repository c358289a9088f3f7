-- CANsync, the bus of synchronised Baumueller drives, in Wireshark and tshark: docs/wireshark.md.
-- Protocol, times and names: docs/cansync-protocol.md.
-- Wireshark's own __DIR__ is not there for global plugins.
local folder = debug.getinfo(1, "S").source:match("^@(.*[/\\])") or ""
local function part(file, ...) return assert(loadfile(folder .. file))(...) end
local names = part("cansync_names.lua")
local telegram = part("cansync_telegram.lua", names)
local lines = part("cansync_line.lua", names, telegram)
local mapping = part("cansync_mapping.lua")

local cansync = Proto("cansync", "CANsync")

local f = {
  channel = ProtoField.string("cansync.channel", "Channel"),
  slave = ProtoField.uint8("cansync.slave", "Slave"),
  text = ProtoField.string("cansync.text", "In words"),
  polled = ProtoField.uint8("cansync.polled", "Asked slave"),
  word = ProtoField.uint16("cansync.word", "Word", base.HEX),
  value = ProtoField.int32("cansync.value", "Value"),
  mask = ProtoField.uint32("cansync.action.slaves", "Slaves", base.HEX),
  command = ProtoField.uint8("cansync.action.command", "Command"),
  data_byte = ProtoField.uint8("cansync.action.byte", "Data byte", base.HEX),
  data_word = ProtoField.uint16("cansync.action.word", "Data word", base.HEX),
  control_word = ProtoField.uint16("cansync.control_word", "Control word", base.HEX),
  kind = ProtoField.string("cansync.kind", "Kind"),
  number = ProtoField.uint16("cansync.parameter.number", "Parameter"),
  element = ProtoField.uint8("cansync.parameter.element", "Element"),
  parameter_value = ProtoField.uint32("cansync.parameter.value", "Value", base.DEC_HEX),
  parameter_error = ProtoField.uint16("cansync.parameter.error", "Error", base.HEX, names.parameter_errors),
  sub_slave = ProtoField.uint16("cansync.sub_slave", "Sub-slave"),
  busy = ProtoField.bool("cansync.busy", "Busy"),
  failed = ProtoField.bool("cansync.failed", "Error"),
  length = ProtoField.uint16("cansync.transfer.length", "Length"),
  address = ProtoField.uint32("cansync.transfer.address", "Start address", base.HEX),
  offset = ProtoField.uint16("cansync.transfer.offset", "Offset"),
  last = ProtoField.bool("cansync.transfer.last", "Last"),
  data = ProtoField.bytes("cansync.transfer.data", "Data"),
  transfer_error = ProtoField.uint16("cansync.transfer.error", "Error", base.HEX, names.transfer_errors),
  block = ProtoField.bytes("cansync.transfer.block", "Block"),
  block_length = ProtoField.uint16("cansync.transfer.block_length", "Block length"),
  block_first = ProtoField.framenum("cansync.transfer.block_first", "Block begins in frame"),
  request_in = ProtoField.framenum("cansync.request_in", "Command in frame", base.NONE, frametype.REQUEST),
  response_in = ProtoField.framenum("cansync.response_in", "Answer in frame", base.NONE, frametype.RESPONSE),
  repeats = ProtoField.framenum("cansync.repeats", "Repeats frame"),
  first_in = ProtoField.framenum("cansync.first_request_in", "First command in frame"),
  time = ProtoField.double("cansync.time_us", "Time since the command (us)"),
  response = ProtoField.double("cansync.response_us", "From the command's end to the answer's start (us)"),
  since_first = ProtoField.double("cansync.time_since_first_us", "Time since the first command (us)"),
  after_sync = ProtoField.double("cansync.after_sync_us", "Start after SYNC (us)"),
  limit = ProtoField.double("cansync.latest_start_us", "Latest start after SYNC (us)"),
  sync_in = ProtoField.framenum("cansync.sync_in", "SYNC edge in frame"),
  since_edge = ProtoField.double("cansync.interval_us", "Since the edge before (us)"),
}
cansync.fields = f

local e = {
  malformed = ProtoExpert.new("cansync.malformed", "no CANsync telegram", expert.group.MALFORMED, expert.severity.ERROR),
  late = ProtoExpert.new("cansync.late", "late against the latest start", expert.group.SEQUENCE, expert.severity.WARN),
  slow = ProtoExpert.new("cansync.slow", "slow answer", expert.group.SEQUENCE, expert.severity.NOTE),
  sync = ProtoExpert.new("cansync.sync_missing", "SYNC edge missing", expert.group.SEQUENCE, expert.severity.NOTE),
  unexpected = ProtoExpert.new("cansync.unexpected", "unexpected answer", expert.group.SEQUENCE, expert.severity.WARN),
  incomplete = ProtoExpert.new("cansync.incomplete", "block incomplete", expert.group.REASSEMBLE, expert.severity.WARN),
  unanswered = ProtoExpert.new("cansync.unanswered", "no answer", expert.group.SEQUENCE, expert.severity.NOTE),
  failed = ProtoExpert.new("cansync.error", "the slave answers with an error", expert.group.RESPONSE_CODE, expert.severity.NOTE),
}
cansync.experts = e

local rates = { [0] = 0, 1000000, 500000, 250000, 125000 }
cansync.prefs.sync_identifier = Pref.uint("Identifier of SYNC", 128,
  "Identifier of the frame that marks the SYNC edge; 2048 = no such frame")
cansync.prefs.bit_rate = Pref.enum("Bit rate and interval", 0, "They fix the latest starts",
  { { 0, "by the distance of SYNC", 0 }, { 1, "1 Mbit/s, 1 ms", 1 }, { 2, "500 kbit/s, 2 ms", 2 },
    { 3, "250 kbit/s, 4 ms", 3 }, { 4, "125 kbit/s, 8 ms", 4 } }, false)
cansync.prefs.stamps = Pref.enum("Time stamps", 1, "What the stamps of the capture tell",
  { { 1, "end of the frame", 1 }, { 2, "start of the frame", 2 } }, false)
cansync.prefs.tolerance = Pref.uint("Tolerance (us)", 20,
  "With stamps of the end: how late a telegram or an answer may seem, because the kernel's stamps are late too")
local help = "Four register bytes (01 03 05 07), or value numbers and high words (0,0,1,1 / F,T,F,T); empty = words only"
for _, channel in ipairs({ "wrc1", "wrc2", "rdc1", "rdc2" }) do
  cansync.prefs["mapping_" .. channel] = Pref.string("Mapping of " .. channel:upper(), "", help)
end

local frame_identifier = Field.new("can.id")
local frame_extended = Field.new("can.flags.xtd")
local frame_remote = Field.new("can.flags.rtr")
local frame_flexible = Field.new("canfd.flags.brs")
local interface_name = Field.new("frame.interface_name")

local line, maps

local function begin_capture()
  line = lines.new({ bit_rate = rates[cansync.prefs.bit_rate], tolerance = cansync.prefs.tolerance * 1000,
    stamps = cansync.prefs.stamps == 2 and "start" or "end" })
  maps = {}
  for _, channel in ipairs({ "wrc1", "wrc2", "rdc1", "rdc2" }) do
    local text = cansync.prefs["mapping_" .. channel]
    maps[channel:upper()] = mapping.parse(text)
    if text:match("%S") and not maps[channel:upper()] then
      report_failure("CANsync: mapping of " .. channel:upper() .. ": found '" .. text .. "'. " .. help)
    end
  end
end
cansync.init = begin_capture

local function add_words(tree, buffer, t, channel)
  for i = 0, #t.words - 1 do
    tree:add_le(f.word, buffer(2 * i, 2)):set_text(string.format("Word %d: 0x%04X", i, t.words[i + 1]))
  end
  for _, value in ipairs(mapping.values(maps[channel], t.words)) do
    tree:add(f.value, buffer(), value.number):set_text(value.text):set_generated()
  end
end

local add = {}

function add.action(tree, buffer, t)
  tree:add_le(f.mask, buffer(0, 4)):append_text(" (" .. telegram.slave_set(t.mask) .. ")")
  tree:add(f.command, buffer(4, 1))
  tree:add(f.data_byte, buffer(5, 1))
  tree:add_le(f.data_word, buffer(6, 2))
  if t.command == 1 then tree:add_le(f.control_word, buffer(6, 2)) end
end

function add.reference(tree, buffer, t, _, channel)
  if t.polled < 32 then tree:add(f.slave, t.polled) end
  tree:add(f.polled, t.polled):append_text(t.polled > 31 and " (nobody)" or "")
  add_words(tree, buffer, t, channel)
end

function add.actual(tree, buffer, t, _, channel) add_words(tree, buffer, t, channel) end

local function add_parameter(tree, buffer, number, size, sub_slave_at)
  tree:add(f.number, buffer(0, 2), number)
  if size == 2 or size == 4 then tree:add_le(f.parameter_value, buffer(2, size)) end
  if sub_slave_at then tree:add_le(f.sub_slave, buffer(sub_slave_at, 2)) end
end

function add.parameter(tree, buffer, t)
  tree:add(f.kind, t.size == 0 and "read" or t.size == 2 and "write word" or "write doubleword")
  tree:add(f.element, buffer(0, 1), t.element)
  add_parameter(tree, buffer, t.number, t.size, t.sub_slave_at)
end

function add.initialise(tree, buffer, t)
  tree:add(f.kind, telegram.is_cancel(t) and "cancel" or t.download and "begin download" or "begin upload")
  tree:add(f.length, buffer(0, 2), t.length)
  tree:add_le(f.address, buffer(2, 4))
  tree:add_le(f.sub_slave, buffer(6, 2))
end

function add.upload(tree, buffer, t)
  tree:add(f.kind, "upload")
  tree:add(f.offset, buffer(0, 2), t.offset)
  tree:add(f.last, buffer(0, 1), t.last)
end

function add.download(tree, buffer, t)
  tree:add(f.kind, "download")
  tree:add(f.offset, buffer(0, 2), t.offset)
  tree:add(f.last, buffer(0, 1), t.last)
  tree:add(f.data, buffer(2, 6))
end

function add.parameter_reply(tree, buffer, t, record)
  tree:add(f.kind, "answer to a parameter command")
  tree:add(f.busy, buffer(0, 1), t.busy)
  tree:add(f.failed, buffer(0, 1), t.failed)
  local answer = telegram.parameter_answer(t, record.bytes, record.asked)
  add_parameter(tree, buffer, t.number, answer.size, answer.sub_slave and answer.sub_slave_at)
  if t.code then tree:add_le(f.parameter_error, buffer(2, 2)) end
end

function add.transfer_reply(tree, buffer, t)
  tree:add(f.kind, "answer to a transfer")
  tree:add(f.busy, buffer(0, 1), t.busy)
  tree:add(f.failed, buffer(0, 1), t.failed)
  tree:add(f.offset, buffer(0, 2), t.offset)
  if t.code then tree:add_le(f.transfer_error, buffer(2, 2)) end
  if t.size == 6 and not t.busy then tree:add(f.data, buffer(2, 6)) end
end

local function add_generated(tree, field, value)
  if value then tree:add(field, value):set_generated() end
end

local function add_time(tree, field, ns)
  -- Stamps are doubles; a tenth of a microsecond is what they can tell.
  if ns then tree:add(field, math.floor(ns / 100 + 0.5) / 10):set_generated() end
end

local function add_relations(tree, record)
  add_generated(tree, f.response_in, record.answer)
  add_generated(tree, f.request_in, record.request)
  add_time(tree, f.time, record.time)
  add_time(tree, f.response, record.response)
  add_generated(tree, f.repeats, record.repeats)
  add_generated(tree, f.first_in, record.first)
  add_time(tree, f.since_first, record.since_first)
  add_time(tree, f.after_sync, record.after_sync)
  add_time(tree, f.limit, record.limit)
  add_generated(tree, f.sync_in, record.edge_frame)
  if record.unanswered then tree:add_proto_expert_info(e.unanswered) end
  for _, mark in ipairs(record.marks) do tree:add_proto_expert_info(e[mark.kind], mark.text) end
end

local function add_block(tree, record)
  if not record.block then return end
  local bytes = ByteArray.new(record.block.hex):tvb("CANsync block")
  local branch = tree:add(f.block, bytes())
  branch:append_text(string.format(" (%s 0x%08X)", record.block.download and "download to" or "upload from",
    record.block.address))
  branch:add(f.block_length, record.block.length):set_generated()
  branch:add(f.block_first, record.block.first):set_generated()
end

local function add_sync(tree, pinfo, record, frame)
  tree:add(f.channel, "SYNC")
  add_time(tree, f.since_edge, record.since_edge)
  local words = frame.dlc == 0 and "edge" or "edge, with data " .. telegram.frame_text(frame)
  tree:add(f.text, words):set_generated()
  pinfo.cols.info = "SYNC " .. words
end

-- Nil when Wireshark made no fields: the first of tshark's two passes without a display filter.
local function frame_of(buffer)
  if not frame_identifier() then return nil end
  local extended = frame_extended() and frame_extended().value
  local kind = extended and "extended" or "standard"
  if frame_remote() and frame_remote().value then kind = "remote" end
  local frame = { id = frame_identifier().value, kind = kind, extended = extended, dlc = buffer:len() }
  for i = 0, frame.dlc - 1 do frame[i] = buffer(i, 1):uint() end
  return frame
end

function cansync.dissector(buffer, pinfo, root)
  -- CANsync knows no CAN FD.
  if frame_flexible() then return 0 end
  local frame = frame_of(buffer)
  if not frame then return end
  local is_sync = frame.kind == "standard" and frame.id == cansync.prefs.sync_identifier
  -- A remote frame with the identifier of SYNC is none of ours.
  if not is_sync and telegram.channel(frame.id) == "-" then return 0 end
  local tree = root:add(cansync, buffer())
  pinfo.cols.protocol = "CANsync"
  local record = line:record(pinfo.number)
  if not record then
    local interface = interface_name() and interface_name().value or ""
    local time = math.floor(pinfo.rel_ts * 1e9 + 0.5)
    record = line[is_sync and "sync" or "tell"](line, pinfo.number, interface, time, frame)
  end
  if record.edge then return add_sync(tree, pinfo, record, frame) end

  local channel = frame.kind == "standard" and telegram.channel(frame.id) or "-"
  tree:add(f.channel, channel)
  local t = record.telegram
  if not t then
    local words = telegram.malformed_words(frame, record.wrong)
    tree:add(f.text, words):set_generated()
    tree:add_proto_expert_info(e.malformed, names.decode_errors[record.wrong])
    pinfo.cols.info = channel .. " " .. words
    return
  end
  if t.slave then tree:add(f.slave, t.slave) end
  record.bytes = frame
  add[t.kind](tree, buffer, t, record, channel)
  local words = telegram.words(t, frame, record.asked)
  tree:add(f.text, words):set_generated()
  if t.failed then tree:add_proto_expert_info(e.failed, words) end
  add_relations(tree, record)
  add_block(tree, record)
  local slave = t.slave or (t.polled and t.polled < 32 and t.polled) or ""
  pinfo.cols.info = string.format("%-4s %-2s %s%s", channel, slave, words, record.block and ", block complete" or "")
end

local standard, extended = DissectorTable.get("can.id"), DissectorTable.get("can.extended_id")
for _, range in ipairs({ "16", "256-511", "768-1023", "1280-1535" }) do
  standard:add(range, cansync)
  extended:add(range, cansync)
end

local hooked
local function hook_sync()
  if hooked then standard:remove(hooked, cansync) end
  hooked = nil
  local id = cansync.prefs.sync_identifier
  -- Identifiers of CANsync are hooked already, and stay so.
  if id < 2048 and telegram.channel(id) == "-" then
    hooked = id
    standard:add(hooked, cansync)
  end
end
cansync.prefs_changed = hook_sync
hook_sync()
