/* A first client: reads a parameter, shows ten telegrams of actual values of a slave, gives reference values
 * for two seconds. IT MOVES EVERY DRIVE of the line that follows: for a simulated line.
 * Usage: first_client DOMAIN BUS SLAVE        Exit code: 0 done, 1 failed */
#include <cansync/cansync_c.h>
#include <inttypes.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <threads.h>

static atomic_int shown;

/* On a thread of the library: it must be short. */
static void show(void* user, const cansync_actual_values* values) {
  if (values->slave != *(const uint32_t*)user || shown == 10) return;
  printf("value 0: %" PRId32 ", in its unit: %g\n", (int32_t)values->raw[0], values->scaled[0]);
  shown++;
}

static void pause_ms(int milliseconds) {
  thrd_sleep(&(struct timespec){.tv_sec = milliseconds / 1000, .tv_nsec = milliseconds % 1000 * 1000000L},
             NULL);
}

static int failed(cansync_client* client, const char* what) {
  fprintf(stderr, "%s\n", what);
  cansync_free(client);
  return 1;
}

int main(int argc, char** argv) {
  if (argc != 4) return fprintf(stderr, "usage: %s DOMAIN BUS SLAVE\n", argv[0]), 1;
  const cansync_options options = {
      .domain = (uint32_t)atoi(argv[1]), .bus = argv[2], .client_name = "first client"};
  uint32_t slave;
  cansync_client* client = cansync_new();
  cansync_parameter status;
  /* cansync_last_error() says who refused, or where it was looked for a daemon, and the remedy. */
  if (cansync_connect(client, &options) != CANSYNC_DONE ||
      cansync_find_slave(client, argv[3], &slave) != CANSYNC_DONE ||
      cansync_read(client, slave, 301, 0, &status) != CANSYNC_DONE)
    return failed(client, cansync_last_error(client));
  printf("parameter 301: 0x%04X\n", (unsigned)status.value);

  /* Values come while somebody gives reference values, or with process.poll_without_reference. */
  if (cansync_subscribe_actual_values(client, show, &slave) != CANSYNC_DONE)
    return failed(client, cansync_last_error(client));
  for (int i = 0; i < 1000 && shown < 10; i++) pause_ms(10);
  cansync_subscribe_actual_values(client, NULL, NULL); /* no callback runs any more */
  if (shown < 10) return failed(client, "no actual values for 10 s: does the line run?");

  /* What a control word means is the drive's matter: this one lets a simulated drive follow, and resets its fault. */
  cansync_actual_values before;
  if (cansync_control_word(client, slave, 0x0087) != CANSYNC_DONE ||
      cansync_get_actual_values(client, slave, 1000, &before) != CANSYNC_DONE ||
      cansync_take_references(client, 0) != CANSYNC_DONE)
    return failed(client, cansync_last_error(client));
  /* Reference values are for all drives of the line. Those given every 20 ms are released for 60 intervals (of 1 ms: three
   * times as long), so that two late ones leave no gap. */
  const int32_t wanted[4] = {(int32_t)before.raw[0] + 65536};
  for (int i = 0; i < 100; i++) {
    if (cansync_give_references(client, 1, wanted, 0x1, 60, 0) != CANSYNC_DONE)
      return failed(client, cansync_last_error(client));
    pause_ms(20);
  }
  cansync_actual_values after;
  if (cansync_get_actual_values(client, slave, 1000, &after) != CANSYNC_DONE)
    return failed(client, cansync_last_error(client));
  printf("value 0 moved by %" PRId32 "\n", (int32_t)(after.raw[0] - before.raw[0]));
  /* Gives them up: a drive that had reference values and gets none any more faults after a while. */
  cansync_free(client);
  return 0;
}
