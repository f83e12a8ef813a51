// usage: fuzz_seeds FOLDER: writes the first inputs of every fuzz target to FOLDER/TARGET.
#include <fmt/format.h>

#include <cstdio>

#include "base/error.h"
#include "base/files.h"
#include "fuzz/seeds/seeds.h"

namespace latelight::fuzz {

void Seeds::add(std::string_view target, std::span<const std::byte> bytes) {
  std::filesystem::create_directories(folder_ / target);
  writeFile(folder_ / target / fmt::format("seed{:03}", count_++), bytes);
}

void Seeds::add(std::string_view target, std::string_view prefix, std::span<const std::byte> bytes) {
  const auto before = std::as_bytes(std::span(prefix));
  std::vector<std::byte> all(before.begin(), before.end());
  all.insert(all.end(), bytes.begin(), bytes.end());
  add(target, all);
}

}  // namespace latelight::fuzz

int main(int count, char** arguments) try {
  if (count != 2) latelight::badUsage("fuzz_seeds requires the folder to write to");
  latelight::fuzz::Seeds seeds(arguments[1]);
  latelight::fuzz::addScenes(seeds);
  latelight::fuzz::addImages(seeds);
  latelight::fuzz::addMeshFiles(seeds);
  latelight::fuzz::addTexts(seeds);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
