#include <cansync/client.h>
#include <cansync/topics.h>

#include <string_view>

/// Uses the data model that is installed: a struct that a state function gives, its text and a constant.
int main() {
  using namespace cansync::client;
  SlaveStatus status = {};
  status.slave = cansync_SLAVES - 1;
  status.name[0] = 'w';
  return text(status.name) == std::string_view("w") && status.slave == 31 ? 0 : 1;
}
