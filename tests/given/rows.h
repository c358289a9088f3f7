#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "row_on.h"

namespace given {

/// The rows of the table by their names, as a daemon of their own each.
class Rows {
 public:
  /// `of`: what it is constructed with.
  template <class Made, class... Of>
  void add(const std::string& name, const Of&... of) {
    makers_[name] = [of...] { return std::make_unique<Made>(of...); };
  }
  /// Throws std::out_of_range when there is no such row.
  std::unique_ptr<Row> make(const std::string& name) const { return makers_.at(name)(); }
  const std::map<std::string, std::function<std::unique_ptr<Row>()>>& all() const { return makers_; }

 private:
  std::map<std::string, std::function<std::unique_ptr<Row>()>> makers_;
};

Rows all_rows();

void add_master_rows(Rows& rows);
void add_slave_rows(Rows& rows);
void add_cluster_rows(Rows& rows);
void add_layer2_rows(Rows& rows);
void add_j1939_rows(Rows& rows);

/// Reference values, as row `name`.
void add_references(Rows& rows, const std::string& name, const ProtocolUnderTest& under_test);
/// What may be given to the master of a line, as rows `PROTOCOL.references` and others: two slaves, 0 and 1.
void add_line_rows(Rows& rows, const std::string& protocol, const ProtocolUnderTest& under_test);
/// What may be given to a slave, as rows `PROTOCOL.actual_values` and others.
void add_side_rows(Rows& rows, const std::string& protocol, const ProtocolUnderTest& under_test);

}  // namespace given
