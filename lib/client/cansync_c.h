#ifndef CANSYNC_C_H
#define CANSYNC_C_H

/* Plain C face of the client library (docs/client-library.md), for C and for every language that can call C.
 *
 * A function that can fail returns a result: 0 (CANSYNC_DONE) or why not, and keeps the reason in words for
 * cansync_last_error(). No function ends the program or lets a C++ exception out.
 *
 * Threads: one handle is for one thread at a time; threads that work at the same time take a handle each.
 * Only cansync_cancel_transfer() may be called at any time. Callbacks of events come on a thread of the
 * library. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#define CANSYNC_C_NOEXCEPT noexcept
#else
#define CANSYNC_C_NOEXCEPT
#endif
#define CANSYNC_C_API __attribute__((visibility("default")))

/* How a call ended; the numbers stay. 1 to 11 are what the daemon or the slave said. */
enum cansync_result {
  CANSYNC_DONE = 0,
  CANSYNC_REFUSED = 1,             /* not accepted, nothing was sent */
  CANSYNC_SLAVE_ERROR = 2,         /* the slave answered with an error code */
  CANSYNC_TIMEOUT = 3,             /* no (final) answer of the slave within the monitoring time */
  CANSYNC_NO_ANSWER = 4,           /* a write was not answered; whether the slave took it is not known */
  CANSYNC_WORD_EXPECTED = 5,       /* the parameter is a word */
  CANSYNC_DOUBLEWORD_EXPECTED = 6, /* the parameter is a doubleword */
  CANSYNC_VALUE_TOO_WIDE = 7,      /* the parameter is a word that cannot hold the value */
  CANSYNC_CANCELLED = 8,
  CANSYNC_MASTER_STOPPED = 9,
  CANSYNC_SLAVE_LOST = 10,   /* the slave stopped answering; what was under way may have been taken or not */
  CANSYNC_NO_REPLY = 11,     /* the daemon has gone; whether the request was done is not known */
  CANSYNC_NO_DAEMON = 12,    /* no daemon serves the bus */
  CANSYNC_SETUP_FAILED = 13, /* DDS could not be set up, or this program's identity has no right to */
  CANSYNC_NO_DATA = 14,      /* nothing is known yet */
  CANSYNC_INVALID = 15,      /* a wrong argument, or the handle is not connected */
  CANSYNC_FAILED = 16        /* memory or threads are used up, or the values could not be written */
};

/* One connection to one bus. */
typedef struct cansync_client cansync_client;

/* Where the daemon is looked for. Zero and NULL mean the default. */
typedef struct cansync_options {
  uint32_t domain;         /* DDS domain, 0..230 */
  const char* bus;         /* the bus's name; default "can0" */
  const char* interface;   /* network interface; default "lo" */
  const char* client_name; /* shown in the daemon's journal, at most 64 characters; default "client" */
  const char* security;    /* DDS Security: folder of this program's identity; default: without */
  uint32_t wait_ms;        /* how long to look for the daemon; default 5000 */
} cansync_options;

/* Version of the library, for example "0.1.0". */
CANSYNC_C_API const char* cansync_version(void) CANSYNC_C_NOEXCEPT;

/* A stable word for a result, for example "slave_error". Never NULL. */
CANSYNC_C_API const char* cansync_result_name(int result) CANSYNC_C_NOEXCEPT;

/* A handle that is not connected yet; NULL when there is no memory. Ends with cansync_free(). */
CANSYNC_C_API cansync_client* cansync_new(void) CANSYNC_C_NOEXCEPT;

/* Disconnects and frees; waits for a callback that is running. Not from a callback. NULL is allowed. */
CANSYNC_C_API void cansync_free(cansync_client* client) CANSYNC_C_NOEXCEPT;

/* What went wrong in the last call with this handle, in words: who refused, why, and what is allowed. Empty
 * when it was done. Lives until the next call with the handle. */
CANSYNC_C_API const char* cansync_last_error(const cansync_client* client) CANSYNC_C_NOEXCEPT;

/* Waits until a daemon serves the bus. `options` NULL: the defaults. A handle connects once.
 * CANSYNC_NO_DAEMON, CANSYNC_SETUP_FAILED, CANSYNC_INVALID. */
CANSYNC_C_API int cansync_connect(cansync_client* client, const cansync_options* options) CANSYNC_C_NOEXCEPT;

#ifdef __cplusplus
}
#endif

#endif
