#include "report/planes.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <new>

#include "report/html.h"

namespace latelight::report {

namespace {

// Separates the words into byte planes, lowest bytes first, each byte as the difference from the previous one. For the
// G-buffer of a textured scene, this is 14 % smaller after deflate than the words themselves.
std::vector<std::byte> filtered(std::span<const uint32_t> words) {
  std::vector<std::byte> bytes;
  bytes.reserve(words.size() * 4);
  for (uint32_t shift = 0; shift < 32; shift += 8) {
    uint32_t before = 0;
    for (const uint32_t word : words) {
      bytes.push_back(static_cast<std::byte>((word >> shift) - before));
      before = word >> shift;
    }
  }
  return bytes;
}

// Returns a palette: the number of distinct values, these in ascending order, and per pixel the index of its value. If
// few pixels are alike, returns 0 and the words themselves. Values of eight bits then need a quarter of the space of
// floats.
std::vector<uint32_t> withTable(std::span<const uint32_t> words) {
  std::vector<uint32_t> table(words.begin(), words.end());
  std::ranges::sort(table);
  table.erase(std::unique(table.begin(), table.end()), table.end());
  if (table.size() > words.size() / 4) table.clear();
  std::vector<uint32_t> all{static_cast<uint32_t>(table.size())};
  all.insert(all.end(), table.begin(), table.end());
  for (const uint32_t word : words)
    all.push_back(table.empty() ? word : static_cast<uint32_t>(std::ranges::lower_bound(table, word) - table.begin()));
  return all;
}

std::vector<std::byte> deflated(std::span<const std::byte> bytes) {
  std::vector<std::byte> out(compressBound(static_cast<uLong>(bytes.size())));
  auto size = static_cast<uLongf>(out.size());
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                static_cast<uLong>(bytes.size()), Z_BEST_COMPRESSION) != Z_OK)
    throw std::bad_alloc();
  out.resize(size);
  return out;
}

}  // namespace

size_t Planes::add(std::span<const uint32_t> words) {
  std::string text = base64(deflated(filtered(withTable(words))));
  const auto [known, isNew] = numbers_.try_emplace(std::move(text), numbers_.size());
  if (isNew)
    html_ += fmt::format("<script type=\"text/plain\" id=\"plane-{}\">{}</script>\n", known->second, known->first);
  return known->second;
}

}  // namespace latelight::report
