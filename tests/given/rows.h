#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "row.h"

namespace given {

/// The rows of the table by their names, as a daemon of their own each.
class Rows {
 public:
  template <class Made>
  void add(const std::string& name) {
    makers_[name] = [] { return std::make_unique<Made>(); };
  }
  /// Throws std::out_of_range when there is no such row.
  std::unique_ptr<Row> make(const std::string& name) const { return makers_.at(name)(); }
  const std::map<std::string, std::function<std::unique_ptr<Row>()>>& all() const { return makers_; }

 private:
  std::map<std::string, std::function<std::unique_ptr<Row>()>> makers_;
};

void add_layer2_rows(Rows& rows);
void add_j1939_rows(Rows& rows);
void add_master_rows(Rows& rows);

}  // namespace given
