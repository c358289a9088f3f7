#include <cansync/cansync_c.h>
#include <stdio.h>
#include <stdlib.h>

/* Uses the C face that is installed. */
int main(int argc, char** argv) {
  if (argc != 2) return 2;
  cansync_client* client = cansync_new();
  const cansync_options options = {.domain = (uint32_t)atoi(argv[1]), .bus = "nobody", .wait_ms = 1};
  const int result = cansync_connect(client, &options);
  printf("%s %s: %s\n", cansync_version(), cansync_result_name(result), cansync_last_error(client));
  cansync_free(client);
  return result == CANSYNC_NO_DAEMON ? 0 : 1;
}
