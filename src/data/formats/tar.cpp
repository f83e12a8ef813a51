#include "data/formats/tar.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <fstream>
#include <numeric>

#include "base/error.h"

namespace latelight::data {

namespace {

constexpr size_t kBlock = 512;
constexpr uint64_t kMaxBytes = 077777777777;  // of a member, in 11 octal digits

struct TarHeader {
  char name[100], mode[8], owner[8], group[8], size[12], time[12], checksum[8], type, link[100], magic[6], version[2],
      ownerName[32], groupName[32], device[16], prefix[155], padding[12];
};
static_assert(sizeof(TarHeader) == kBlock);

constexpr char kFile = '0', kAttributes = 'x';

size_t paddedSize(uint64_t bytes) {
  return (bytes + kBlock - 1) / kBlock * kBlock;
}

template <size_t N>
void putOctal(char (&field)[N], uint64_t value) {
  const std::string digits = fmt::format("{:0{}o}", value, N - 1);
  std::memcpy(field, digits.data(), N - 1);
}

uint32_t checksumOf(TarHeader header) {
  std::memset(header.checksum, ' ', sizeof header.checksum);
  const auto* bytes = reinterpret_cast<const uint8_t*>(&header);
  return std::accumulate(bytes, bytes + kBlock, 0u);
}

void addBlocks(std::vector<std::byte>& archive, const std::string& name, char type,
               std::span<const std::byte> contents) {
  TarHeader header{};
  std::memcpy(header.name, name.data(), std::min(name.size(), sizeof header.name));
  putOctal(header.mode, 0644);
  putOctal(header.owner, 0);
  putOctal(header.group, 0);
  putOctal(header.size, contents.size());
  putOctal(header.time, 0);
  header.type = type;
  std::memcpy(header.magic, "ustar", sizeof header.magic);
  std::memcpy(header.version, "00", sizeof header.version);
  const std::string checksum = fmt::format("{:06o}", checksumOf(header));
  std::memcpy(header.checksum, checksum.c_str(), checksum.size() + 1);
  header.checksum[7] = ' ';
  const auto* bytes = reinterpret_cast<const std::byte*>(&header);
  archive.insert(archive.end(), bytes, bytes + kBlock);
  archive.insert(archive.end(), contents.begin(), contents.end());
  archive.resize(archive.size() + paddedSize(contents.size()) - contents.size());
}

// Returns the extended attribute "LENGTH path=NAME\n", whose length includes its own digits.
std::string pathRecord(const std::string& name) {
  const std::string text = fmt::format(" path={}\n", name);
  size_t length = text.size() + 1;
  while (fmt::formatted_size("{}", length) + text.size() != length) ++length;
  return fmt::format("{}{}", length, text);
}

std::string pathIn(const std::string& record) {
  const size_t begin = record.find(" path=");
  return begin == std::string::npos || record.empty() ? "" : record.substr(begin + 6, record.size() - begin - 7);
}

}  // namespace

void addTarMember(std::vector<std::byte>& archive, const std::string& name, std::span<const std::byte> contents) {
  if (contents.size() > kMaxBytes) badUsage("a file in a tar archive is limited to 8 GiB; use fewer pixels");
  const bool isAscii = std::ranges::all_of(name, [](char c) { return c >= ' ' && c <= '~'; });
  if (name.size() > sizeof(TarHeader::name) || !isAscii) {
    const std::string record = pathRecord(name);
    addBlocks(archive, "path", kAttributes, std::as_bytes(std::span(record)));
  }
  addBlocks(archive, name, kFile, contents);
}

std::map<std::string, TarRange> rangesOfTarKeys(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::map<std::string, TarRange> ranges;
  std::string longName;
  uint64_t at = 0, begin = 0;
  const auto invalid = [&] {
    badInput("'{}' is not an archive of this data set: remove it, and run the job with --resume", path.string());
  };
  for (TarHeader header;
       file.seekg(static_cast<std::streamoff>(at)) && file.read(reinterpret_cast<char*>(&header), kBlock);) {
    if (header.name[0] == 0) return ranges;
    uint64_t size = 0;
    const auto parsed = std::from_chars(header.size, header.size + 11, size, 8);
    if (parsed.ptr != header.size + 11 || std::memcmp(header.magic, "ustar", 6) != 0) invalid();
    const uint64_t next = at + kBlock + paddedSize(size);
    if (header.type == kAttributes) {
      if (size > kBlock * kBlock) invalid();
      std::string record(size, '\0');
      if (!file.read(record.data(), static_cast<std::streamsize>(size))) invalid();
      longName = pathIn(record);
    } else {
      const std::string name =
          longName.empty() ? std::string(header.name, strnlen(header.name, sizeof header.name)) : longName;
      const std::string key = name.substr(0, name.find('.', name.rfind('/') + 1));
      TarRange& range = ranges.try_emplace(key, TarRange{begin, 0}).first->second;
      range.bytes = next - range.offset;
      begin = next;
      longName.clear();
    }
    at = next;
  }
  invalid();
  return ranges;
}

}  // namespace latelight::data
