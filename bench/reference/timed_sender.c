/* As sender.c, but the kernel keeps the slots: after one wake-up the SYNC frame is written, and three
 * telegrams with the instants at which they are to leave (SO_TXTIME, queueing discipline etf). etf hands a
 * frame to the driver DELTA before its transmit time, and drops it after that, so DELTA is also how late it
 * may be. Usage: timed_sender INTERFACE INTERVAL_US SECONDS PRIORITY CPU DELTA_US SLOT_US SLOT_US SLOT_US
 * Prints, in ns: one line "late DELAY" of the wake-up and "sent DELAY" from it to the last frame, per
 * interval. */
#define _GNU_SOURCE
#include <linux/can.h>
#include <linux/net_tstamp.h>
#include <net/if.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { SLOTS = 3 };

static long long read_clock(clockid_t which) {
  struct timespec t;
  clock_gettime(which, &t);
  return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static int open_can(const char* name) {
  const int s = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(name)};
  if (s < 0 || bind(s, (const struct sockaddr*)&address, sizeof address) != 0)
    return perror(name), exit(1), -1;
  setsockopt(s, SOL_CAN_BASE + CAN_RAW, 1, NULL, 0); /* CAN_RAW_FILTER: receive nothing */
  const struct sock_txtime timed = {.clockid = CLOCK_TAI, .flags = 0};
  if (setsockopt(s, SOL_SOCKET, SO_TXTIME, &timed, sizeof timed) != 0)
    return perror("SO_TXTIME"), exit(1), -1;
  return s;
}

/* 0 when the kernel has taken it. */
static int send_at(int s, const struct can_frame* frame, unsigned long long at) {
  char control[CMSG_SPACE(sizeof at)] = {0};
  struct iovec vector = {(void*)frame, sizeof *frame};
  struct msghdr message = {
      .msg_iov = &vector, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
  struct cmsghdr* c = CMSG_FIRSTHDR(&message);
  c->cmsg_level = SOL_SOCKET;
  c->cmsg_type = SCM_TXTIME;
  c->cmsg_len = CMSG_LEN(sizeof at);
  memcpy(CMSG_DATA(c), &at, sizeof at);
  return sendmsg(s, &message, 0) == (ssize_t)sizeof *frame ? 0 : -1;
}

int main(int argc, char** argv) {
  if (argc != 7 + SLOTS)
    return fprintf(stderr, "usage: %s INTERFACE INTERVAL_US SECONDS PRIORITY CPU DELTA_US SLOT_US...\n",
                   argv[0]),
           2;
  const long long interval = atoll(argv[2]) * 1000, delta = atoll(argv[6]) * 1000;
  const long count = (long)(atof(argv[3]) * 1e9 / (double)interval);
  long long slot[SLOTS];
  for (int i = 0; i < SLOTS; i++) slot[i] = atoll(argv[7 + i]) * 1000;
  long long(*log)[2] = calloc((size_t)count, sizeof *log);
  const int s = open_can(argv[1]);
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET((size_t)atoi(argv[5]), &cpus);
  const struct sched_param priority = {.sched_priority = atoi(argv[4])};
  if (sched_setaffinity(0, sizeof cpus, &cpus) != 0) perror("affinity");
  if (priority.sched_priority > 0 && sched_setscheduler(0, SCHED_FIFO, &priority) != 0) perror("priority");
  if (mlockall(MCL_CURRENT) != 0) perror("mlockall");
  const struct can_frame sync = {.can_id = 0x080, .can_dlc = 0};
  const struct can_frame frame[SLOTS] = {
      {.can_id = 0x100, .can_dlc = 8}, {.can_id = 0x180, .can_dlc = 8}, {.can_id = 0x500, .can_dlc = 8}};
  const long long start = read_clock(CLOCK_MONOTONIC) + 10 * interval;
  for (long i = 0; i < count; i++) {
    const long long due = start + i * interval;
    const struct timespec at = {due / 1000000000LL, due % 1000000000LL};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL);
    const long long woke = read_clock(CLOCK_MONOTONIC);
    const long long ahead = read_clock(CLOCK_TAI) - woke;
    log[i][0] = woke - due;
    /* etf sends no frame without a time: this one leaves at once. */
    int failed = send_at(s, &sync, (unsigned long long)(woke + ahead + delta));
    for (int f = 0; f < SLOTS; f++)
      failed |= send_at(s, &frame[f], (unsigned long long)(due + ahead + slot[f] + delta));
    log[i][1] = failed != 0 ? -1 : read_clock(CLOCK_MONOTONIC) - woke;
  }
  for (long i = 0; i < count; i++) printf("late %lld sent %lld\n", log[i][0], log[i][1]);
  return 0;
}
