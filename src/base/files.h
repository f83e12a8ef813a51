// Reads and writes files, which appear whole or not at all, and the cache in the XDG cache folder.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace latelight {

// True if a file or folder of that name exists; false for names that no file can have, such as one that is too long.
bool isThere(const std::filesystem::path& path);

// Returns the whole file. Throws Error(BadInput) with a sentence that names the file if it cannot be read.
std::vector<std::byte> readFile(const std::filesystem::path& path);
// Reads an open file; `path` is its name for the message.
std::vector<std::byte> readFile(int fd, const std::filesystem::path& path);

// The contents of a file, in memory that was not cleared before, so that all threads can be the first to write to it.
class FileBytes {
 public:
  FileBytes(std::unique_ptr<std::byte[]> bytes, size_t size) : bytes_(std::move(bytes)), size_(size) {}
  const std::byte* data() const { return bytes_.get(); }
  size_t size() const { return size_; }
  operator std::span<const std::byte>() const { return {data(), size_}; }  // NOLINT(google-explicit-constructor)

 private:
  std::unique_ptr<std::byte[]> bytes_;
  size_t size_;
};
// Like readFile(), on all threads, for files of up to gigabytes.
FileBytes readLargeFile(const std::filesystem::path& path);

// Writes to a temporary file next to `path`, then renames it. A failure leaves no file behind and throws Error(Usage)
// with advice. An existing file is replaced if its mode allows writing, and keeps its mode, group and owner. Links are
// followed: their target, which must exist, is replaced. Pipes, which require a reader, and character devices are
// written to directly. "-" is standard output.
void writeFile(const std::filesystem::path& path, std::span<const std::byte> bytes);

// Files that replace existing ones together, such as a model, its materials and their images. A full disk then changes
// none of them. Call it like writeFile(); pipes, devices and "-" are written to at once.
class FileGroup {
 public:
  FileGroup();
  ~FileGroup();  // removes the files that were not committed
  FileGroup(const FileGroup&) = delete;
  FileGroup& operator=(const FileGroup&) = delete;

  // Writes a file under a temporary name. Throws the errors of writeFile(). A pending file needs a descriptor, so the
  // first files of a group of more than kMaxPending are renamed before commit().
  void add(const std::filesystem::path& path, std::span<const std::byte> bytes);
  // Renames the files, in the order of add().
  void commit();

 private:
  static constexpr size_t kMaxPending = 256;  // of the 1024 files that a process may usually open
  struct Pending;
  void renameFirst();

  std::deque<std::unique_ptr<Pending>> pending_;
};

// Shortens an external name for use as part of a file name, to at most kShortFileName bytes. A longer name is cut and
// ends in its hash.
inline constexpr size_t kShortFileName = 100;
std::string shortFileName(std::string name);

// Throws the errors that writeFile would, as far as they can be detected without the bytes: it tries to create a file
// there.
void checkWritable(const std::filesystem::path& path);

// $XDG_CACHE_HOME/latelight (or ~/.cache/latelight), created if missing. Empty if that fails or LATELIGHT_NO_CACHE is
// set, since a cache is never required.
std::optional<std::filesystem::path> cacheFolder();

// Loads a cache entry by name, or returns nothing. Storing an entry never throws and never leaves a partial file.
std::optional<std::vector<std::byte>> loadCache(std::string_view name);
void storeCache(std::string_view name, std::span<const std::byte> bytes);

}  // namespace latelight
