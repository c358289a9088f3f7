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

#include <stdint.h>

#include "cansync_c_base.h"
#include "cansync_c_jobs.h"
#include "cansync_c_parameters.h"
#include "cansync_c_topics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Asked every 20 ms, on the waiting thread, while cansync_connect(), cansync_take_references() or a function
 * that gives a state waits for the daemon; 0 ends the wait as if its time were over (CANSYNC_NO_DAEMON). It
 * may not call a function with the same handle. */
typedef int (*cansync_go_on)(void* user);

/* Where the daemon is looked for. Zero and NULL mean the default. */
typedef struct cansync_options {
  uint32_t domain;         /* DDS domain, 0..230 */
  const char* bus;         /* the bus's name; default "can0"; "" takes the only bus of the domain;
                              "plc2/can0": no daemon of another computer than plc2 is asked */
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
  uint16_t option_status;       /* w_OPTION_STATUS: 0x0080 run */
  uint16_t interface_status;    /* w_CANsync_STATUS */
  char state[64];               /* option_status in words */
  uint32_t bit_rate;            /* bit/s */
  uint64_t interval_ns;         /* length of an interval */
  uint64_t interval;            /* number of the running one */
  uint32_t slaves_configured;   /* bit n: slave n */
  uint32_t slaves_responding;   /* likewise: those that answer */
  uint32_t slaves_synchronized; /* likewise: those that are locked to SYNC */
} cansync_line_status;

/* What the daemon told last, at most about a second old; waits for nothing. CANSYNC_INVALID: `out` is NULL;
 * CANSYNC_NO_DAEMON: none is there (that it was killed, or its network is cut, is known after 5 s);
 * CANSYNC_NO_DATA: it was just started. */
CANSYNC_C_API int cansync_get_status(cansync_client* client, cansync_line_status* out) CANSYNC_C_NOEXCEPT;

/* Waits until the line is in run and every configured slave is synchronized, as the daemon tells that is there.
 * CANSYNC_TIMEOUT; CANSYNC_NO_DAEMON: when the time was over none was there. */
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

/* The newest actual values of a slave; waits at most `timeout_ms` for the first. CANSYNC_NO_DATA;
 * CANSYNC_NO_DAEMON: none is there. */
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

/* Like cansync_subscribe_actual_values, for events: the last 100 of each severity first, then each as it
 * happens. */
CANSYNC_C_API int cansync_subscribe_events(cansync_client* client, cansync_on_event callback,
                                           void* user) CANSYNC_C_NOEXCEPT;

/* In the place of a strength: one more than that of whoever has it now, so that this program takes over. */
#define CANSYNC_TAKE_OVER (-2147483647 - 1)

/* Makes the writer of reference values, with a strength of 0 and more or CANSYNC_TAKE_OVER. A telegram has one
 * writer at a time, which keeps it until it gives it up, is lost, or a stronger one comes. Waits at most 2 s for
 * the daemon. Again: with the new strength. */
CANSYNC_C_API int cansync_take_references(cansync_client* client, int32_t strength) CANSYNC_C_NOEXCEPT;

/* Gives values of telegram 1 (values 0..3) or 2 (values 4..7); bit n of `valid`: value[n] is new. They are
 * released in `release_intervals` intervals in a row (1: exactly once), from interval `from_interval` on (0:
 * the next). Bad values are reported by the daemon as an event. CANSYNC_INVALID before
 * cansync_take_references(). CANSYNC_TAKE_UP: the daemon was started anew, or the mapping of the reference
 * values was changed; nothing is given until cansync_take_references() is called again, after a look at the
 * line. CANSYNC_REFUSED: another writer has the telegram that is no weaker, and nothing was given; it is when
 * that one has gone. */
CANSYNC_C_API int cansync_give_references(cansync_client* client, uint8_t telegram, const int32_t value[4],
                                          uint8_t valid, uint32_t release_intervals,
                                          uint64_t from_interval) CANSYNC_C_NOEXCEPT;

/* Gives both telegrams up: their release ends at once, and the next values of another writer are taken. */
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

/* Modes of the line, for cansync_set_mode(). SETUP sets the line up, RUN lets it run, STOP stops it,
 * RESET_CAN leaves bus-off, RESTART starts the line anew up to the configured state. The numbers stay. */
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

#ifdef __cplusplus
}
#endif

#endif
