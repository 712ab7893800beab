/* Preloaded into a program: kills it before one of its writes to files below a folder «fields», or to «fields.h5». */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void count(int file) {
  static long writes = 0;
  char link[64], path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length < 0) return;
  path[length] = 0;
  const char* number = getenv("KILL_BEFORE_WRITE");
  if (number && strstr(path, "/fields") && writes++ == atol(number)) raise(SIGKILL);
}

/* HDF5 writes with pwrite or pwrite64, and so do the ranks. */
#define COUNTED(name)                                                           \
  ssize_t name(int file, const void* bytes, size_t size, off_t offset) {        \
    ssize_t (*real)(int, const void*, size_t, off_t) = dlsym(RTLD_NEXT, #name); \
    count(file);                                                                \
    return real(file, bytes, size, offset);                                     \
  }
COUNTED(pwrite)
COUNTED(pwrite64)
