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
  CANSYNC_CAUSE_WRONG_STATE = 20, /* the line is not in set-up or active operation */
  CANSYNC_CAUSE_SLAVE_LOST = 21,  /* the slave does not answer */
  CANSYNC_CAUSE_SLAVE_HELD = 22,  /* the slave is held out: release it first */
  CANSYNC_CAUSE_SLAVES_MISSING =
      23, /* active operation needs slaves that have not reported; force goes without them */
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

/* Asked every 20 ms, on the waiting thread, while cansync_connect() or cansync_take_references() waits for
 * the daemon; 0 ends the wait with CANSYNC_NO_DAEMON. It may not call a function with the same handle. */
typedef int (*cansync_go_on)(void* user);

/* Where the daemon is looked for. Zero and NULL mean the default. */
typedef struct cansync_options {
  uint32_t domain;         /* DDS domain, 0..230 */
  const char* bus;         /* the bus's name; default "can0" */
  const char* interface;   /* network interface; default "lo" */
  const char* client_name; /* shown in the daemon's journal, at most 64 characters; default "client" */
  const char* security;    /* DDS Security: folder of this program's identity; default: without */
  uint32_t wait_ms;        /* how long to look for the daemon; default 5000 */
  const char* profiles;    /* folder of drive profiles, before the standard ones (docs/profiles.md) */
  cansync_go_on go_on;     /* NULL: nobody is asked */
  void* user;              /* of go_on */
  uint32_t final_types;    /* as the daemon's dds.types: not 0 for "final"; default 0, "appendable" */
} cansync_options;

/* Version of the library, for example "0.1.0". */
CANSYNC_C_API const char* cansync_version(void) CANSYNC_C_NOEXCEPT;

/* A stable word for a result, for example "slave_error". Never NULL. */
CANSYNC_C_API const char* cansync_result_name(int result) CANSYNC_C_NOEXCEPT;

/* A stable word for a cause, for example "slave_not_configured". Never NULL; "unknown" for a number that is
 * none. */
CANSYNC_C_API const char* cansync_cause_name(int cause) CANSYNC_C_NOEXCEPT;

/* Whether it helps to ask again what ended with this result and, with CANSYNC_REFUSED, this cause: one of
 * CANSYNC_RETRY_... For every result of this header. */
CANSYNC_C_API int cansync_retry(int result, int cause) CANSYNC_C_NOEXCEPT;

/* A handle that is not connected yet; NULL when there is no memory. Ends with cansync_free(). */
CANSYNC_C_API cansync_client* cansync_new(void) CANSYNC_C_NOEXCEPT;

/* Disconnects and frees; waits for a callback that is running. Not from a callback. NULL is allowed. */
CANSYNC_C_API void cansync_free(cansync_client* client) CANSYNC_C_NOEXCEPT;

/* What went wrong in the last call with this handle, in words: who refused, why, and what is allowed. Empty
 * when it was done. Lives until the next call with the handle. */
CANSYNC_C_API const char* cansync_last_error(const cansync_client* client) CANSYNC_C_NOEXCEPT;

/* Why the last call with this handle was refused: one of CANSYNC_CAUSE_..., CANSYNC_CAUSE_NONE when it ended
 * otherwise. */
CANSYNC_C_API int cansync_last_cause(const cansync_client* client) CANSYNC_C_NOEXCEPT;

/* Waits until a daemon serves the bus. `options` NULL: the defaults. A handle connects once.
 * CANSYNC_NO_DAEMON, CANSYNC_SETUP_FAILED, CANSYNC_INVALID. */
CANSYNC_C_API int cansync_connect(cansync_client* client, const cansync_options* options) CANSYNC_C_NOEXCEPT;

/* The line as the daemon told it last. */
typedef struct cansync_line_status {
  uint16_t option_status;       /* w_OPTION_STATUS: 0x0080 active operation */
  uint16_t interface_status;    /* w_CANsync_STATUS */
  char state[64];               /* option_status in words */
  uint32_t bit_rate;            /* bit/s */
  uint64_t interval_ns;         /* length of an interval */
  uint64_t interval;            /* number of the running one */
  uint32_t slaves_configured;   /* bit n: slave n */
  uint32_t slaves_responding;   /* likewise: those that answer */
  uint32_t slaves_synchronized; /* likewise: those that are locked to SYNC */
} cansync_line_status;

/* What the daemon told last, at most about a second old while it lives; waits for nothing.
 * CANSYNC_INVALID: `out` is NULL. */
CANSYNC_C_API int cansync_get_status(cansync_client* client, cansync_line_status* out) CANSYNC_C_NOEXCEPT;

/* Waits until the line is in active operation and every configured slave is synchronized. CANSYNC_TIMEOUT. */
CANSYNC_C_API int cansync_wait_active(cansync_client* client, uint32_t timeout_ms) CANSYNC_C_NOEXCEPT;

/* The slave with this number (decimal, or hexadecimal with 0x) or name. CANSYNC_INVALID. */
CANSYNC_C_API int cansync_find_slave(cansync_client* client, const char* number_or_name,
                                     uint32_t* slave) CANSYNC_C_NOEXCEPT;

/* A parameter as it was read. */
typedef struct cansync_parameter {
  uint32_t value;      /* raw */
  int doubleword;      /* 1: 32 bits, 0: 16 bits */
  uint16_t error_code; /* the slave's; 0: none */
  uint32_t intervals;  /* from the first telegram to the answer */
} cansync_parameter;

/* Reads a parameter; waits for the answer. `slave` 0..31, `number` 0..4095, `timeout_ms` 0: the daemon's
 * default. `out` is also filled when the slave answered with an error. */
CANSYNC_C_API int cansync_read(cansync_client* client, uint32_t slave, uint32_t number, uint32_t timeout_ms,
                               cansync_parameter* out) CANSYNC_C_NOEXCEPT;

/* Writes a raw value in the format that the slave wants; waits for the answer. */
CANSYNC_C_API int cansync_write(cansync_client* client, uint32_t slave, uint32_t number, uint32_t value,
                                uint32_t timeout_ms) CANSYNC_C_NOEXCEPT;

/* Bytes done and in total, on the thread that waits for the transfer. Not 0: the transfer is cancelled. */
typedef int (*cansync_progress)(void* user, uint32_t done, uint32_t total);

/* Reads `size` bytes (1..16777216) from the slave's start address (0x100 and more) into `data`; waits for the
 * end. `done` (NULL: not wanted) is how many came. `progress` may be NULL. */
CANSYNC_C_API int cansync_upload(cansync_client* client, uint32_t slave, uint32_t address, void* data,
                                 uint32_t size, uint32_t* done, cansync_progress progress,
                                 void* user) CANSYNC_C_NOEXCEPT;

/* Writes `size` bytes to the slave's start address; waits for the end. */
CANSYNC_C_API int cansync_download(cansync_client* client, uint32_t slave, uint32_t address, const void* data,
                                   uint32_t size, cansync_progress progress, void* user) CANSYNC_C_NOEXCEPT;

/* Cancels the transfer that another thread waits for with this handle; without one the next that is begun, so
 * that a cancel which comes just before is not lost. From any thread, also from a signal handler. */
CANSYNC_C_API void cansync_cancel_transfer(cansync_client* client) CANSYNC_C_NOEXCEPT;

/* Actual values of one slave. */
typedef struct cansync_actual_values {
  uint32_t slave;          /* 0..31 */
  uint32_t raw[8];         /* as on the bus: docs/dds-api.md, ActualValues */
  double scaled[8];        /* in the units of the configuration */
  uint32_t arrived;        /* bit 0, 1: telegram 1, 2 came with this sample */
  uint64_t interval[2];    /* in which each telegram came last */
  int64_t receive_time_ns; /* CLOCK_REALTIME */
} cansync_actual_values;

/* The newest actual values of a slave; waits at most `timeout_ms` for the first. CANSYNC_NO_DATA. */
CANSYNC_C_API int cansync_get_actual_values(cansync_client* client, uint32_t slave, uint32_t timeout_ms,
                                            cansync_actual_values* out) CANSYNC_C_NOEXCEPT;

/* Called on a thread of the library: be short, and call no function with the same handle. */
typedef void (*cansync_on_actual_values)(void* user, const cansync_actual_values* values);

/* Calls `callback` for every arrived actual value telegram from now on, in the place of an earlier one; NULL
 * ends it. When this returns, the earlier one is not running any more. */
CANSYNC_C_API int cansync_subscribe_actual_values(cansync_client* client, cansync_on_actual_values callback,
                                                  void* user) CANSYNC_C_NOEXCEPT;

/* What happened. The texts live during the callback. */
typedef struct cansync_event {
  uint64_t number;   /* rises by one */
  int64_t time_ns;   /* CLOCK_REALTIME */
  uint64_t interval; /* in which it happened */
  int32_t severity;  /* 0 information, 1 warning, 2 error */
  int32_t slave;     /* 0..31; -1: none */
  const char* code;  /* stable word, for example slave_lost */
  const char* text;
} cansync_event;

/* Called on a thread of the library: be short, and call no function with the same handle. */
typedef void (*cansync_on_event)(void* user, const cansync_event* event);

/* Like cansync_subscribe_actual_values, for events: the last 100 first, then each as it happens. */
CANSYNC_C_API int cansync_subscribe_events(cansync_client* client, cansync_on_event callback,
                                           void* user) CANSYNC_C_NOEXCEPT;

/* Takes the right to give reference values: of the living writers of a telegram the one with the highest
 * strength (0 and more) wins. Waits at most 2 s for the daemon. Again: with the new strength. */
CANSYNC_C_API int cansync_take_references(cansync_client* client, int32_t strength) CANSYNC_C_NOEXCEPT;

/* Gives values of telegram 1 (values 0..3) or 2 (values 4..7); bit n of `valid`: value[n] is new. They are
 * released in `release_intervals` intervals in a row (1: exactly once), from interval `from_interval` on (0:
 * the next). Bad values are reported by the daemon as an event. CANSYNC_INVALID before
 * cansync_take_references(). CANSYNC_TAKE_UP: the daemon was started anew, or the mapping of the reference
 * values was changed; nothing is given until cansync_take_references() is called again, after a look at the
 * line. */
CANSYNC_C_API int cansync_give_references(cansync_client* client, uint8_t telegram, const int32_t value[4],
                                          uint8_t valid, uint32_t release_intervals,
                                          uint64_t from_interval) CANSYNC_C_NOEXCEPT;

/* Gives both telegrams up: their release ends at once, and the next values of a weaker writer are taken. */
CANSYNC_C_API int cansync_leave_references(cansync_client* client) CANSYNC_C_NOEXCEPT;

/* The next four wait until the telegram was on the bus, or the mode is in effect. A control word or broadcast
 * that is not sent within the daemon's default time (command_channel.command_timeout_ms) ends as
 * CANSYNC_TIMEOUT. */

/* Control word (0..65535) to one slave, 0..31. CANSYNC_REPLACED: a newer word of the slave, or a stop,
 * took its place. CANSYNC_NO_ANSWER: it was not seen on the bus; look at the slave's status before it is
 * sent again. */
CANSYNC_C_API int cansync_control_word(cansync_client* client, uint32_t slave,
                                       uint32_t word) CANSYNC_C_NOEXCEPT;

/* `priority` 0 (before everything else), 1 or 2; bit n of `slave_mask`: slave n; `action` 1 (control word in
 * `data_word`) or 128..255. */
CANSYNC_C_API int cansync_broadcast(cansync_client* client, uint32_t priority, uint32_t slave_mask,
                                    uint32_t action, uint32_t data_byte,
                                    uint32_t data_word) CANSYNC_C_NOEXCEPT;

/* Modes of the line, for cansync_set_mode(). SETUP sets up synchronous operation, RUN enables active
 * operation, STOP leaves synchronous operation, RESET_CAN leaves bus-off, RESTART starts the line anew up
 * to the configured state. The numbers stay. */
enum cansync_mode_command {
  CANSYNC_MODE_SETUP = 0,
  CANSYNC_MODE_RUN = 1,
  CANSYNC_MODE_STOP = 2,
  CANSYNC_MODE_RESET_CAN = 3,
  CANSYNC_MODE_RESTART = 4
};

/* `force`: CANSYNC_MODE_RUN also when slaves are missing. */
CANSYNC_C_API int cansync_set_mode(cansync_client* client, int mode, int force) CANSYNC_C_NOEXCEPT;

/* Lets a slave that was away and is held out be used again; `force`: without its check. */
CANSYNC_C_API int cansync_release_slave(cansync_client* client, uint32_t slave, int force) CANSYNC_C_NOEXCEPT;

/* ---- Parameters by name, in their unit ---- */

/* What a slave's drive profile says of a parameter: the value in its unit is number * factor + offset. */
typedef struct cansync_parameter_info {
  uint32_t number; /* 0..4095 */
  char name[65];   /* empty: there is no profile, or it does not have this number; the value is the raw one */
  char unit[17];
  char group[65];
  char text[201]; /* what it means */
  int doubleword; /* 1: 32 bits, 0: 16 bits */
  int is_signed;  /* the number is the raw value's two's complement */
  double factor;  /* not 0 */
  double offset;
  int access;      /* 0: read and write, 1: read only, 2: neither */
  int is_volatile; /* changes by itself */
  int limited;     /* 1: only the numbers minimum..maximum may be written */
  int64_t minimum; /* a raw number */
  int64_t maximum; /* a raw number, inclusive */
} cansync_parameter_info;

/* The parameter with this number (0..4095 decimal, or hexadecimal with 0x) or name. A name takes the profile
 * that the daemon names for the slave, in a profile folder of this computer; CANSYNC_INVALID: there is none,
 * or not this name. Waits at most 2 s for the slave's status. */
CANSYNC_C_API int cansync_find_parameter(cansync_client* client, uint32_t slave, const char* number_or_name,
                                         cansync_parameter_info* out) CANSYNC_C_NOEXCEPT;

/* The parameter at place `index` (0 and more) of the slave's profile, by rising number. CANSYNC_NO_DATA:
 * there are no more. CANSYNC_INVALID: there is no profile. */
CANSYNC_C_API int cansync_list_parameter(cansync_client* client, uint32_t slave, uint32_t index,
                                         cansync_parameter_info* out) CANSYNC_C_NOEXCEPT;

/* The value in its unit that a raw value stands for. `parameter` is not NULL. Any thread. */
CANSYNC_C_API double cansync_to_unit(const cansync_parameter_info* parameter,
                                     uint32_t raw) CANSYNC_C_NOEXCEPT;

/* The raw value nearest to `value`. CANSYNC_REFUSED: the profile does not allow to write it. */
CANSYNC_C_API int cansync_from_unit(cansync_client* client, const cansync_parameter_info* parameter,
                                    double value, uint32_t* raw) CANSYNC_C_NOEXCEPT;

/* ---- Requests that are on their way together ---- */

/* One request on its way. Its functions may be called from any thread; it may outlive its client. */
typedef struct cansync_job cansync_job;

/* A parameter request; ranges are checked by the daemon. */
typedef struct cansync_parameter_request {
  int write;           /* 0: read */
  uint32_t slave;      /* 0..31 */
  uint32_t number;     /* 0..4095 */
  uint32_t value;      /* write: raw */
  uint32_t sub_slave;  /* 0..65535; 0: the slave itself */
  uint32_t element;    /* 0..7; 7 is the value, the only one that may be written */
  int format;          /* 0: word, 1: doubleword, 2: as the slave says */
  uint32_t timeout_ms; /* monitoring time; 0: the daemon's default */
} cansync_parameter_request;

/* A transfer. */
typedef struct cansync_transfer_request {
  int download;        /* 0: upload, from the slave */
  uint32_t slave;      /* 0..31 */
  uint32_t address;    /* start address, 0x100 and more */
  uint32_t size;       /* bytes, 1..16777216 */
  const void* data;    /* download: `size` bytes, which are copied */
  uint32_t sub_slave;  /* 0..65535 */
  uint32_t block_size; /* bytes per initialise, 1..4092; 0: the slave's limit */
  uint32_t timeout_ms; /* monitoring time per block; 0: the daemon's default */
} cansync_transfer_request;

/* Kinds of commands, for cansync_submit_command(). */
enum cansync_command_kind {
  CANSYNC_COMMAND_CONTROL_WORD = 0,   /* slave, control_word, timeout_ms */
  CANSYNC_COMMAND_BROADCAST = 1,      /* priority, slave_mask, action, data_byte, data_word, timeout_ms */
  CANSYNC_COMMAND_MODE = 2,           /* mode, force: see cansync_set_mode() */
  CANSYNC_COMMAND_RELEASE = 3,        /* slave, force: see cansync_release_slave() */
  CANSYNC_COMMAND_POLLING = 4,        /* one, two, three: slaves asked by WRC1, WRC2, and the maximum slave */
  CANSYNC_COMMAND_CURSORS = 5,        /* one, two, three: slave of control words, parameters, transfers */
  CANSYNC_COMMAND_MAP_REFERENCES = 6, /* mapping */
  CANSYNC_COMMAND_MAP_ACTUALS = 7     /* slave, mapping */
};

/* A command; members that its kind does not name are not looked at. */
typedef struct cansync_command_request {
  int kind;
  uint32_t slave;        /* 0..31 */
  uint32_t control_word; /* 0..65535 */
  uint32_t priority;     /* 0, 1 or 2 */
  uint32_t slave_mask;   /* bit n: slave n */
  uint32_t action;       /* 1 or 128..255 */
  uint32_t data_byte;    /* 0..255 */
  uint32_t data_word;    /* 0..65535 */
  int mode;              /* cansync_mode_command */
  int force;             /* 0 or 1 */
  int32_t one;           /* slave 0..31, -128 automatic, -1 nobody, -2 unchanged; likewise the next two */
  int32_t two;           /* as `one` */
  int32_t three;         /* the maximum slave: 0..31 or -2 */
  uint8_t mapping[8];    /* register bytes: words 0..3 of telegram 1, then of telegram 2 */
  uint32_t timeout_ms;   /* control word, broadcast: in which it is sent; 0: the daemon's default */
} cansync_command_request;

/* How a request ended. Texts and data live as long as the job. */
typedef struct cansync_reply {
  int result;                  /* cansync_result */
  const char* reason;          /* with who said it, as cansync_last_error(); empty when done */
  uint16_t error_code;         /* the slave's; 0: none */
  uint32_t value;              /* parameter: raw */
  int doubleword;              /* parameter: 1: 32 bits, 0: 16 bits */
  uint32_t intervals;          /* from the first telegram to the last answer */
  uint32_t done;               /* transfer: bytes confirmed */
  uint32_t error_offset;       /* transfer: byte offset where it failed */
  uint32_t repeated_telegrams; /* transfer: sent again after silence or a refusal */
  uint32_t repeated_blocks;    /* transfer: begun anew after a failure */
  const void* data;            /* upload: what came */
  uint32_t size;               /* upload: its bytes */
  int cause;                   /* cansync_cause: with CANSYNC_REFUSED, and with nothing else */
} cansync_reply;

/* Hands a request over and gives its job without waiting for an answer; at most 64 may be open. What is wrong
 * with a request is its reply. Ends with cansync_job_free(). NULL: why tells cansync_last_error(). */
CANSYNC_C_API cansync_job* cansync_submit_parameter(
    cansync_client* client, const cansync_parameter_request* request) CANSYNC_C_NOEXCEPT;

/* Likewise, for a transfer. */
CANSYNC_C_API cansync_job* cansync_submit_transfer(
    cansync_client* client, const cansync_transfer_request* request) CANSYNC_C_NOEXCEPT;

/* Likewise, for a command. */
CANSYNC_C_API cansync_job* cansync_submit_command(cansync_client* client,
                                                  const cansync_command_request* request) CANSYNC_C_NOEXCEPT;

/* Waits at most `timeout_ms` for the end; 1: it has ended, 0: not yet. Every job ends
 * (docs/client-library.md). Not in a callback. */
CANSYNC_C_API int cansync_job_wait(cansync_job* job, uint32_t timeout_ms) CANSYNC_C_NOEXCEPT;

/* Bytes done and in total of a transfer, as the daemon told last. */
CANSYNC_C_API void cansync_job_progress(const cansync_job* job, uint32_t* done,
                                        uint32_t* total) CANSYNC_C_NOEXCEPT;

/* How it ended. CANSYNC_NO_DATA: not yet, and `out` is left as it is. */
CANSYNC_C_API int cansync_job_reply(cansync_job* job, cansync_reply* out) CANSYNC_C_NOEXCEPT;

/* Asks the daemon to cancel; the reply says whether it did. Takes at most 1 s. CANSYNC_FAILED: the daemon
 * could not be told. */
CANSYNC_C_API int cansync_job_cancel(cansync_job* job) CANSYNC_C_NOEXCEPT;

/* Forgets the job, not its request: that goes on. NULL is allowed. */
CANSYNC_C_API void cansync_job_free(cansync_job* job) CANSYNC_C_NOEXCEPT;

/* ---- Topics of the data model ---- */

/* What a daemon publishes. A sample is the struct of the data model of that name: cansync_MasterStatus for
 * CANSYNC_TOPIC_MASTER_STATUS and so on, as the generated headers <cansync/cansync.h>
 * and <cansync/gateway.h> declare it. The numbers stay. */
enum cansync_topic {
  CANSYNC_TOPIC_MASTER_STATUS = 0,  /* on every change and once a second */
  CANSYNC_TOPIC_SLAVE_STATUS = 1,   /* each slave on every change, at most every 100 ms */
  CANSYNC_TOPIC_ACTUAL_VALUES = 2,  /* each telegram of each slave */
  CANSYNC_TOPIC_EVENT = 3,          /* gateway_Event; the last 100 first */
  CANSYNC_TOPIC_TIMING = 4,         /* once a second */
  CANSYNC_TOPIC_INTERVAL = 5,       /* only when the daemon's configuration switches it on */
  CANSYNC_TOPIC_GATEWAY_STATUS = 6, /* gateway_GatewayStatus; on every change and once a second */
  CANSYNC_TOPIC_BUS_STATUS = 7,     /* gateway_BusStatus; likewise */
  CANSYNC_TOPIC_REALTIME_STATUS = 8 /* gateway_RealtimeStatus; likewise */
};

/* Copies the newest sample that is known into `out`; `size` is that of the struct. Of the status of master
 * and gateway, which is there since the connecting, of bus and realtime, for whose first sample it waits at
 * most 2 s, and of a slave's status and actual values, for whose first sample it waits at most `timeout_ms`;
 * `slave` is looked at for these. CANSYNC_NO_DATA; CANSYNC_INVALID: another topic, slave or size. */
CANSYNC_C_API int cansync_get_sample(cansync_client* client, int topic, uint32_t slave, uint32_t timeout_ms,
                                     void* out, size_t size) CANSYNC_C_NOEXCEPT;

/* Called on a thread of the library for each sample, which lives during the call: be short, call no function
 * that waits. */
typedef void (*cansync_on_sample)(void* user, const void* sample);

/* A topic that is followed. */
typedef struct cansync_subscription cansync_subscription;

/* Follows a topic: what is known comes first. As many as wanted; each ends with cansync_unsubscribe(). NULL:
 * why tells cansync_last_error(). */
CANSYNC_C_API cansync_subscription* cansync_subscribe(cansync_client* client, int topic,
                                                      cansync_on_sample callback,
                                                      void* user) CANSYNC_C_NOEXCEPT;

/* Ends it; waits for a callback that is running, so not from that callback. May come after cansync_free() of
 * the client. Any thread. NULL is allowed. */
CANSYNC_C_API void cansync_unsubscribe(cansync_subscription* subscription) CANSYNC_C_NOEXCEPT;

#ifdef __cplusplus
}
#endif

#endif
