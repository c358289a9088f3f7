/* Notes when each frame was seen on a CAN interface, without disturbing it: prints after SECONDS one line
 * "IDENTIFIER(hex) TIME(ns)" for each frame, by the kernel's receive timestamp. Usage: listener INTERFACE
 * SECONDS */
#include <linux/can.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <time.h>

enum { MOST = 400000 };
static struct {
  unsigned id;
  long long at;
} seen[MOST];

int main(int argc, char** argv) {
  if (argc != 3) return fprintf(stderr, "usage: %s INTERFACE SECONDS\n", argv[0]), 2;
  const int s = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(argv[1])};
  const int on = 1, room = 8 << 20;
  const struct timeval patience = {0, 200000};
  if (s < 0 || bind(s, (const struct sockaddr*)&address, sizeof address) != 0) return perror(argv[1]), 1;
  setsockopt(s, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  setsockopt(s, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room);
  setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  const time_t end = time(NULL) + atoi(argv[2]);
  int count = 0;
  while (time(NULL) < end && count < MOST) {
    struct can_frame frame;
    char control[128];
    struct iovec vector = {&frame, sizeof frame};
    struct msghdr message = {
        .msg_iov = &vector, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
    if (recvmsg(s, &message, 0) < (ssize_t)sizeof frame) continue;
    for (struct cmsghdr* c = CMSG_FIRSTHDR(&message); c != NULL; c = CMSG_NXTHDR(&message, c)) {
      if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
      struct timespec t;
      memcpy(&t, CMSG_DATA(c), sizeof t);
      seen[count].id = frame.can_id;
      seen[count++].at = t.tv_sec * 1000000000LL + t.tv_nsec;
    }
  }
  for (int i = 0; i < count; i++) printf("%X %lld\n", seen[i].id, seen[i].at);
  return 0;
}
