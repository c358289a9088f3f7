/* The yardstick for sending: sleep to an absolute instant, write the frames, nothing else.
 * Usage: sender INTERFACE|- INTERVAL_US SECONDS PRIORITY CPU   ("-": datagrams to a local socket instead of
 * CAN) Prints, in ns: one line "late DELAY" of the wake-up and "sent DELAY" from it to the last frame, per
 * interval. */
#define _GNU_SOURCE
#include <linux/can.h>
#include <net/if.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

static long long now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static int open_can(const char* name) {
  const int s = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(name)};
  if (s < 0 || bind(s, (const struct sockaddr*)&address, sizeof address) != 0)
    return perror(name), exit(1), -1;
  setsockopt(s, SOL_CAN_BASE + CAN_RAW, 1, NULL, 0); /* CAN_RAW_FILTER: receive nothing */
  return s;
}

int main(int argc, char** argv) {
  if (argc != 6)
    return fprintf(stderr, "usage: %s INTERFACE|- INTERVAL_US SECONDS PRIORITY CPU\n", argv[0]), 2;
  const long long interval = atoll(argv[2]) * 1000;
  const long count = (long)(atof(argv[3]) * 1e9 / (double)interval);
  long long(*log)[2] = calloc((size_t)count, sizeof *log);
  int pair[2] = {-1, -1};
  const int can = strcmp(argv[1], "-") != 0;
  if (can)
    pair[0] = open_can(argv[1]);
  else if (socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, pair) != 0)
    return perror("socketpair"), 1;
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET((size_t)atoi(argv[5]), &cpus);
  const struct sched_param priority = {.sched_priority = atoi(argv[4])};
  if (sched_setaffinity(0, sizeof cpus, &cpus) != 0) perror("affinity");
  if (priority.sched_priority > 0 && sched_setscheduler(0, SCHED_FIFO, &priority) != 0) perror("priority");
  if (mlockall(MCL_CURRENT) != 0) perror("mlockall");
  struct can_frame frame[4] = {{.can_id = 0x080, .can_dlc = 0},
                               {.can_id = 0x100, .can_dlc = 8},
                               {.can_id = 0x180, .can_dlc = 8},
                               {.can_id = 0x500, .can_dlc = 8}};
  char drain[64];
  const long long start = now() + 10 * interval;
  for (long i = 0; i < count; i++) {
    const long long due = start + i * interval;
    const struct timespec at = {due / 1000000000LL, due % 1000000000LL};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL);
    const long long woke = now();
    log[i][0] = woke - due;
    for (int f = 0; f < 4; f++) {
      if (write(pair[0], &frame[f], sizeof frame[f]) < 0) log[i][1] = -1;
    }
    log[i][1] = now() - woke;
    if (!can)
      while (read(pair[1], drain, sizeof drain) > 0) {
      }
  }
  for (long i = 0; i < count; i++) printf("late %lld sent %lld\n", log[i][0], log[i][1]);
  return 0;
}
