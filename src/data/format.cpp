#include "data/format.h"

namespace latelight::data {

std::span<const FormatInfo> formats() {
  return {};
}

}  // namespace latelight::data
