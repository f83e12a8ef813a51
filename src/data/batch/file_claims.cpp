#include "data/batch/file_claims.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

#include "base/error.h"

namespace latelight::data {

namespace {

// The format of the data set's own records.
constexpr size_t kOwnRecords = std::numeric_limits<size_t>::max();

constexpr uint64_t kDescribed = uint64_t{1} << 63;  // set in numbers of contents with a description
constexpr uint64_t kClaimBytes = 128;               // of an element of a map, without its name

// Returns a path without empty parts and dots, which few paths have.
std::string normalized(const std::string& path) {
  if (path.find("//") == std::string::npos && path.find("./") == std::string::npos) return path;
  return std::filesystem::path(path).lexically_normal().generic_string();
}

}  // namespace

FileClaims::FileClaims(const Job& job, std::function<std::string(uint64_t)> frameName)
    : job_(job), frameName_(std::move(frameName)) {
  for (const JobFormat& use : job.formats) {
    const auto isSame = [&](const JobFormat& other) { return other.name == use.name && other.options == use.options; };
    const auto first = std::ranges::find_if(job.formats, isSame);  // at the latest, `use` itself
    sameFormat_.push_back(static_cast<size_t>(first - job.formats.begin()));
  }
  files_["manifest.json"] = folders_[".latelight/"] = {.format = kOwnRecords, .contents = kOwnRecords, .ofSet = true};
}

void FileClaims::add(const DataFrame& frame) {
  for (size_t i = 0; i < job_.formats.size(); ++i) {
    const std::vector<FormatFile> files = job_.formats[i].format->files(frame);
    for (size_t number = 0; number < files.size(); ++number)
      add(files[number], {i, contentsOf(i, number, files[number]), frame.index, files[number].ofSet});
  }
  for (size_t i = 0; i < job_.formats.size(); ++i)
    for (const std::string& file : job_.formats[i].format->filesOfOthers(frame)) checkIsWritten(file, i);
  memory_.grow(std::exchange(bytes_, 0), "the names of the job's files");
}

void FileClaims::checkIsWritten(const std::string& file, size_t reader) const {
  const std::string name = normalized(file);
  if (files_.contains(name)) return;
  for (size_t slash = name.find('/'); slash != std::string::npos; slash = name.find('/', slash + 1))
    if (folders_.contains(std::string_view(name).substr(0, slash + 1))) return;
  badUsage(
      "formats: {} (formats[{}]) reads '{}', which no format of the job writes: remove \"write-pictures\": false, or "
      "add a format that writes these images and give their names with \"picture\"",
      job_.formats[reader].name, reader, name);
}

void FileClaims::add(const FormatFile& file, const Claim& claim) {
  const std::string name = normalized(file.name);
  const bool isFolder = name.ends_with('/');
  Claims& claims = isFolder ? folders_ : files_;
  compare(name, claim, claims, name);
  insert(claims, name, claim);
  if (isFolder) return compare(name, claim, parents_, name);
  for (size_t slash = name.find('/'); slash != std::string::npos; slash = name.find('/', slash + 1)) {
    const std::string_view folder = std::string_view(name).substr(0, slash + 1);
    compare(name, claim, folders_, folder);
    insert(parents_, folder, claim);
  }
}

// Keeps the first claim to a name.
void FileClaims::insert(Claims& claims, std::string_view name, const Claim& claim) {
  if (claims.contains(name)) return;
  claims.emplace(name, claim);
  bytes_ += kClaimBytes + name.size();
}

// Throws if `others` has the name `other` for other contents than those of the claim to `name`.
void FileClaims::compare(std::string_view name, const Claim& claim, const Claims& others,
                         std::string_view other) const {
  const auto found = others.find(other);
  if (found == others.end()) return;
  const Claim& first = found->second;
  const bool isSameOwner = (claim.ofSet && first.ofSet) || (!claim.ofSet && !first.ofSet && claim.frame == first.frame);
  if (claim.contents == first.contents && isSameOwner) return;
  if (first.format == kOwnRecords)
    badUsage("formats: {} would write '{}', which the data set itself reserves: choose another path or name",
             describe(claim), name);
  badUsage(
      "formats: {} and {} would both write '{}', with different contents: choose another path or name for one of them",
      describe(first), describe(claim), name);
}

// Files without a description have the same contents only if the formats and their options are equal.
uint64_t FileClaims::contentsOf(size_t format, size_t number, const FormatFile& file) {
  if (file.contents.empty()) return uint64_t{sameFormat_[format]} << 32 | number;
  return kDescribed | contents_.try_emplace(file.contents, contents_.size()).first->second;
}

std::string FileClaims::describe(const Claim& claim) const {
  const std::string format = fmt::format("{} (formats[{}])", job_.formats[claim.format].name, claim.format);
  return claim.ofSet ? format : fmt::format("{} for the frame \"{}\"", format, frameName_(claim.frame));
}

}  // namespace latelight::data
