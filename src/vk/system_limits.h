// Limits of the system on this process under which Vulkan drivers abort, crash or wait forever. They are checked before
// a driver is loaded or a device is created, because the drivers do not report them.
#pragma once

#include <optional>
#include <string>

#include "base/error.h"

namespace latelight::vk {

struct SystemLimit {
  ExitCode code;
  std::string sentence;  // without its period
  std::string remedy;    // in lower case, without a period, to follow a colon
};

// Returns the limit on address space or open files that does not permit loading a driver.
std::optional<SystemLimit> limitOnDrivers();

// Returns the limit on processes that does not permit the threads of a CPU device. Mesa waits forever for threads that
// it could not start.
std::optional<SystemLimit> limitOnCpuThreads();

}  // namespace latelight::vk
