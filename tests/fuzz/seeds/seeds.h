// The first inputs of the fuzz targets. They are created by the builders of the tests instead of being kept as files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace latelight::fuzz {

// Writes seeds into one folder per target, numbered in order.
class Seeds {
 public:
  explicit Seeds(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void add(std::string_view target, std::span<const std::byte> bytes);
  void add(std::string_view target, std::string_view text) { add(target, std::as_bytes(std::span(text))); }
  // The same with bytes before it by which a target selects its parser.
  void add(std::string_view target, std::string_view prefix, std::span<const std::byte> bytes);

 private:
  std::filesystem::path folder_;
  size_t count_ = 0;
};

void addScenes(Seeds& seeds);
void addImages(Seeds& seeds);
void addMeshFiles(Seeds& seeds);
void addTexts(Seeds& seeds);

}  // namespace latelight::fuzz
