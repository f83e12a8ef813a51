// The files that another file may refer to: those in its own folder, and in folders that the user allows.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace latelight {

class Enclosure {
 public:
  // For the file `owner`: its folder, and if it is a link also its target's folder; and the folders `allowed`. Throws
  // Error(Usage) if one of those is not a folder.
  Enclosure(const std::filesystem::path& owner, std::span<const std::string> allowed);

  // The whole file that the owner calls `name`, from its own folder if that is relative. After all links are followed,
  // it must be in or below one of the folders, and be a regular file, not one of the kernel's (/proc, /sys). Throws
  // Error(BadInput) with a message that continues a subject: "is the file ..., which ...".
  std::vector<std::byte> read(const std::filesystem::path& name) const;

 private:
  bool holds(const std::filesystem::path& real) const;
  std::vector<std::filesystem::path> own_, allowed_;  // without links
};

}  // namespace latelight
