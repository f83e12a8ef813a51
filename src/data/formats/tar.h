// Tar archives in the POSIX interchange format (IEEE Std 1003.1, pax).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace latelight::data {

// The two empty blocks that end an archive.
inline constexpr size_t kTarEndBytes = 1024;

// Appends a regular file with mode 0644, owner 0 and time 0. The archive lacks its end.
void addTarMember(std::vector<std::byte>& archive, const std::string& name, std::span<const std::byte> contents);

// A range of an archive's bytes.
struct TarRange {
  uint64_t offset = 0, bytes = 0;
};

// Returns the range of the consecutive members of each key: the part of a member's name before the first period after
// the last slash. Throws Error(BadInput) that names the file if it is not an archive that addTarMember() wrote.
std::map<std::string, TarRange> rangesOfTarKeys(const std::filesystem::path& path);

}  // namespace latelight::data
