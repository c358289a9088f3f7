/* The yardstick for cyclic frames: one thread that sleeps to the next absolute instant and writes what is
 * due. Usage: timers INTERFACE SECONDS PRIORITY CPU [bcm]   ("bcm": the kernel's CAN_BCM sends the same
 * frames instead) Frame n has the identifier 0x200 + n and the period of place n below. */
#define _GNU_SOURCE
#include <linux/can.h>
#include <linux/can/bcm.h>
#include <net/if.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define TIMERS 16
static const int periods_ms[TIMERS] = {1, 2, 3, 5, 7, 10, 12, 15, 20, 25, 30, 40, 50, 60, 80, 100};

static long long now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static int kernel_sends(int s) {
  for (int n = 0; n < TIMERS; n++) {
    struct {
      struct bcm_msg_head head;
      struct can_frame frame;
    } m = {.head = {.opcode = TX_SETUP,
                    .flags = SETTIMER | STARTTIMER,
                    .can_id = 0x200u + (unsigned)n,
                    .nframes = 1,
                    .ival2 = {periods_ms[n] / 1000, periods_ms[n] % 1000 * 1000}},
           .frame = {.can_id = 0x200u + (unsigned)n, .can_dlc = 8}};
    if (write(s, &m, sizeof m) != sizeof m) return perror("TX_SETUP"), 1;
  }
  return 0;
}

int main(int argc, char** argv) {
  if (argc < 5) return fprintf(stderr, "usage: %s INTERFACE SECONDS PRIORITY CPU [bcm]\n", argv[0]), 2;
  const int bcm = argc > 5;
  const int s = bcm ? socket(PF_CAN, SOCK_DGRAM, CAN_BCM) : socket(PF_CAN, SOCK_RAW, CAN_RAW);
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(argv[1])};
  if (s < 0 || (bcm ? connect(s, (const struct sockaddr*)&address, sizeof address)
                    : bind(s, (const struct sockaddr*)&address, sizeof address)) != 0)
    return perror(argv[1]), 1;
  if (bcm) return kernel_sends(s) != 0 || sleep((unsigned)atoi(argv[2])) != 0;
  setsockopt(s, SOL_CAN_BASE + CAN_RAW, 1, NULL, 0); /* CAN_RAW_FILTER: receive nothing */
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET((size_t)atoi(argv[4]), &cpus);
  const struct sched_param priority = {.sched_priority = atoi(argv[3])};
  if (sched_setaffinity(0, sizeof cpus, &cpus) != 0) perror("affinity");
  if (sched_setscheduler(0, SCHED_FIFO, &priority) != 0) perror("priority");
  if (mlockall(MCL_CURRENT) != 0) perror("mlockall");
  long long due[TIMERS];
  const long long end = now() + atoi(argv[2]) * 1000000000LL;
  for (int n = 0; n < TIMERS; n++) due[n] = now() + 10000000LL;
  while (now() < end) {
    int first = 0;
    for (int n = 1; n < TIMERS; n++)
      if (due[n] < due[first]) first = n;
    const struct timespec at = {due[first] / 1000000000LL, due[first] % 1000000000LL};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL);
    const struct can_frame frame = {.can_id = 0x200u + (unsigned)first, .can_dlc = 8};
    if (write(s, &frame, sizeof frame) < 0) perror("write");
    due[first] += periods_ms[first] * 1000000LL;
  }
  return 0;
}
