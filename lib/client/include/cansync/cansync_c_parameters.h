#ifndef CANSYNC_C_PARAMETERS_H
#define CANSYNC_C_PARAMETERS_H

/* C face: parameters by name, in their unit. Included by <cansync/cansync_c.h>. */

#include <stdint.h>

#include "cansync_c_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a slave's drive profile says of a parameter: the value in its unit is number * factor + offset. */
typedef struct cansync_parameter_info {
  uint32_t number; /* 0..4095 */
  char name[65];   /* empty: there is no profile, or it does not have this number; the value is the raw one */
  char unit[17];
  char group[65];
  char text[201]; /* what it means */
  int doubleword; /* 1: 32 bits, 0: 16 bits; -1: there is no profile that says, ask for it with format 2 */
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

/* The value in its unit that a raw value stands for, of the format that `parameter` says: ask for it with that format
 * (`doubleword` of cansync_parameter_info), then a drive that has another one answers CANSYNC_WORD_EXPECTED or
 * CANSYNC_DOUBLEWORD_EXPECTED. Not a number: a word cannot have this raw value. `parameter` is not NULL. Any thread. */
CANSYNC_C_API double cansync_to_unit(const cansync_parameter_info* parameter,
                                     uint32_t raw) CANSYNC_C_NOEXCEPT;

/* The raw value nearest to `value`. CANSYNC_REFUSED: the profile does not allow to write it. */
CANSYNC_C_API int cansync_from_unit(cansync_client* client, const cansync_parameter_info* parameter,
                                    double value, uint32_t* raw) CANSYNC_C_NOEXCEPT;

#ifdef __cplusplus
}
#endif

#endif
