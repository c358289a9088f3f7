/* Writes every arrived actual value telegram of every slave as a line of CSV to standard output, with the C
 * face of the client library. Usage: data_logger DOMAIN BUS LINES        Exit code: 0 done, 1 failed */
#include <cansync/cansync_c.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <threads.h>

/* The callback must be short: it only puts samples into a ring that the main thread empties. */
enum { RING = 4096 };
static cansync_actual_values ring[RING];
static size_t written = 0;
static size_t taken = 0;
static size_t lost = 0;
static mtx_t lock;
static cnd_t changed;

static void on_values(void* user, const cansync_actual_values* values) {
  (void)user;
  mtx_lock(&lock);
  if (written - taken < RING) {
    ring[written++ % RING] = *values;
  } else {
    lost++;
  }
  cnd_signal(&changed);
  mtx_unlock(&lock);
}

static cansync_actual_values next(void) {
  mtx_lock(&lock);
  while (written == taken) cnd_wait(&changed, &lock);
  const cansync_actual_values values = ring[taken++ % RING];
  mtx_unlock(&lock);
  return values;
}

static int failed(cansync_client* client) {
  fprintf(stderr, "%s\n", cansync_last_error(client));
  cansync_free(client);
  return 1;
}

int main(int argc, char** argv) {
  if (argc != 4) return fprintf(stderr, "usage: %s DOMAIN BUS LINES\n", argv[0]), 1;
  if (mtx_init(&lock, mtx_plain) != thrd_success || cnd_init(&changed) != thrd_success) return 1;
  cansync_client* client = cansync_new();
  const cansync_options options = {
      .domain = (uint32_t)atoi(argv[1]), .bus = argv[2], .client_name = "data logger"};
  if (cansync_connect(client, &options) != CANSYNC_DONE) return failed(client);
  if (cansync_subscribe_actual_values(client, on_values, NULL) != CANSYNC_DONE) return failed(client);

  printf("receive_time_ns,slave,telegrams,interval_1,interval_2");
  for (int i = 0; i < 8; i++) printf(",value_%d", i);
  printf("\n");
  for (long line = 0; line < atol(argv[3]); line++) {
    const cansync_actual_values values = next();
    printf("%" PRId64 ",%" PRIu32 ",%" PRIu32 ",%" PRIu64 ",%" PRIu64, values.receive_time_ns, values.slave,
           values.arrived, values.interval[0], values.interval[1]);
    for (int i = 0; i < 8; i++) printf(",%.10g", values.scaled[i]);
    printf("\n");
  }
  cansync_free(client);
  if (lost != 0) fprintf(stderr, "%zu telegrams lost: the output was too slow\n", lost);
  return 0;
}
