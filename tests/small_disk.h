// A disk of a few blocks, for tests of a full disk. It requires the permission to mount.
#pragma once

#include <stdlib.h>
#include <sys/mount.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace latelight::test {

class SmallDisk {
 public:
  explicit SmallDisk(size_t bytes) {
    std::string name = (std::filesystem::temp_directory_path() / "latelight-disk-XXXXXX").string();
    path_ = mkdtemp(name.data());
    mounted_ = mount("tmpfs", path_.c_str(), "tmpfs", 0, ("size=" + std::to_string(bytes)).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount2(path_.c_str(), MNT_DETACH);
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  explicit operator bool() const { return mounted_; }
  const std::filesystem::path& path() const { return path_; }
  void fill() const {
    std::ofstream file(path_ / "filling", std::ios::binary);
    const std::string block(4096, 'x');
    while (file.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
  }

 private:
  std::filesystem::path path_;
  bool mounted_ = false;
};

}  // namespace latelight::test
