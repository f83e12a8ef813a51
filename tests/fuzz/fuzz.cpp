#include "fuzz/fuzz.h"

#include <fcntl.h>
#include <latelight/latelight.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "base/log.h"

namespace latelight::fuzz {

namespace {

constexpr uint64_t kMemory = uint64_t{768} << 20;

std::filesystem::path makeFolder() {
  std::string name = (std::filesystem::is_directory("/dev/shm") ? "/dev/shm" : "/tmp") + std::string("/fuzz_XXXXXX");
  if (!mkdtemp(name.data())) report("no folder could be created");
  std::atexit([] {
    std::error_code ignored;
    std::filesystem::remove_all(folder(), ignored);
  });
  return name;
}

}  // namespace

void start() {
  static const bool started = [] {
    setenv("LATELIGHT_THREADS", "1", 1);
    setenv("XDG_CACHE_HOME", folder().c_str(), 1);
    setQuiet(true);
    setMemoryLimit(kMemory);
    return true;
  }();
  static_cast<void>(started);
}

const std::filesystem::path& folder() {
  static const auto& made = *new std::filesystem::path(makeFolder());  // outlives the handler at exit
  return made;
}

std::filesystem::path writeInput(const char* name, std::span<const std::byte> bytes) {
  const std::filesystem::path path = folder() / name;
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0 || write(fd, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
    report("no file was written");
  close(fd);
  return path;
}

void report(std::string_view what) {
  std::fprintf(stderr, "not a proper answer: %.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

}  // namespace latelight::fuzz
