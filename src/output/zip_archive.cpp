#include "output/zip_archive.h"

#include <zlib.h>

#include "base/error.h"

namespace latelight::output {

namespace {

constexpr uint64_t kMax = 0xffffffff;
constexpr uint64_t kVersion = 20;
constexpr uint64_t kFirstDay = 1 << 5 | 1;  // January 1, 1980, the first day of ZIP's calendar

void put(std::vector<std::byte>& out, uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<std::byte>(i < 8 ? value >> 8 * i : 0));
}

void putText(std::vector<std::byte>& out, const std::string& text) {
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
}

// Writes the fields that a file's header and its directory entry share.
void describe(std::vector<std::byte>& out, const std::string& name, uint32_t crc, uint64_t size) {
  put(out, kVersion, 2);  // version needed to extract
  put(out, 0, 4);         // flags, no compression
  put(out, kFirstDay << 16, 4);
  put(out, crc, 4);
  put(out, size, 4);
  put(out, size, 4);
  put(out, name.size(), 2);
  put(out, 0, 2);  // extra field
}

}  // namespace

void ZipArchive::add(const std::string& name, const std::vector<std::byte>& contents) {
  const size_t offset = bytes_.size();
  const auto crc = static_cast<uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(contents.data()), contents.size()));
  put(bytes_, 0x04034b50, 4);
  describe(bytes_, name, crc, contents.size());
  putText(bytes_, name);
  bytes_.insert(bytes_.end(), contents.begin(), contents.end());

  put(directory_, 0x02014b50, 4);
  put(directory_, kVersion, 2);  // version of the writer
  describe(directory_, name, crc, contents.size());
  put(directory_, 0, 10);  // comment, disk, attributes
  put(directory_, offset, 4);
  putText(directory_, name);
  ++files_;
}

std::vector<std::byte> ZipArchive::finish() {
  const size_t begin = bytes_.size();
  if (begin + directory_.size() > kMax) badUsage("an NPZ file is limited to 4 GiB; use fewer outputs or pixels");
  bytes_.insert(bytes_.end(), directory_.begin(), directory_.end());
  put(bytes_, 0x06054b50, 4);
  put(bytes_, 0, 4);  // disks
  put(bytes_, files_, 2);
  put(bytes_, files_, 2);
  put(bytes_, directory_.size(), 4);
  put(bytes_, begin, 4);
  put(bytes_, 0, 2);  // comment
  return std::move(bytes_);
}

}  // namespace latelight::output
