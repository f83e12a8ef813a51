// A ZIP archive of uncompressed files (PKWARE's APPNOTE, 4.3), as numpy.savez writes it. No archive library is used,
// because its ciphers and compressors would be loaded at every start of the program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace latelight::output {

// Equal files produce equal bytes.
class ZipArchive {
 public:
  void add(const std::string& name, const std::vector<std::byte>& contents);
  // Returns the archive. Throws Error(Usage) if it has 4 GiB or more.
  std::vector<std::byte> finish();

 private:
  std::vector<std::byte> bytes_, directory_;
  size_t files_ = 0;
};

}  // namespace latelight::output
