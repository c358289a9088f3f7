/* Requests of tests/client/refusals.json through the C face, one after the other: prints result, cause and
 * whether to ask again, a line for each. Usage: provoke_c DOMAIN BUS CALL NUMBER... [-- CALL NUMBER...]... */
#include <cansync/cansync_c.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char** words;

static uint32_t number(int index) {
  return (uint32_t)strtoul(words[index], NULL, 0);
}

static int ask(cansync_client* client) {
  static uint8_t data[64];
  cansync_parameter parameter;
  const char* call = words[0];
  if (strcmp(call, "read") == 0) return cansync_read(client, number(1), number(2), 0, &parameter);
  if (strcmp(call, "write") == 0) return cansync_write(client, number(1), number(2), number(3), 0);
  if (strcmp(call, "upload") == 0)
    return cansync_upload(client, number(1), number(2), data, number(3), NULL, NULL, NULL);
  if (strcmp(call, "control_word") == 0) return cansync_control_word(client, number(1), number(2));
  if (strcmp(call, "release") == 0) return cansync_release_slave(client, number(1), 0);
  if (strcmp(call, "mode") == 0)
    return cansync_set_mode(client, strcmp(words[1], "run") == 0 ? CANSYNC_MODE_RUN : CANSYNC_MODE_STOP, 0);
  if (strcmp(call, "broadcast") == 0)
    return cansync_broadcast(client, number(1), number(2), number(3), number(4), number(5));
  return CANSYNC_INVALID;
}

static const char* retry_name(int retry) {
  switch (retry) {
    case CANSYNC_RETRY_AFTER_CHANGE:
      return "after_change";
    case CANSYNC_RETRY_WHEN_STATE_OVER:
      return "when_state_over";
    case CANSYNC_RETRY_SOON:
      return "soon";
    case CANSYNC_RETRY_LOOK_FIRST:
      return "look_first";
    default:
      return "never";
  }
}

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  const cansync_options options = {.domain = (uint32_t)atoi(argv[1]), .bus = argv[2]};
  cansync_client* client = cansync_new();
  if (cansync_connect(client, &options) != CANSYNC_DONE) {
    printf("%s\n", cansync_last_error(client));
    return 1;
  }
  for (int next = 3; next < argc; next++) {
    words = argv + next;
    const int result = ask(client);
    const int cause = cansync_last_cause(client);
    printf("%s %s %s\n", cansync_result_name(result), cansync_cause_name(cause),
           retry_name(cansync_retry(result, cause)));
    while (next < argc && strcmp(argv[next], "--") != 0) next++;
  }
  cansync_free(client);
  return 0;
}
