// Limits the files that another file, such as a scene, may refer to: those in its own folder, and in folders that the
// user allows.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace latelight {

// Called with the path of a file before the file is read or found missing.
using FileObserver = std::function<void(const std::filesystem::path& file)>;

class AllowedFolders {
 public:
  // Allows the folder of the file `owner`, the folder of its target if it is a link, and the folders `allowed`. Throws
  // Error(Usage) if one of `allowed` is not a folder. `observer`, which may be null, is called by exists() and read().
  AllowedFolders(const std::filesystem::path& owner, std::span<const std::string> allowed, FileObserver observer = {});

  // Returns true if the owner's folder has a file or folder of this name, which read() may still reject.
  bool exists(const std::filesystem::path& name) const;

  // Returns the whole file that the owner refers to as `name`; a relative name starts from the owner's folder. After
  // all links are followed, the file must be in or below an allowed folder, and be a regular file that is not one of
  // the kernel's (/proc, /sys). Throws Error(BadInput) with a message that continues a subject: "is the file ..., which
  // ...".
  std::vector<std::byte> read(const std::filesystem::path& name) const;

 private:
  bool holds(const std::filesystem::path& real) const;
  void observe(const std::filesystem::path& file) const;
  FileObserver observer_;
  std::vector<std::filesystem::path> own_, allowed_;  // with links resolved
};

}  // namespace latelight
