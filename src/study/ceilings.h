// What a device can do at most, by shaders that do nothing else.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "study/table.h"
#include "vk/device.h"

namespace latelight::study {

struct Ceilings {           // a second
  double copiedBytes = 0;   // of memory, read and written together
  double multiplyAdds = 0;  // of 32-bit floats in registers
};

// The best of so many runs, after one that warms up.
Ceilings measureCeilings(vk::Device& device, uint32_t runs);

// Two cells for a pass: the megabytes that it reads and writes as a whole (graph::PassTime), and what share, in per
// cent, they are of what the device could have copied meanwhile. Empty where it has none.
void addCopyCells(std::vector<Cell>& row, const Ceilings& ceilings, uint64_t wholeBytes, double milliseconds);

std::string toText(const Ceilings& ceilings);
nlohmann::ordered_json toJson(const Ceilings& ceilings);

}  // namespace latelight::study
