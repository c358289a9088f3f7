#ifndef CANSYNC_C_BASE_H
#define CANSYNC_C_BASE_H

/* What every part of the C face needs: how calls end, why requests are refused, the handle. Included by
 * <cansync/cansync_c.h>, as everything else of the C face. */

#ifdef __cplusplus
#define CANSYNC_C_NOEXCEPT noexcept
#else
#define CANSYNC_C_NOEXCEPT
#endif
#define CANSYNC_C_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

/* How a call ended; the numbers stay. 1 to 11 and 17 are what the daemon or the slave said. */
enum cansync_result {
  CANSYNC_DONE = 0,
  CANSYNC_REFUSED = 1,     /* not accepted, nothing was sent */
  CANSYNC_SLAVE_ERROR = 2, /* the slave answered with an error code */
  CANSYNC_TIMEOUT = 3,   /* no (final) answer of the slave within the monitoring time; a command: not sent */
  CANSYNC_NO_ANSWER = 4, /* a write was not answered, or a control word or broadcast not seen on the bus;
                          * whether the slave took it is not known */
  CANSYNC_WORD_EXPECTED = 5,       /* the parameter is a word */
  CANSYNC_DOUBLEWORD_EXPECTED = 6, /* the parameter is a doubleword */
  CANSYNC_VALUE_TOO_WIDE = 7,      /* the parameter is a word that cannot hold the value */
  CANSYNC_CANCELLED = 8,
  CANSYNC_MASTER_STOPPED = 9,
  CANSYNC_SLAVE_LOST = 10, /* the slave stopped answering; what was under way may have been taken or not */
  CANSYNC_NO_REPLY = 11, /* the daemon has gone, or gave no reply in time; whether it was done is not known */
  CANSYNC_NO_DAEMON = 12,    /* no daemon serves the bus; nothing was sent */
  CANSYNC_SETUP_FAILED = 13, /* DDS could not be set up, or this program's identity has no right to */
  CANSYNC_NO_DATA = 14,      /* nothing is known yet */
  CANSYNC_INVALID = 15,      /* a wrong argument, or the handle is not connected */
  CANSYNC_FAILED = 16,       /* memory or threads are used up, or the values could not be written */
  CANSYNC_TAKE_UP = 17, /* the daemon was started anew, or the reference mapping changed: nothing was given */
  CANSYNC_REPLACED =
      18 /* a control word or broadcast that was not sent: a newer word, or a stop, took its place */
};

/* Why a request was refused (CANSYNC_REFUSED); nothing was sent then. The numbers stay; they are those of the
 * data model. */
enum cansync_cause {
  CANSYNC_CAUSE_NONE = 0,    /* not refused */
  CANSYNC_CAUSE_UNKNOWN = 1, /* no cause is known, as from a daemon older than this member */
  CANSYNC_CAUSE_FIELD = 2,   /* a field is out of its range; reason names field, value and allowed range */
  CANSYNC_CAUSE_SLAVE_NOT_CONFIGURED = 3, /* the slave is not one of this line's */
  CANSYNC_CAUSE_ELEMENT_NOT_WRITABLE = 4, /* only element 7 may be written */
  CANSYNC_CAUSE_VALUE_TOO_WIDE =
      5,                    /* a word holds 0..65535, a reference value sent as its low word -32768..65535 */
  CANSYNC_CAUSE_LENGTH = 6, /* of a transfer or a frame */
  CANSYNC_CAUSE_BLOCK_SIZE = 7,      /* over the slave's limit, or no whole start addresses */
  CANSYNC_CAUSE_ADDRESS = 8,         /* reserved, or the end lies over 32 bits */
  CANSYNC_CAUSE_ACTION_RESERVED = 9, /* action command 0 or 2..127 */
  CANSYNC_CAUSE_NO_SLAVES = 10,      /* empty group */
  CANSYNC_CAUSE_MAPPING = 11,     /* no register byte, or a word that names a value of the other telegram */
  CANSYNC_CAUSE_KIND = 12,        /* kind of request that this daemon does not know */
  CANSYNC_CAUSE_UNKNOWN_JOB = 13, /* nothing is open under that number */
  CANSYNC_CAUSE_NUMBER_USED = 14, /* the client has used that number before: take a new one */
  CANSYNC_CAUSE_IDENTITY =
      15, /* the identity is another program's, or its program has just gone: take one at random */
  CANSYNC_CAUSE_NOT_HELD = 16, /* the slave is not held out: nothing to release */
  CANSYNC_CAUSE_PROFILE =
      17, /* the slave's drive profile forbids it: read-only, outside its limits, wider than its format */
  CANSYNC_CAUSE_READ_ONLY = 18, /* the daemon changes neither drive nor line (access.read_only) */
  CANSYNC_CAUSE_RIGHT = 19, /* the client lacks a right of DDS Security, or the daemon one of the system */
  CANSYNC_CAUSE_WRONG_STATE = 20,     /* the line is not in setup or run */
  CANSYNC_CAUSE_SLAVE_LOST = 21,      /* the slave does not answer */
  CANSYNC_CAUSE_SLAVE_HELD = 22,      /* the slave is held out: release it first */
  CANSYNC_CAUSE_SLAVES_MISSING = 23,  /* run needs slaves that have not reported; force goes without them */
  CANSYNC_CAUSE_BUS_UNAVAILABLE = 24, /* the interface is missing or down, or its driver does not do it */
  CANSYNC_CAUSE_STOPPING = 25,        /* the daemon is about to end: ask the next one */
  CANSYNC_CAUSE_OTHER_DAEMON =
      26, /* names another start of a daemon, or none: name the one that is there now */
  CANSYNC_CAUSE_MAPPING_CHANGED =
      27, /* reference values made for another mapping than the one in force: take up again */
  CANSYNC_CAUSE_STALE =
      28, /* written too long ago, or in the future: ask anew, and check the clocks when it comes again */
  CANSYNC_CAUSE_QUEUE_FULL = 29,   /* of the line or the slave */
  CANSYNC_CAUSE_CLIENT_LIMIT = 30, /* the client's own open requests, or their bytes */
  CANSYNC_CAUSE_SHARED_LIMIT = 31  /* clients, requests or bytes of all together */
};

/* Whether it helps to ask the same again; the numbers stay. */
enum cansync_retry {
  CANSYNC_RETRY_NEVER = 0,           /* it was done, or will end the same way */
  CANSYNC_RETRY_AFTER_CHANGE = 1,    /* of the configuration, of a drive profile, of rights or of the call */
  CANSYNC_RETRY_WHEN_STATE_OVER = 2, /* when the state is over that cansync_last_error() names */
  CANSYNC_RETRY_SOON = 3,            /* after some tens of milliseconds */
  CANSYNC_RETRY_LOOK_FIRST = 4 /* it may have been done: what only reads may be asked again, what changes
                                * something after a look at what the slave has */
};

/* One connection to one bus. */
typedef struct cansync_client cansync_client;

/* A stable word for a result, for example "slave_error". Never NULL. */
CANSYNC_C_API const char* cansync_result_name(int result) CANSYNC_C_NOEXCEPT;

/* A stable word for a cause, for example "slave_not_configured". Never NULL; "unknown" for a number that is
 * none. */
CANSYNC_C_API const char* cansync_cause_name(int cause) CANSYNC_C_NOEXCEPT;

/* Whether it helps to ask again what ended with this result and, with CANSYNC_REFUSED, this cause: one of
 * CANSYNC_RETRY_... For every result of this header. */
CANSYNC_C_API int cansync_retry(int result, int cause) CANSYNC_C_NOEXCEPT;

#ifdef __cplusplus
}
#endif

#endif
