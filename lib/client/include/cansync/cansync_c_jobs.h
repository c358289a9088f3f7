#ifndef CANSYNC_C_JOBS_H
#define CANSYNC_C_JOBS_H

/* C face: requests that are on their way together. Included by <cansync/cansync_c.h>. */

#include <stdint.h>

#include "cansync_c_base.h"

#ifdef __cplusplus
extern "C" {
#endif

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

#ifdef __cplusplus
}
#endif

#endif
