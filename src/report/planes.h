// Values of every pixel, kept exactly in the page, and each set of them once.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace latelight::report {

class Planes {
 public:
  // Gives the number by which the page's script finds them. Words: floats by their bits, integers, or four bytes.
  size_t add(std::span<const uint32_t> words);
  const std::string& toHtml() const { return html_; }

 private:
  std::string html_;
  std::unordered_map<std::string, size_t> numbers_;  // by what is written of them
};

}  // namespace latelight::report
