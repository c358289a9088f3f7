/* A client with nothing but the data model and Cyclone DDS: shows actual values, reads one parameter.
 * Usage: actual_values DOMAIN BUS SLAVE NUMBER        Exit code: 0 done, 1 failed */
#include <dds/dds.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cansync.h" /* made by: idlc cansync.idl gateway.idl */
/* The daemon's default: this computer alone, without multicast. */
static const char* const configuration =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface "
    "name='lo'/></Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>120</MaxAutoParticipantIndex><SPDPInterval>1 "
    "s</SPDPInterval><Peers><Peer "
    "Address='127.0.0.1'/></Peers></Discovery></Domain></CycloneDDS>";

/* Waits for a sample whose first bytes, its key, are `key`; it stays lent to the end of the program. */
static const void* next(dds_entity_t reader, const uint8_t* key, size_t size) {
  for (int tries = 0; tries < 1000; dds_sleepfor(DDS_MSECS(10)), tries++) {
    void* sample[1] = {NULL};
    dds_sample_info_t info;
    while (dds_take(reader, sample, &info, 1, 1) == 1) {
      if (info.valid_data && memcmp(sample[0], key, size) == 0) return sample[0];
      dds_return_loan(reader, sample, 1);
    }
  }
  fprintf(stderr, "no answer within 10 s: is the daemon running in this domain and on this bus?\n");
  exit(1);
}

/* A request goes to the readers that are known when it is written. */
static void wait_for_daemon(dds_entity_t requests) {
  dds_publication_matched_status_t matched = {0};
  for (int tries = 0; tries < 1000; dds_sleepfor(DDS_MSECS(10)), tries++) {
    if (dds_get_publication_matched_status(requests, &matched) == 0 && matched.current_count > 0) return;
  }
}

int main(int argc, char** argv) {
  if (argc != 5) return fprintf(stderr, "usage: %s DOMAIN BUS SLAVE NUMBER\n", argv[0]), 1;
  const uint32_t domain = (uint32_t)atoi(argv[1]);
  const uint8_t slave = (uint8_t)atoi(argv[3]);
  if (dds_create_domain(domain, configuration) < 0) return fprintf(stderr, "no DDS domain %s\n", argv[1]), 1;
  const dds_entity_t participant = dds_create_participant(domain, NULL, NULL);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_partition1(qos, argv[2]);
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
#define TOPIC(type) dds_create_topic(participant, &cansync_##type##_desc, #type, NULL, NULL)
  const dds_entity_t requests = dds_create_writer(participant, TOPIC(ParameterRequest), qos, NULL);
  /* Replies to a client come to a partition of its own: the bus, a slash and its identity. */
  cansync_ParameterRequest request = {.request = 1, .slave = slave, .element = 7};
  dds_get_guid(participant, (dds_guid_t*)request.client); /* 16 bytes that nobody else has */
  char own[128];
  int length = snprintf(own, sizeof own - 32, "%s/", argv[2]);
  for (size_t i = 0; i < sizeof request.client; i++)
    length += sprintf(own + length, "%02x", request.client[i]);
  dds_qset_partition1(qos, own);
  const dds_entity_t replies = dds_create_reader(participant, TOPIC(ParameterReply), qos, NULL);
  dds_qset_partition1(qos, argv[2]);
  /* A reader of a transient local topic comes last: once it has data, the daemon knows the reader of replies
   * too. */
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
  const dds_entity_t status = dds_create_reader(
      participant, dds_create_topic(participant, &gateway_GatewayStatus_desc, "GatewayStatus", NULL, NULL),
      qos, NULL);
  const dds_entity_t values = dds_create_reader(participant, TOPIC(ActualValues), qos, NULL);
  dds_delete_qos(qos);
  const cansync_ActualValues* now = next(values, &slave, 1);
  for (int i = 0; i < 8; i++) printf("value %d: raw 0x%08" PRIX32 ", %g\n", i, now->raw[i], now->scaled[i]);
  request.number = (uint32_t)atoi(argv[4]);
  request.format = cansync_FORMAT_AS_SLAVE_SAYS;
  const gateway_GatewayStatus* daemon = next(status, request.client, 0);
  memcpy(request.daemon, daemon->daemon, sizeof request.daemon); /* no other start of a daemon takes it */
  wait_for_daemon(requests);
  if (dds_write(requests, &request) < 0) return fprintf(stderr, "the request was not written\n"), 1;
  const cansync_ParameterReply* reply = next(replies, request.client, sizeof request.client);
  if (reply->code == gateway_REPLY_DONE)
    return printf("parameter %s: %" PRIu32 "\n", argv[4], reply->value), 0;
  return fprintf(stderr, "parameter %s: %s\n", argv[4], reply->reason), 1;
}
