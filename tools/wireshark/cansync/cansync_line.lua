-- What one frame means beside the others: time after SYNC, command and answer, blocks of transfers. Frames are
-- told once, in their order; what follows from them is kept by frame number. Without Wireshark's API.
local names, telegram = ...
local M = {}

-- Interface name of the SYNC edges in captures of the simulated line; they hold for every interface.
local kSyncInterface = "sync"

local Line = {}
Line.__index = Line

-- settings: bit_rate (0: by the distance of SYNC edges), stamps ("start" or "end" of the frame), tolerance (ns, of
-- stamps of the end)
function M.new(settings)
  if settings.stamps == "start" then settings.tolerance = 0 end
  return setmetatable({ settings = settings, records = {}, edges = {}, slaves = {}, rate = settings.bit_rate }, Line)
end

-- The record of a frame that was told, or nil.
function Line:record(number) return self.records[number] end

-- Beginning and end of a frame in ns. Without a bit rate both are its stamp.
function Line:span(time, f)
  if self.rate == 0 then return time, time end
  local length = telegram.frame_bits(f) * 1e9 / self.rate
  if self.settings.stamps == "start" then return time, time + length end
  return time - length, time
end

-- The bit rate by the shortest distance of two edges so far: where an edge is missing it is longer.
function Line:measure(distance)
  for rate, slots in pairs(names.slots) do
    local interval = slots.interval * 1000
    if math.abs(distance - interval) < interval / 10 and rate > self.rate then self.rate = rate end
  end
end

-- A frame that marks the SYNC edge.
function Line:sync(number, interface, time, f)
  -- On an interface of its own it is no frame but the edge itself.
  local at = interface == kSyncInterface and time or self:span(time, f)
  local before = self.edges[interface]
  local record = { edge = true }
  if before then
    record.since_edge = at - before.at
    if self.settings.bit_rate == 0 then self:measure(record.since_edge) end
  end
  self.edges[interface] = { at = at, number = (before and before.number or 0) + 1, frame = number }
  self.records[number] = record
  return record
end

local function mark(record, kind, text) record.marks[#record.marks + 1] = { kind = kind, text = text } end

local function microseconds(ns) return string.format("%.0f", ns / 1000) end

-- Later than the channel's latest start? An answer within the interval of its command (set-up, where no
-- reference values are on the bus) has tRSPTO alone.
function Line:judge_slot(record, channel, begin, edge, request)
  local slots = names.slots[self.rate]
  if not edge or not slots then return end
  record.after_sync = begin - edge.at
  record.edge_frame = edge.frame
  if record.after_sync > slots.interval * 1100 then
    mark(record, "sync", "no SYNC edge for " .. microseconds(record.after_sync) .. " us: slots cannot be judged")
    return
  end
  if channel == "RC" and (not request or request.edge == edge.number) then return end
  record.limit = slots[channel] * 1000
  local late = record.after_sync - record.limit
  if late > self.settings.tolerance then
    mark(record, "late", string.format("%s started %s us after SYNC, %s us after its latest start", channel,
      microseconds(record.after_sync), microseconds(late)))
  end
end

-- Does the answer belong to the command? An error names any offset.
local function belongs(request, t)
  local asked = request.telegram
  if t.kind == "parameter_reply" then return asked.kind == "parameter" and asked.number == t.number end
  if asked.kind == "parameter" then return false end
  return asked.kind == "initialise" or t.failed or t.busy or asked.offset == t.offset
end

local function same(a, b, fa, fb)
  if a.kind ~= b.kind or fa.dlc ~= fb.dlc then return false end
  for i = 0, fa.dlc - 1 do if fa[i] ~= fb[i] then return false end end
  return true
end

-- A command to one slave.
function Line:command(slave, entry)
  local before = slave.request
  if before and not before.answer then self.records[before.frame].unanswered = true end
  local again = before and same(before.telegram, entry.telegram, before.bytes, entry.bytes)
  if again and (before.busy or not before.answer) then
    entry.first = before.first
    self.records[entry.frame].repeats = before.frame
  else
    entry.first = { frame = entry.frame, time = entry.time }
  end
  slave.request = entry
  local t = entry.telegram
  if t.kind == "initialise" then
    slave.transfer = nil
    if not telegram.is_cancel(t) then
      slave.transfer = { download = t.download, length = t.length, address = t.address, sub_slave = t.sub_slave,
        first = entry.frame, bytes = {} }
    end
  elseif t.kind == "download" and slave.transfer then
    for i = 0, 5 do slave.transfer.bytes[t.offset + i] = entry.bytes[2 + i] end
  end
end

-- The block that ends with this answer, whole or not.
local function finish_block(record, transfer, offset)
  local length = transfer.length > 0 and transfer.length or offset + 6
  local out = {}
  for i = 0, length - 1 do
    if transfer.bytes[i] == nil then
      return mark(record, "incomplete", string.format("byte %d of the block's %d is not in the capture", i, length))
    end
    out[#out + 1] = string.format("%02X", transfer.bytes[i])
  end
  record.block = { hex = table.concat(out), length = length, address = transfer.address, first = transfer.first,
    download = transfer.download }
end

function Line:transfer_answer(slave, record, t, f)
  local asked, transfer = slave.request.telegram, slave.transfer
  if not transfer or t.busy then return end
  if asked.kind == "initialise" then
    if t.failed then slave.transfer = nil end
    if not transfer.download and t.offset > 0 then transfer.length = t.offset end
  elseif not t.failed then
    if asked.kind == "upload" and t.size == 6 then
      for i = 0, 5 do transfer.bytes[t.offset + i] = f[2 + i] end
    end
    if asked.last then
      finish_block(record, transfer, asked.offset)
      slave.transfer = nil
    end
  end
end

-- An answer: to which command, and after what time.
function Line:answer(slave, record, number, t, f, begin, time)
  local request = slave.request
  record.asked = request and request.telegram
  if not request then return nil end
  if not belongs(request, t) then
    mark(record, "unexpected", names.unexpected.wrong_answer)
    return nil
  end
  if request.answer then
    mark(record, "unexpected", names.unexpected.duplicate)
    return nil
  end
  request.answer, request.busy = number, t.busy
  self.records[request.frame].answer = number
  record.request, record.time = request.frame, time - request.time
  if request.first.frame ~= request.frame then
    record.first, record.since_first = request.first.frame, time - request.first.time
  end
  if self.rate ~= 0 then
    record.response = begin - request.finish
    local allowed = names.slots[self.rate].timeout * 1000
    if record.response > allowed + self.settings.tolerance then
      mark(record, "slow", string.format("answered after %s us, over tRSPTO of %s us", microseconds(record.response),
        microseconds(allowed)))
    end
  end
  if t.kind == "transfer_reply" then self:transfer_answer(slave, record, t, f) end
  return request
end

-- Tells a frame and gives its record: `telegram` or `wrong`, `asked`, `after_sync`, `limit`, `edge_frame`,
-- `request`, `answer`, `time`, `response`, `first`, `since_first`, `repeats`, `block`, and `marks` of kinds late, slow, sync,
-- unexpected, incomplete. Times in ns.
function Line:tell(number, interface, time, f)
  local record = { marks = {} }
  self.records[number] = record
  local t, wrong = telegram.decode(f)
  record.telegram, record.wrong = t, wrong
  if not t then return record end
  local begin, finish = self:span(time, f)
  local edge = self.edges[interface] or self.edges[kSyncInterface]
  local request
  if t.slave then
    local key = interface .. " " .. t.slave
    self.slaves[key] = self.slaves[key] or {}
    local slave = self.slaves[key]
    if t.kind == "parameter_reply" or t.kind == "transfer_reply" then
      request = self:answer(slave, record, number, t, f, begin, time)
    elseif t.kind ~= "actual" then
      self:command(slave, { frame = number, time = time, finish = finish, telegram = t, bytes = f,
        edge = edge and edge.number })
    end
  end
  self:judge_slot(record, telegram.channel(f.id), begin, edge, request)
  return record
end

return M
