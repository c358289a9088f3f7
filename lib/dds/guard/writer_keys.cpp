#include "dds/guard/writer_keys.h"

#include <algorithm>

namespace gateway::dds {

bool WriterKeys::known_or_allowed(dds_instance_handle_t writer, dds_instance_handle_t key) {
  const auto known = keys_.find(writer);
  if (known != keys_.end() && known->second.contains(key)) return true;
  if (count_ >= together_ || (known != keys_.end() && known->second.size() >= per_writer_)) return false;
  keys_[writer].insert(key);
  ++count_;
  return true;
}

void WriterKeys::keep(std::span<const dds_instance_handle_t> living) {
  std::erase_if(keys_, [&](const auto& entry) {
    if (std::find(living.begin(), living.end(), entry.first) != living.end()) return false;
    count_ -= entry.second.size();
    return true;
  });
}

}  // namespace gateway::dds
