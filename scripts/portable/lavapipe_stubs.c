// What LLVM's static libraries of Debian 12 use of a newer C library than 2.31 and of ncurses. LLVM asks for them only to
// print its use of memory and to color a terminal, which the driver does not do.
#include <stddef.h>

#pragma GCC visibility push(hidden)

struct mallinfo2 {  // glibc 2.33
  size_t counts[10];
};

struct mallinfo2 mallinfo2(void) {
  return (struct mallinfo2){{0}};
}

// terminfo: there is no terminal.
int setupterm(const char* name, int file, int* error) {
  (void)name, (void)file;
  if (error) *error = 0;
  return -1;
}
void* set_curterm(void* terminal) {
  (void)terminal;
  return NULL;
}
int del_curterm(void* terminal) {
  (void)terminal;
  return -1;
}
int tigetnum(const char* name) {
  (void)name;
  return -1;
}
