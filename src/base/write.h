// Writes to open files, and the sentence for a failed write.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace latelight {

// Writes all bytes. Returns 0 or an errno.
int writeAll(int fd, std::span<const std::byte> bytes);

// Throws Error(Usage) that names the file, the reason and what to do. `error` is an errno.
[[noreturn]] void failToWrite(const std::filesystem::path& path, int error);

}  // namespace latelight
