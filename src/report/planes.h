// The values of every pixel, stored exactly in the page. Identical planes are stored once.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace latelight::report {

class Planes {
 public:
  // Returns the number by which the page's script finds the plane. Words hold float bits, integers, or four bytes.
  size_t add(std::span<const uint32_t> words);
  const std::string& toHtml() const { return html_; }

 private:
  std::string html_;
  std::unordered_map<std::string, size_t> numbers_;  // by encoded text
};

}  // namespace latelight::report
