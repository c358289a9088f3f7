#ifndef CANSYNC_C_TOPICS_H
#define CANSYNC_C_TOPICS_H

/* C face: the topics of the data model. Included by <cansync/cansync_c.h>. */

#include <stddef.h>
#include <stdint.h>

#include "cansync_c_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a daemon publishes. A sample is the struct of the data model of that name: cansync_MasterStatus for
 * CANSYNC_TOPIC_MASTER_STATUS and so on, as the generated headers <cansync/cansync.h>
 * and <cansync/gateway.h> declare it. The numbers stay. */
enum cansync_topic {
  CANSYNC_TOPIC_MASTER_STATUS = 0,  /* on every change and once a second */
  CANSYNC_TOPIC_SLAVE_STATUS = 1,   /* each slave on every change, at most every 100 ms */
  CANSYNC_TOPIC_ACTUAL_VALUES = 2,  /* each telegram of each slave */
  CANSYNC_TOPIC_EVENT = 3,          /* gateway_Event; the last 100 of each severity first */
  CANSYNC_TOPIC_TIMING = 4,         /* once a second */
  CANSYNC_TOPIC_INTERVAL = 5,       /* only when the daemon's configuration switches it on */
  CANSYNC_TOPIC_GATEWAY_STATUS = 6, /* gateway_GatewayStatus; on every change and once a second */
  CANSYNC_TOPIC_BUS_STATUS = 7,     /* gateway_BusStatus; likewise */
  CANSYNC_TOPIC_REALTIME_STATUS = 8 /* gateway_RealtimeStatus; likewise */
};

/* Copies what the daemon told last into `out`; `size` is that of the struct. Of the status of master, gateway, bus and
 * realtime, and of a slave's status and actual values, for which `slave` is looked at. Waits at most `timeout_ms` for
 * the first. CANSYNC_NO_DATA: none came; CANSYNC_NO_DAEMON: none is there; CANSYNC_INVALID: another topic, slave or
 * size. */
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
