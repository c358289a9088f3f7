/* The C face against the fake daemon of c_face_test.cpp: DOMAIN BUS. Exit code 0: every check held. */
#include <cansync/cansync_c.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cansync.h"

static int failures = 0;

#define CHECK(condition)                                                              \
  do {                                                                                \
    if (!(condition)) {                                                               \
      printf("line %d: %s does not hold (%s)\n", __LINE__, #condition, last_error()); \
      failures++;                                                                     \
    }                                                                                 \
  } while (0)

static cansync_client* client = NULL;
static const char* last_error(void) {
  return cansync_last_error(client);
}

/* What callbacks tell, under one lock; that of pthread, since the thread sanitizer does not know mtx_lock. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static uint64_t last_event = 0;
static uint32_t last_value = 0;

static void on_event(void* user, const cansync_event* event) {
  pthread_mutex_lock(&lock);
  *(uint64_t*)user = event->number;
  pthread_cond_signal(&changed);
  pthread_mutex_unlock(&lock);
}

static void on_values(void* user, const cansync_actual_values* values) {
  pthread_mutex_lock(&lock);
  if (values->slave == 2) *(uint32_t*)user = values->raw[0];
  pthread_cond_signal(&changed);
  pthread_mutex_unlock(&lock);
}

static void wait_until(const uint64_t* event, const uint32_t* value) {
  pthread_mutex_lock(&lock);
  while (*event == 0 || *value == 0) pthread_cond_wait(&changed, &lock);
  pthread_mutex_unlock(&lock);
}

static int count_progress(void* user, uint32_t done, uint32_t total) {
  (void)done;
  *(uint32_t*)user = total;
  return 0;
}

static int stop_at_once(void* user, uint32_t done, uint32_t total) {
  (void)user;
  (void)done;
  (void)total;
  return 1;
}

static void check_wrong_use(void) {
  cansync_parameter parameter;
  CHECK(cansync_read(NULL, 0, 0, 0, &parameter) == CANSYNC_INVALID);
  CHECK(strcmp(cansync_last_error(NULL), "the handle is NULL") == 0);
  cansync_free(NULL);
  client = cansync_new();
  CHECK(client != NULL);
  CHECK(cansync_read(client, 0, 0, 0, &parameter) == CANSYNC_INVALID);
  CHECK(strstr(last_error(), "cansync_connect()") != NULL);
  CHECK(strcmp(cansync_result_name(CANSYNC_SLAVE_ERROR), "slave_error") == 0);
  CHECK(strcmp(cansync_result_name(CANSYNC_NO_DAEMON), "no_daemon") == 0);
  CHECK(strcmp(cansync_result_name(99), "unknown") == 0);
}

static void check_status(const char* bus) {
  cansync_line_status status;
  uint32_t slave = 99;
  (void)bus;
  CHECK(cansync_get_status(client, NULL) == CANSYNC_INVALID);
  CHECK(cansync_get_status(client, &status) == CANSYNC_DONE);
  CHECK(status.option_status == 0x0080 && status.slaves_configured == 0xF);
  CHECK(strcmp(status.state, "run") == 0);
  CHECK(cansync_wait_active(client, 1) == CANSYNC_TIMEOUT); /* the fake's slaves are never synchronized */
  CHECK(cansync_find_slave(client, "slave2", &slave) == CANSYNC_DONE && slave == 2);
  CHECK(cansync_find_slave(client, "nobody", &slave) == CANSYNC_INVALID);
}

static void check_parameters(void) {
  cansync_parameter parameter;
  CHECK(cansync_write(client, 1, 100, 0xCAFE1234, 0) == CANSYNC_DONE);
  CHECK(cansync_read(client, 1, 100, 0, &parameter) == CANSYNC_DONE);
  CHECK(parameter.value == 0xCAFE1234 && parameter.doubleword == 1 && parameter.error_code == 0);
  CHECK(strcmp(last_error(), "") == 0);
  CHECK(cansync_read(client, 1, 4001, 0, &parameter) == CANSYNC_SLAVE_ERROR);
  CHECK(parameter.error_code == 0xFFFE && strncmp(last_error(), "slave: ", 7) == 0);
  CHECK(cansync_read(client, 1, 4096, 0, &parameter) == CANSYNC_REFUSED);
  CHECK(strcmp(last_error(), "daemon: number 4096: out of range; allowed 0..4095") == 0);
  CHECK(cansync_last_cause(client) == CANSYNC_CAUSE_FIELD);
  CHECK(cansync_read(client, 1, 100, 0, &parameter) == CANSYNC_DONE);
  CHECK(cansync_last_cause(client) == CANSYNC_CAUSE_NONE);
}

/* The daemon of the test refuses parameter 3400 + n with cause n. */
static void check_causes(void) {
  cansync_parameter parameter;
  for (int cause = CANSYNC_CAUSE_UNKNOWN; cause <= CANSYNC_CAUSE_SHARED_LIMIT; cause++) {
    CHECK(cansync_read(client, 0, 3400 + (uint32_t)cause, 0, &parameter) == CANSYNC_REFUSED);
    CHECK(cansync_last_cause(client) == cause);
    CHECK(cansync_retry(CANSYNC_REFUSED, cause) != CANSYNC_RETRY_LOOK_FIRST);
    CHECK(strcmp(cansync_cause_name(cause), "none") != 0);
  }
  CHECK(cansync_read(client, 0, 3400, 0, &parameter) == CANSYNC_REFUSED); /* an old daemon */
  CHECK(cansync_last_cause(client) == CANSYNC_CAUSE_UNKNOWN);
  CHECK(strcmp(cansync_cause_name(CANSYNC_CAUSE_SLAVE_NOT_CONFIGURED), "slave_not_configured") == 0);
  CHECK(strcmp(cansync_cause_name(-1), "unknown") == 0 && strcmp(cansync_cause_name(99), "unknown") == 0);
  CHECK(cansync_last_cause(NULL) == CANSYNC_CAUSE_NONE);
  CHECK(cansync_retry(CANSYNC_REFUSED, CANSYNC_CAUSE_QUEUE_FULL) == CANSYNC_RETRY_SOON);
  CHECK(cansync_retry(CANSYNC_REFUSED, CANSYNC_CAUSE_READ_ONLY) == CANSYNC_RETRY_AFTER_CHANGE);
  CHECK(cansync_retry(CANSYNC_REFUSED, CANSYNC_CAUSE_SLAVE_LOST) == CANSYNC_RETRY_WHEN_STATE_OVER);
  CHECK(cansync_retry(CANSYNC_REFUSED, CANSYNC_CAUSE_FIELD) == CANSYNC_RETRY_NEVER);
  CHECK(cansync_retry(CANSYNC_NO_ANSWER, CANSYNC_CAUSE_NONE) == CANSYNC_RETRY_LOOK_FIRST);
  CHECK(cansync_retry(CANSYNC_NO_DAEMON, CANSYNC_CAUSE_NONE) == CANSYNC_RETRY_WHEN_STATE_OVER);
  CHECK(cansync_retry(CANSYNC_REPLACED, CANSYNC_CAUSE_NONE) == CANSYNC_RETRY_NEVER);
  CHECK(cansync_retry(CANSYNC_TAKE_UP, CANSYNC_CAUSE_NONE) == CANSYNC_RETRY_LOOK_FIRST);
  CHECK(cansync_retry(99, 99) == CANSYNC_RETRY_NEVER);
}

static void check_transfers(void) {
  uint8_t out[1000];
  uint8_t in[1000] = {0};
  uint32_t total = 0;
  uint32_t done = 0;
  for (size_t i = 0; i < sizeof out; i++) out[i] = (uint8_t)(i * 7);
  CHECK(cansync_download(client, 3, 0x100, out, sizeof out, count_progress, &total) == CANSYNC_DONE);
  CHECK(total == sizeof out);
  CHECK(cansync_upload(client, 3, 0x100, in, sizeof in, &done, NULL, NULL) == CANSYNC_DONE);
  CHECK(done == sizeof in && memcmp(in, out, sizeof in) == 0);
  CHECK(cansync_upload(client, 3, 0xDEAD00, in, sizeof in, &done, stop_at_once, NULL) == CANSYNC_CANCELLED);
  cansync_cancel_transfer(client); /* just before one begins */
  CHECK(cansync_upload(client, 3, 0xDEAD00, in, sizeof in, &done, NULL, NULL) == CANSYNC_CANCELLED);
  CHECK(cansync_upload(client, 3, 0x100, in, sizeof in, &done, NULL, NULL) ==
        CANSYNC_DONE); /* that one alone */
  CHECK(cansync_upload(client, 3, 0x100, NULL, 1, NULL, NULL, NULL) == CANSYNC_INVALID);
  CHECK(cansync_download(client, 3, 0x10, out, 4, NULL, NULL) == CANSYNC_REFUSED);
}

static void check_values(void) {
  const int32_t value[4] = {4711, 0, 0, 0};
  cansync_actual_values values;
  CHECK(cansync_get_actual_values(client, 2, 20000, &values) == CANSYNC_DONE && values.raw[0] == 0xABCD);
  CHECK(cansync_get_actual_values(client, 1, 1, &values) == CANSYNC_NO_DATA);
  CHECK(cansync_get_actual_values(client, 32, 1, &values) == CANSYNC_INVALID);
  CHECK(cansync_subscribe_events(client, on_event, &last_event) == CANSYNC_DONE);
  CHECK(cansync_subscribe_actual_values(client, on_values, &last_value) == CANSYNC_DONE);
  wait_until(&last_event, &last_value);
  CHECK(cansync_subscribe_events(client, NULL, NULL) == CANSYNC_DONE);
  CHECK(cansync_subscribe_actual_values(client, NULL, NULL) == CANSYNC_DONE);
  CHECK(last_event == 17 && last_value == 0xABCD);

  CHECK(cansync_give_references(client, 1, value, 1, 1, 0) == CANSYNC_INVALID);
  CHECK(cansync_take_references(client, -1) == CANSYNC_INVALID);
  CHECK(cansync_take_references(client, 5) == CANSYNC_DONE);
  CHECK(cansync_give_references(client, 1, value, 1, 1, 0) == CANSYNC_DONE);
}

static void check_commands(void) {
  CHECK(cansync_control_word(client, 2, 0x0F) == CANSYNC_DONE);
  CHECK(cansync_control_word(client, 9, 0x0F) == CANSYNC_REFUSED);
  CHECK(strstr(last_error(), "slave 9: not configured") != NULL);
  CHECK(cansync_last_cause(client) == CANSYNC_CAUSE_SLAVE_NOT_CONFIGURED);
  CHECK(cansync_broadcast(client, 0, 3, 200, 1, 2) == CANSYNC_DONE);
  CHECK(cansync_broadcast(client, 0, 3, 5, 1, 2) == CANSYNC_REFUSED);
  CHECK(cansync_last_cause(client) == CANSYNC_CAUSE_ACTION_RESERVED);
  CHECK(cansync_set_mode(client, CANSYNC_MODE_RUN, 1) == CANSYNC_DONE);
  CHECK(cansync_set_mode(client, 7, 0) == CANSYNC_INVALID);
  CHECK(cansync_release_slave(client, 1, 0) == CANSYNC_DONE);
}

static void check_names(void) {
  cansync_parameter_info info;
  uint32_t raw = 0;
  CHECK(cansync_find_parameter(client, 1, "0x10", &info) == CANSYNC_DONE);
  CHECK(info.number == 16 && info.name[0] == 0 && info.factor == 1.0 && info.doubleword == -1);
  CHECK(cansync_find_parameter(client, 1, "4096", &info) == CANSYNC_INVALID);
  CHECK(cansync_find_parameter(client, 1, "speed", &info) == CANSYNC_INVALID);
  CHECK(strstr(last_error(), "slave 1 has no profile") != NULL);
  CHECK(cansync_list_parameter(client, 1, 0, &info) == CANSYNC_INVALID);
  info.is_signed = 1;
  info.doubleword = 0;
  info.factor = 0.5;
  info.offset = 10.0;
  CHECK(cansync_to_unit(&info, 0xFFFE) == 9.0);
  CHECK(cansync_from_unit(client, &info, 9.0, &raw) == CANSYNC_DONE && raw == 0xFFFE);
  CHECK(cansync_from_unit(client, &info, 1e9, &raw) == CANSYNC_REFUSED);
  info.access = 1;
  CHECK(cansync_from_unit(client, &info, 9.0, &raw) == CANSYNC_REFUSED);
}

static cansync_reply ended(cansync_job* job) {
  cansync_reply reply = {.result = -1};
  while (cansync_job_wait(job, 1000) == 0) {
  }
  CHECK(cansync_job_reply(job, &reply) == CANSYNC_DONE);
  return reply;
}

static void check_jobs(void) {
  enum { MANY = 8 };
  cansync_job* jobs[MANY];
  cansync_reply reply = {.result = -1};
  cansync_parameter_request request = {.write = 1, .slave = 2, .element = 7, .format = 2};
  for (uint32_t i = 0; i < MANY; i++) {
    request.number = 200 + i;
    request.value = i;
    jobs[i] = cansync_submit_parameter(client, &request);
    CHECK(jobs[i] != NULL);
  }
  for (uint32_t i = 0; i < MANY; i++) {
    CHECK(ended(jobs[i]).result == CANSYNC_DONE);
    cansync_job_free(jobs[i]);
  }
  request.number = 4000; /* never answers */
  cansync_job* silent = cansync_submit_parameter(client, &request);
  CHECK(cansync_job_wait(silent, 1) == 0);
  CHECK(cansync_job_reply(silent, &reply) == CANSYNC_NO_DATA && reply.result == -1);
  CHECK(cansync_job_cancel(silent) == CANSYNC_DONE);
  CHECK(ended(silent).result == CANSYNC_CANCELLED);
  cansync_job_free(silent);
  request.slave = 9;
  cansync_job* refused = cansync_submit_parameter(client, &request);
  reply = ended(refused);
  CHECK(reply.result == CANSYNC_REFUSED && strncmp(reply.reason, "daemon: slave 9", 15) == 0);
  cansync_job_free(refused);
  request.format = 3;
  CHECK(cansync_submit_parameter(client, &request) == NULL && strstr(last_error(), "format") != NULL);
  CHECK(cansync_submit_parameter(NULL, &request) == NULL && cansync_submit_parameter(client, NULL) == NULL);
  cansync_job_free(NULL);
}

static void check_transfer_jobs(void) {
  const char text[] = "what is sent";
  uint32_t total = 0;
  cansync_transfer_request request = {
      .download = 1, .slave = 2, .address = 0x100, .size = sizeof text, .data = text};
  cansync_job* down = cansync_submit_transfer(client, &request);
  CHECK(ended(down).result == CANSYNC_DONE);
  cansync_job_progress(down, NULL, &total);
  CHECK(total == sizeof text);
  request.download = 0;
  cansync_job* up = cansync_submit_transfer(client, &request);
  const cansync_reply reply = ended(up);
  CHECK(reply.result == CANSYNC_DONE && reply.size == sizeof text &&
        memcmp(reply.data, text, sizeof text) == 0);
  cansync_job_free(up);
  cansync_job_free(down);
}

static void check_command_jobs(void) {
  cansync_command_request command = {.slave = 2, .control_word = 7, .one = 1, .two = -128, .three = -2};
  const int kinds[] = {CANSYNC_COMMAND_CONTROL_WORD, CANSYNC_COMMAND_POLLING, CANSYNC_COMMAND_CURSORS,
                       CANSYNC_COMMAND_MAP_REFERENCES};
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
    command.kind = kinds[i];
    cansync_job* job = cansync_submit_command(client, &command);
    CHECK(ended(job).result == CANSYNC_DONE);
    cansync_job_free(job);
  }
  command.kind = 8;
  CHECK(cansync_submit_command(client, &command) == NULL);
  command.kind = CANSYNC_COMMAND_MODE;
  command.mode = 5;
  CHECK(cansync_submit_command(client, &command) == NULL);
}

static void on_sample(void* user, const void* sample) {
  (void)sample;
  pthread_mutex_lock(&lock);
  *(uint64_t*)user += 1;
  pthread_cond_signal(&changed);
  pthread_mutex_unlock(&lock);
}

static void check_topics(void) {
  cansync_MasterStatus master;
  cansync_SlaveStatus slave;
  uint64_t count = 0;
  const uint32_t other = 1;
  CHECK(cansync_get_sample(client, CANSYNC_TOPIC_MASTER_STATUS, 0, 0, &master, sizeof master) ==
        CANSYNC_DONE);
  CHECK(master.slaves_configured == 0xF);
  CHECK(cansync_get_sample(client, CANSYNC_TOPIC_MASTER_STATUS, 0, 0, &master, 1) == CANSYNC_INVALID);
  CHECK(cansync_get_sample(client, CANSYNC_TOPIC_SLAVE_STATUS, 3, 20000, &slave, sizeof slave) ==
        CANSYNC_DONE);
  CHECK(strcmp(slave.name, "slave3") == 0);
  CHECK(cansync_get_sample(client, CANSYNC_TOPIC_SLAVE_STATUS, 9, 0, &slave, sizeof slave) ==
        CANSYNC_NO_DATA);
  CHECK(cansync_get_sample(client, CANSYNC_TOPIC_TIMING, 0, 0, &slave, sizeof slave) == CANSYNC_INVALID);
  cansync_subscription* subscription = cansync_subscribe(client, CANSYNC_TOPIC_EVENT, on_sample, &count);
  CHECK(subscription != NULL);
  wait_until(&count, &other);
  cansync_unsubscribe(subscription);
  cansync_unsubscribe(NULL);
  CHECK(cansync_subscribe(client, 99, on_sample, NULL) == NULL);
  CHECK(cansync_subscribe(client, CANSYNC_TOPIC_EVENT, NULL, NULL) == NULL);
}

static int stop_asking(void* user) {
  return ++*(int*)user < 3;
}

static void check_go_on(uint32_t domain) {
  int asked = 0;
  cansync_client* other = cansync_new();
  const cansync_options options = {
      .domain = domain, .bus = "nobody", .wait_ms = 600000, .go_on = stop_asking, .user = &asked};
  CHECK(cansync_connect(other, &options) == CANSYNC_NO_DAEMON && asked == 3);
  cansync_free(other);
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  check_wrong_use();
  const cansync_options options = {
      .domain = (uint32_t)atoi(argv[1]), .bus = argv[2], .client_name = "c face", .wait_ms = 20000};
  CHECK(cansync_connect(client, &options) == CANSYNC_DONE);
  if (failures != 0) return 1;
  CHECK(cansync_connect(client, &options) == CANSYNC_INVALID);
  CHECK(cansync_connect(NULL, &options) == CANSYNC_INVALID);
  check_status(argv[2]);
  check_parameters();
  check_causes();
  check_transfers();
  check_values();
  check_commands();
  check_names();
  check_jobs();
  check_transfer_jobs();
  check_command_jobs();
  check_topics();
  check_go_on(options.domain);
  cansync_free(client);
  return failures == 0 ? 0 : 1;
}
