// Files that appear whole or not at all, and the XDG folders.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace latelight {

// Whether a file or a folder of that name exists; false for names that none can have, as for one that is too long.
bool isThere(const std::filesystem::path& path);

// The whole file. Throws Error(BadInput) with a sentence that names the file if it can't be read.
std::vector<std::byte> readFile(const std::filesystem::path& path);
// The same for an open file; `path` is its name for the message.
std::vector<std::byte> readFile(int fd, const std::filesystem::path& path);

// Writes to a temporary file next to `path`, then renames it; a failure leaves no file and throws Error(Usage) with
// what to do. An existing file is replaced where its mode allows writing, and keeps its mode, group and owner. Links
// are followed: their target is replaced, and must exist. Pipes, which need a reader, and character devices are written
// to directly. "-" is standard output.
void writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes);

// A name from elsewhere as a part of a file's name, of at most kShortFileName bytes: a longer one is cut, and ends in
// its hash.
inline constexpr size_t kShortFileName = 100;
std::string shortFileName(std::string name);

// Throws as writeFile would, as far as can be known without the bytes: tries to create a file there.
void checkWritable(const std::filesystem::path& path);

// $XDG_CACHE_HOME/latelight (or ~/.cache/latelight), created if missing; nothing where that fails: a cache is never
// required.
std::optional<std::filesystem::path> cacheFolder();

// A cache entry by name, or nothing. Storing never throws and never leaves half a file.
std::optional<std::vector<std::byte>> loadCache(std::string_view name);
void storeCache(std::string_view name, std::span<const std::byte> bytes);

}  // namespace latelight
