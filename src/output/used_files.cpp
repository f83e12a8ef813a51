#include "output/used_files.h"

#include <sys/stat.h>

#include <optional>
#include <system_error>

#include "base/error.h"

namespace latelight::output {
namespace fs = std::filesystem;
namespace {

// Follows links. Returns nothing if no file exists.
std::optional<struct stat> find(const fs::path& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return std::nullopt;
  return status;
}

}  // namespace

UsedFiles::UsedFiles(std::span<const fs::path> inputs) {
  for (const fs::path& path : inputs) {
    entries_.insert(entryOf(path));
    if (const auto status = find(path)) inodes_.insert({status->st_dev, status->st_ino});
  }
}

// Returns an identity of the directory entry that writing replaces. A file may have several entries; the others remain.
std::string UsedFiles::entryOf(const fs::path& path) {
  std::error_code error;
  fs::path followed = fs::is_symlink(path, error) ? fs::canonical(path, error) : path;
  if (error) followed = path;
  const fs::path folder = followed.has_parent_path() ? followed.parent_path() : ".";
  std::string& known = folders_[folder.string()];
  if (known.empty()) {
    const auto status = find(folder);
    known = status ? fmt::format("{}:{}", status->st_dev, status->st_ino)
                   : fs::weakly_canonical(fs::absolute(folder, error), error).string();
  }
  return known + "/" + followed.filename().string();
}

void UsedFiles::checkOutputs(std::span<const fs::path> outputs) {
  std::map<std::string, const fs::path*> written;
  for (const fs::path& path : outputs) {
    const auto status = find(path);
    if (path.empty() || path == "-" || (status && S_ISCHR(status->st_mode))) continue;
    const std::string entry = entryOf(path);
    if (entries_.contains(entry) || (status && inodes_.contains({status->st_dev, status->st_ino})))
      badUsage("can't write '{}': this command reads it; choose another name", path.string());
    const auto [other, isNew] = written.insert({entry, &path});
    if (!isNew && *other->second == path)
      badUsage("two outputs are called '{}'; choose another name for one of them", path.string());
    if (!isNew)
      badUsage("the outputs '{}' and '{}' are the same file; choose another name for one of them",
               other->second->string(), path.string());
  }
}

}  // namespace latelight::output
