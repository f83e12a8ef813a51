#include "data/format.h"

#include "data/formats/files.h"

namespace latelight::data {

std::span<const FormatInfo> formats() {
  static constexpr FormatInfo kFormats[] = {
      {"files", "outputs as PNG, EXR or NPY files, named by one pattern", makeFiles},
  };
  return kFormats;
}

}  // namespace latelight::data
