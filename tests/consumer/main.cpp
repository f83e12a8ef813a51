// Uses the installed library as a stranger would; the version it was built for is the first argument.
#include <latelight/latelight.h>

#include <cstdio>
#include <cstring>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::printf("latelight %s\n", latelight::version());
  return std::strcmp(latelight::version(), argv[1]) == 0 ? 0 : 1;
}
