#ifndef CANSYNC_C_SLAVE_H
#define CANSYNC_C_SLAVE_H

/* C face of a slave: the application behind a daemon with bus.protocol = "cansync-slave"
 * (docs/cansync-slave.md).
 *
 * Functions return results as those of <cansync/cansync_c.h>, and a handle is for one thread at a time. The
 * program calls cansync_application_receive() again and again, at least twice a second while it has taken
 * something over: that also tells the daemon that it is there. */

#include <stddef.h>
#include <stdint.h>

#include "cansync_c.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A connection to the daemon that is the slave. */
typedef struct cansync_application cansync_application;

/* What came. The numbers stay. */
enum cansync_slave_event_kind {
  CANSYNC_SLAVE_REFERENCES = 1, /* reference values of the master: values, arrived, ever, interval */
  CANSYNC_SLAVE_MONITORED = 2,  /* actual values of another slave: number, values, arrived, ever, interval */
  CANSYNC_SLAVE_CONTROL_WORD = 3, /* data_word */
  CANSYNC_SLAVE_SYNC_MODE =
      4,                    /* "SYNC mode", on which the slave acts by itself: number, data_byte, data_word */
  CANSYNC_SLAVE_ACTION = 5, /* any other action: number (command), data_byte, data_word */
  CANSYNC_SLAVE_PARAMETER = 6, /* to be answered: job, number, element, sub_slave, write, doubleword, value */
  CANSYNC_SLAVE_PARAMETER_END = 7, /* job; answered tells how */
  CANSYNC_SLAVE_BLOCK = 8,      /* to be allowed or refused: job, download, number (address), length, whole */
  CANSYNC_SLAVE_BLOCK_DATA = 9, /* the whole download, to be taken or refused: job, data */
  CANSYNC_SLAVE_BLOCK_STEP =
      10,                      /* one telegram of a block: job, offset, telegram_bytes, of a download data */
  CANSYNC_SLAVE_BLOCK_END = 11 /* job; answered tells whether it was moved to the end */
};

/* What came; members that the kind does not name are 0. */
typedef struct cansync_slave_event {
  int kind;                /* CANSYNC_SLAVE_... */
  int64_t time_ns;         /* CLOCK_REALTIME of the telegram's last bit */
  uint64_t interval;       /* in which it came */
  uint64_t job;            /* number that the answer names */
  uint32_t number;         /* parameter, start address, command, or number of a slave */
  uint32_t element;        /* of a parameter, 0..7; 7 is the value */
  uint32_t sub_slave;      /* 0: this slave */
  int write;               /* not 0: the master writes `value` */
  int doubleword;          /* not 0: format of a write */
  uint32_t value;          /* of a write, raw */
  int download;            /* not 0: to the slave */
  int whole;               /* not 0: the block goes as a whole, up to 300 bytes; else telegram by telegram */
  uint32_t length;         /* of a block in bytes; an upload may leave it to the slave: 0 */
  uint32_t offset;         /* of a telegram's first byte in the block */
  uint32_t telegram_bytes; /* of a telegram: 1..6 */
  int answered; /* not 0: the answer was on the bus, the block was moved; 0: dropped, cancelled, refused */
  uint32_t data_byte; /* of an action */
  uint32_t data_word; /* of an action */
  int32_t values[8];  /* raw, by the slave's mapping; of telegram 1 values 0..3, of telegram 2 4..7 */
  uint32_t words;     /* bit n: value n comes as its low word alone */
  uint32_t arrived;   /* bit 0, 1: telegram 1, 2 came with this */
  uint32_t ever;      /* bit 0, 1: it came at least once */
  uint8_t data[300];  /* of a download */
  uint32_t data_size; /* bytes of `data` */
} cansync_slave_event;

/* What the supervision has found. The numbers stay. */
enum cansync_slave_fault {
  CANSYNC_SLAVE_FAULT_NONE = 0,
  CANSYNC_SLAVE_FAULT_SYNC_LOST = 1,
  CANSYNC_SLAVE_FAULT_REFERENCES_MISSING = 2
};

/* State of the slave, as the daemon told last. */
typedef struct cansync_slave_state {
  uint32_t slave_number;        /* 0..31 */
  uint32_t option_status;       /* w_OPTION_STATUS: 0x0003 stop, 0x0013 setup, 0x0020 run */
  uint32_t cansync_status;      /* w_CANsync_STATUS */
  uint32_t status_word;         /* as the master reads it; bit 15: synchronized */
  int activated;                /* the master has activated SYNC operation */
  int synchronized;             /* activated, and the intervals follow SYNC */
  int fault;                    /* CANSYNC_SLAVE_FAULT_... */
  int reaction;                 /* what is to be done about it: 0 report, 1 quick stop, 2 pulse inhibit */
  uint64_t interval;            /* running interval */
  uint64_t interval_ns;         /* its length */
  uint64_t missing_edges;       /* intervals without their SYNC edge */
  uint64_t missing_references;  /* intervals without reference values */
  uint64_t actual_sent[2];      /* RDC1, RDC2 that were on the bus */
  uint64_t actual_late[2];      /* left out because they would have started after their slot */
  uint32_t status_parameter;    /* number of the status word, which the daemon answers */
  uint8_t reference_mapping[8]; /* register bytes of WRC1, WRC2 in force */
  uint8_t actual_mapping[8];    /* register bytes of RDC1, RDC2 in force */
  char application[129];        /* the program that has taken over; empty: none */
} cansync_slave_state;

/* A handle that is not connected yet; NULL when there is no memory. Ends with cansync_application_free(). */
CANSYNC_C_API cansync_application* cansync_application_new(void) CANSYNC_C_NOEXCEPT;
/* Gives back what was taken over and released, disconnects and frees. NULL is allowed. */
CANSYNC_C_API void cansync_application_free(cansync_application* application) CANSYNC_C_NOEXCEPT;
/* What went wrong in the last call, in words; empty when it was done. Lives until the next call. */
CANSYNC_C_API const char* cansync_application_last_error(const cansync_application* application)
    CANSYNC_C_NOEXCEPT;
/* Why the last call was refused: one of CANSYNC_CAUSE_.... */
CANSYNC_C_API int cansync_application_last_cause(const cansync_application* application) CANSYNC_C_NOEXCEPT;

/* Waits until a daemon serves the bus as a slave; once a handle. `options` NULL: the defaults. Of them
 * `profiles` means nothing here; `go_on` ends every wait of this handle. */
CANSYNC_C_API int cansync_application_connect(cansync_application* application,
                                              const cansync_options* options) CANSYNC_C_NOEXCEPT;

/* Copies the newest state, waiting at most 2 s for the first. */
CANSYNC_C_API int cansync_application_get_state(cansync_application* application,
                                                cansync_slave_state* out) CANSYNC_C_NOEXCEPT;

/* Waits at most `wait_ms` for what came, and gives the oldest that was not given yet. CANSYNC_NO_DATA:
 * nothing came; CANSYNC_NO_DAEMON: the daemon has gone (it may come back: call again). Of more than 1000 that
 * nobody takes the oldest are dropped; a job of which the program so never heard ends by its time in the
 * daemon. */
CANSYNC_C_API int cansync_application_receive(cansync_application* application, uint32_t wait_ms,
                                              cansync_slave_event* out) CANSYNC_C_NOEXCEPT;

/* Takes over `count` parameters of the slave, 0..4095, with `sub_slaves` not 0 those of sub-slaves too, and
 * with `blocks` not 0 uploads and downloads; instead of what was taken over before. Nothing of all: gives all
 * back. `strength` 0 and more: one program answers at a time, until it gives all back or a stronger one comes;
 * that of the first call counts. */
CANSYNC_C_API int cansync_application_take_over(cansync_application* application, const uint16_t* parameters,
                                                size_t count, int sub_slaves, int blocks,
                                                int32_t strength) CANSYNC_C_NOEXCEPT;

/* Answers of the application. One to what the master does not want any more is dropped; a job that never was
 * is CANSYNC_INVALID. This one: a write is done, or a read has this raw value in this format; a word is
 * -32768..65535, else CANSYNC_INVALID. */
CANSYNC_C_API int cansync_application_answer(cansync_application* application, uint64_t job, uint32_t value,
                                             int doubleword) CANSYNC_C_NOEXCEPT;
/* A parameter job fails with an error number, 1..65535 (M 3.2.3.7). */
CANSYNC_C_API int cansync_application_refuse(cansync_application* application, uint64_t job,
                                             uint16_t error) CANSYNC_C_NOEXCEPT;
/* CANSYNC_SLAVE_BLOCK: the block may be moved; a whole upload brings all its data, up to 300 bytes; another one
 * may fix its length (0: as asked). */
CANSYNC_C_API int cansync_application_allow_block(cansync_application* application, uint64_t job,
                                                  const uint8_t* data, size_t size,
                                                  uint16_t length) CANSYNC_C_NOEXCEPT;
/* CANSYNC_SLAVE_BLOCK_DATA: taken. */
CANSYNC_C_API int cansync_application_take_block(cansync_application* application,
                                                 uint64_t job) CANSYNC_C_NOEXCEPT;
/* CANSYNC_SLAVE_BLOCK_STEP: done; of an upload with as many bytes as were asked for. */
CANSYNC_C_API int cansync_application_step_block(cansync_application* application, uint64_t job,
                                                 const uint8_t* data, size_t size) CANSYNC_C_NOEXCEPT;
/* The block fails with an error number, 0x0100 and over. */
CANSYNC_C_API int cansync_application_refuse_block(cansync_application* application, uint64_t job,
                                                   uint16_t error) CANSYNC_C_NOEXCEPT;

/* Releases actual values of telegram 1 (values 0..3) or 2 (4..7) for one telegram, which waits
 * `wait_intervals` (1..1000) to be asked for. `valid`: bit n: raw[n] is new. CANSYNC_TAKE_UP: the daemon was
 * started anew since the first release; nothing was given until cansync_application_take_up() is called.
 * CANSYNC_NO_DAEMON: it has gone; CANSYNC_REFUSED: another program has the telegram and is no weaker, go on
 * until it has gone. */
CANSYNC_C_API int cansync_application_release(cansync_application* application, uint32_t telegram,
                                              const int32_t raw[4], uint32_t valid,
                                              uint32_t wait_intervals) CANSYNC_C_NOEXCEPT;
/* What is released from now on is meant for the daemon that is there now; `strength` as above. */
CANSYNC_C_API int cansync_application_take_up(cansync_application* application,
                                              int32_t strength) CANSYNC_C_NOEXCEPT;

/* Commands to the slave itself; each waits at most 3 s for its reply. CANSYNC_NO_DAEMON: there is none.
 * CANSYNC_MODE_... of <cansync/cansync_c.h>; from stop first setup, then run. */
CANSYNC_C_API int cansync_application_set_mode(cansync_application* application, int mode) CANSYNC_C_NOEXCEPT;
/* Register bytes of WRC1, WRC2 and of RDC1, RDC2; in force with the next interval at the latest. */
CANSYNC_C_API int cansync_application_set_mapping(cansync_application* application,
                                                  const uint8_t references[8],
                                                  const uint8_t actual_values[8]) CANSYNC_C_NOEXCEPT;
/* How the actual values of another slave, 0..31, are listened to; all 0: not any more. */
CANSYNC_C_API int cansync_application_listen(cansync_application* application, uint32_t other,
                                             const uint8_t actual_values[8]) CANSYNC_C_NOEXCEPT;

#ifdef __cplusplus
}
#endif

#endif
