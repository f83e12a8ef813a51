// The files that another file may have read for it: those of its own folder, and of folders that the user allows.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace latelight {

class Enclosure {
 public:
  // Around the file `owner`: its folder, and where it is a link also the folder of the file that it leads to; and the
  // folders `allowed`. Throws Error(Usage) where one of those is no folder.
  Enclosure(const std::filesystem::path& owner, std::span<const std::string> allowed);

  // The whole file that the owner calls `name`, from its own folder if that is relative. It has to lie in or below one
  // of the folders once all links are followed, and be a regular file, and none of those by which the kernel speaks
  // (/proc, /sys). Throws Error(BadInput) with a sentence that goes on from a subject: "is the file ..., which ...".
  std::vector<std::byte> read(const std::filesystem::path& name) const;

 private:
  bool holds(const std::filesystem::path& real) const;
  std::vector<std::filesystem::path> own_, allowed_;  // without links
};

}  // namespace latelight
