// What Debian 12's libstdc++.a uses of C libraries newer than 2.31. These definitions are hidden: they are part of the
// program or library that they are linked to, and are not exported.
#include <stdint.h>
#include <stdlib.h>
#include <sys/random.h>

#pragma GCC visibility push(hidden)

// glibc 2.32: whether the process has only one thread, in which case reference counts need no atomic operations. Zero is
// always correct.
char __libc_single_threaded = 0;

// glibc 2.36: a random number.
uint32_t arc4random(void) {
  uint32_t number;
  if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number) abort();
  return number;
}
