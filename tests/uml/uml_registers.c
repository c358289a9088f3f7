/* Lets a user-mode-linux of Debian 12 run on processors with AMX. Loaded into it with LD_PRELOAD.
 *
 * That kernel saves and sets the registers of its processes with ptrace() in a buffer of fixed size. Where
 * processors have registers that it does not know, the host refuses to set fewer bytes than there are
 * (EFAULT), and no process runs. Here what is missing is filled up with zeros: those registers stand as at a
 * process's start. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

enum { MOST = 16384 };

typedef long (*Ptrace)(enum __ptrace_request, pid_t, void*, void*);

static long set_all(Ptrace real, pid_t process, void* kind, const struct iovec* given) {
  static size_t whole;
  static char registers[MOST] __attribute__((aligned(64)));
  if (whole == 0) {
    struct iovec all = {registers, sizeof registers};
    if (real(PTRACE_GETREGSET, process, kind, &all) != 0) return -1;
    whole = all.iov_len;
    memset(registers, 0, sizeof registers);
  }
  if (given->iov_len >= whole) return real(PTRACE_SETREGSET, process, kind, (void*)given);
  memcpy(registers, given->iov_base, given->iov_len); /* behind it there are zeros */
  struct iovec all = {registers, whole};
  return real(PTRACE_SETREGSET, process, kind, &all);
}

long ptrace(enum __ptrace_request request, ...) {
  static Ptrace real;
  if (real == NULL) real = (Ptrace)dlsym(RTLD_NEXT, "ptrace");
  va_list rest;
  va_start(rest, request);
  const pid_t process = va_arg(rest, pid_t);
  void* const address = va_arg(rest, void*);
  void* const data = va_arg(rest, void*);
  va_end(rest);
  if (request == PTRACE_SETREGSET && (long)address == NT_X86_XSTATE)
    return set_all(real, process, address, data);
  return real(request, process, address, data);
}
