#include "rows.h"

namespace given {

Rows all_rows() {
  Rows rows;
  add_master_rows(rows);
  add_slave_rows(rows);
  add_cluster_rows(rows);
  add_layer2_rows(rows);
  add_j1939_rows(rows);
  return rows;
}

}  // namespace given
