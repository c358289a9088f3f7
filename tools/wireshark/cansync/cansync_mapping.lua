-- Which value's low or high word stands in which word of a telegram (M 3.1.1.1), from the texts of the
-- preferences. Without Wireshark's API.
local M = {}

-- A mapping from "01 03 05 07" (register bytes: bit 0 assigned, 1 high word, 2..6 value number) or
-- "0,0,1,1 / F,T,F,T" (value numbers, -1 = unused; high words): for each word { number, high } or false.
-- Nothing when the text is empty or wrong.
function M.parse(text)
  local out = {}
  local numbers, flags = text:match("^([^/]*)/([^/]*)$")
  if numbers then
    for number in numbers:gmatch("[^%s,]+") do
      number = tonumber(number)
      if not number or number < -1 or number > 7 then return nil end
      out[#out + 1] = number >= 0 and { number = number }
    end
    local at = 0
    for flag in flags:gmatch("[^%s,]+") do
      at = at + 1
      if flag ~= "T" and flag ~= "F" then return nil end
      if out[at] then out[at].high = flag == "T" elseif flag == "T" then return nil end
    end
    return at == 4 and #out == 4 and out or nil
  end
  for byte in text:gmatch("[^%s,]+") do
    byte = tonumber((byte:gsub("^0[xX]", "")), 16)
    if not byte or byte > 0x1F or byte ~= 0 and byte % 2 == 0 then return nil end
    out[#out + 1] = byte ~= 0 and { number = math.floor(byte / 4), high = math.floor(byte / 2) % 2 == 1 }
  end
  return #out == 4 and out or nil
end

local function signed(word) return word >= 0x8000 and word - 0x10000 or word end

-- The values in the words of a telegram, in the order of their numbers: { number, text }; `number` is the signed
-- doubleword, of a low word alone the signed word, and of a high word alone the doubleword with a low word of 0.
function M.values(map, words)
  local low, high = {}, {}
  for i, place in ipairs(map or {}) do
    if place and words[i] then (place.high and high or low)[place.number] = words[i] end
  end
  local out = {}
  for n = 0, 7 do
    local value = (low[n] or 0) + (high[n] or 0) * 65536
    if value >= 2 ^ 31 then value = value - 2 ^ 32 end
    if not high[n] and low[n] then value = signed(low[n]) end
    if low[n] and high[n] then
      out[#out + 1] = { number = value, text = string.format("Value %d: %.0f", n, value) }
    elseif low[n] then
      out[#out + 1] = { number = value, text = string.format("Value %d: low word %d", n, signed(low[n])) }
    elseif high[n] then
      out[#out + 1] = { number = value, text = string.format("Value %d: high word %d", n, signed(high[n])) }
    end
  end
  return out
end

return M
