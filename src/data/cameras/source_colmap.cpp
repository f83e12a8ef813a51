// The camera source "colmap": the images of a COLMAP model.
#include <algorithm>
#include <cctype>

#include "data/cameras/colmap.h"

namespace latelight::data {

namespace {

bool isDigit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

// Removes the digits at the front of the text and returns them without leading zeros.
std::string_view takeNumber(std::string_view& text) {
  const size_t end = std::min(text.size(), static_cast<size_t>(std::ranges::find_if_not(text, isDigit) - text.begin()));
  std::string_view number = text.substr(0, end);
  text.remove_prefix(end);
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
  return number;
}

// Natural sort order: numbers in names compare by value, so "r_2" is before "r_10".
bool isBefore(std::string_view a, std::string_view b) {
  while (!a.empty() && !b.empty()) {
    if (isDigit(a[0]) && isDigit(b[0])) {
      const std::string_view x = takeNumber(a), y = takeNumber(b);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      if (a[0] != b[0]) return static_cast<unsigned char>(a[0]) < static_cast<unsigned char>(b[0]);
      a.remove_prefix(1), b.remove_prefix(1);
    }
  }
  return a.empty() && !b.empty();
}

}  // namespace

// Images are sorted by name, because the order in a model's files has no meaning.
std::vector<Shot> shotsOfColmap(Spec& spec, const CameraContext& context) {
  std::vector<CalibratedCamera> cameras = readColmap(spec.text("folder"));
  std::ranges::stable_sort(cameras, isBefore, &CalibratedCamera::name);
  std::vector<Shot> shots = placeCameras(spec, context, cameras);
  makeSequence(shots);
  return shots;
}

}  // namespace latelight::data
