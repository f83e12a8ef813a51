#include "base/memory.h"

#include <latelight/latelight.h>
#include <sys/resource.h>
#include <sys/sysinfo.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <limits>

#include "base/error.h"

namespace latelight {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kUnlimited = std::numeric_limits<uint64_t>::max();

std::atomic<uint64_t> chosenLimit = 0;
std::atomic<uint64_t> reserved = 0;

// The first number in a file; kUnlimited if it does not begin with one ("max").
uint64_t numberIn(const fs::path& path) {
  uint64_t value = 0;
  return std::ifstream(path) >> value ? value : kUnlimited;
}

// The memory available to new programs without swapping, in bytes; old kernels report only unused memory.
uint64_t freeOnMachine() {
  std::ifstream file("/proc/meminfo");
  std::string key;
  for (uint64_t kibibytes = 0; file >> key; file.ignore(std::numeric_limits<std::streamsize>::max(), '\n'))
    if (key == "MemAvailable:" && file >> kibibytes) return kibibytes << 10;
  struct sysinfo info {};
  return sysinfo(&info) == 0 ? uint64_t{info.freeram} * info.mem_unit : kUnlimited;
}

// The memory available within the control groups of this process, versions 2 and 1.
uint64_t freeInContainers() {
  uint64_t least = kUnlimited;
  const auto look = [&](const fs::path& folder, const char* limit, const char* usage) {
    const uint64_t most = numberIn(folder / limit), used = numberIn(folder / usage);
    if (most != kUnlimited && used != kUnlimited) least = std::min(least, most - std::min(most, used));
  };
  std::ifstream file("/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("0::/")) continue;
    const fs::path root = "/sys/fs/cgroup";
    for (fs::path group = line.substr(4); !group.empty(); group = group.parent_path())
      look(root / group, "memory.max", "memory.current");
    look(root, "memory.max", "memory.current");
  }
  look("/sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes");
  return least;
}

struct Limit {
  uint64_t bytes;
  bool ofAddresses;  // true if `ulimit -v` causes it
};

const Limit& defaultLimit() {
  static const Limit limit = [] {
    const uint64_t memory = std::min(freeOnMachine(), freeInContainers()), addresses = addressesLeft();
    return Limit{std::min(memory, addresses) / 4 * 3, addresses < memory};
  }();
  return limit;
}

// The limit, or less if `ulimit -v` leaves less in addition to current use. A driver crashes without address space for
// its compiler and threads, so some is reserved.
Limit limitFor(uint64_t before) {
  constexpr uint64_t kForDrivers = uint64_t{256} << 20;
  const uint64_t chosen = chosenLimit, left = addressesLeft();
  const Limit limit = chosen ? Limit{chosen, false} : defaultLimit();
  if (left == kUnlimited) return limit;
  const uint64_t available = before + left - std::min(left, kForDrivers);
  return available < limit.bytes ? Limit{available, true} : limit;
}

// Returns the size in MiB, rounded up, or that of small amounts in bytes.
std::string sizeText(uint64_t bytes) {
  if (bytes < 1 << 20) return fmt::format("{} bytes", bytes);
  return fmt::format("{} MiB", (bytes >> 20) + (bytes % (1 << 20) != 0));
}

}  // namespace

uint64_t addressesLeft() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnlimited;
  const uint64_t pages = numberIn("/proc/self/statm");
  const uint64_t used = pages == kUnlimited ? 0 : pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  return limit.rlim_cur - std::min<uint64_t>(limit.rlim_cur, used);
}

uint64_t memoryLimit() {
  const uint64_t chosen = chosenLimit;
  return chosen ? chosen : defaultLimit().bytes;
}

void setMemoryLimit(uint64_t bytes) {
  chosenLimit = bytes;
}

uint64_t claimedMemory() {
  return reserved.load();
}

void detail::takeMemory(uint64_t bytes, std::string_view what) {
  uint64_t before = reserved;
  const Limit limit = limitFor(before);
  do {
    if (bytes > limit.bytes || before > limit.bytes - bytes)
      fail(ExitCode::OutOfMemory,
           "there is no memory for {}: {} are needed, and {} of the {} that may be taken are in use; use something "
           "smaller, or raise the {}",
           what, sizeText(bytes), sizeText(before), sizeText(limit.bytes),
           limit.ofAddresses ? "limit on address space (ulimit -v)" : "memory limit (--memory on the command line)");
  } while (!reserved.compare_exchange_weak(before, before + bytes));
}

void detail::returnMemory(uint64_t bytes) {
  reserved -= bytes;
}

void MemoryClaim::grow(uint64_t bytes, std::string_view what) {
  detail::takeMemory(bytes, what);
  bytes_ += bytes;
}

void MemoryClaim::shrink(uint64_t bytes) {
  uint64_t before = bytes_, less = 0;
  do less = std::min(bytes, before);
  while (!bytes_.compare_exchange_weak(before, before - less));
  reserved -= less;
}

MemoryClaim::~MemoryClaim() {
  detail::returnMemory(bytes_);
}

MemoryClaim::MemoryClaim(MemoryClaim&& other) noexcept : bytes_(other.bytes_.exchange(0)) {}

MemoryClaim& MemoryClaim::operator=(MemoryClaim&& other) noexcept {
  bytes_ = other.bytes_.exchange(bytes_);
  return *this;
}

void failWithoutMemory(std::string_view what) {
  fail(ExitCode::OutOfMemory, "the machine has no memory left for {}; use less", what);
}

uint64_t parseMemory(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  std::string_view unit(end, static_cast<size_t>(text.data() + text.size() - end));
  constexpr std::string_view kLetters = "KMGT";
  const size_t power = unit.empty() ? std::string_view::npos : kLetters.find(static_cast<char>(unit[0] & ~0x20));
  const bool known =
      unit.empty() || unit == "B" ||
      (power != std::string_view::npos && (unit.size() == 1 || unit.substr(1) == "B" || unit.substr(1) == "iB"));
  if (error != std::errc() || !known) return 0;
  if (power != std::string_view::npos) value *= static_cast<double>(uint64_t{1} << (10 * (power + 1)));
  return value >= 1 && value < 0x1p63 ? static_cast<uint64_t>(value) : 0;
}

}  // namespace latelight
