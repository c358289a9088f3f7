/* Reference values of the C face over a restart of the daemon and another mapping, which c_face_test.cpp does
 * as soon as it has got the first value of each step: DOMAIN BUS. Exit code 0: every check held. */
#include <cansync/cansync_c.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static int failures = 0;
static cansync_client* client = NULL;

#define CHECK(condition)                                                                            \
  do {                                                                                              \
    if (!(condition)) {                                                                             \
      printf("line %d: %s does not hold (%s)\n", __LINE__, #condition, cansync_last_error(client)); \
      failures++;                                                                                   \
    }                                                                                               \
  } while (0)

static int give(uint8_t telegram, int32_t first) {
  const int32_t value[4] = {first, 0, 0, 0};
  return cansync_give_references(client, telegram, value, 1, 1, 0);
}

/* Gives the value until nothing is given any more. While no daemon is there it cannot be written. */
static void give_until_told(int32_t first, const char* why) {
  const time_t end = time(NULL) + 30;
  int result = CANSYNC_DONE;
  while ((result == CANSYNC_DONE || result == CANSYNC_FAILED) && time(NULL) < end) result = give(1, first);
  CHECK(result == CANSYNC_TAKE_UP);
  CHECK(strstr(cansync_last_error(client), why) != NULL);
  CHECK(strstr(cansync_last_error(client), "take_up") != NULL);
}

/* The daemon serves this program, and its values go nowhere. */
static void check_that_nothing_is_given(int32_t first) {
  cansync_parameter parameter;
  const time_t end = time(NULL) + 30;
  /* One is told of the restart before every topic of the daemon is known. */
  int result = cansync_read(client, 0, 1, 0, &parameter);
  while (result != CANSYNC_DONE && time(NULL) < end) result = cansync_read(client, 0, 1, 0, &parameter);
  CHECK(result == CANSYNC_DONE);
  for (int i = 0; i < 100 && failures == 0; i++) {
    CHECK(give(1, first) == CANSYNC_TAKE_UP);
    CHECK(give(2, first) == CANSYNC_TAKE_UP); /* one standing for both telegrams */
  }
  CHECK(cansync_read(client, 0, 1, 0, &parameter) == CANSYNC_DONE);
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const cansync_options options = {
      .domain = (uint32_t)atoi(argv[1]), .bus = argv[2], .client_name = "c face", .wait_ms = 20000};
  client = cansync_new();
  CHECK(cansync_connect(client, &options) == CANSYNC_DONE);
  CHECK(cansync_take_references(client, 5) == CANSYNC_DONE);
  if (failures != 0) return 1;

  give_until_told(1, "started anew");
  check_that_nothing_is_given(2);
  if (failures != 0) return 1;
  CHECK(cansync_take_references(client, 5) == CANSYNC_DONE);

  give_until_told(3, "mapping of the reference values was changed");
  check_that_nothing_is_given(4);
  CHECK(cansync_take_references(client, 5) == CANSYNC_DONE);

  /* As a program does, again and again: until the daemon has heard that what was taken up before is given up, a value waits
   * and is not kept. The daemon has taken one for sure when it has answered the requests behind it. */
  cansync_parameter parameter;
  int result = CANSYNC_FAILED;
  for (int i = 0; i < 200; i++) {
    result = give(1, 5);
    CHECK(cansync_read(client, 0, 1, 0, &parameter) == CANSYNC_DONE);
  }
  CHECK(result == CANSYNC_DONE);
  CHECK(strcmp(cansync_last_error(client), "") == 0);
  cansync_free(client);
  return failures == 0 ? 0 : 1;
}
