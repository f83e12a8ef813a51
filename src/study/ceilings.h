// The ceilings of a device: its peak copy bandwidth and peak arithmetic rate, measured by shaders that do only this.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "study/table.h"
#include "vk/device.h"

namespace latelight::study {

struct Ceilings {           // per second
  double copiedBytes = 0;   // bytes of memory, read and written together
  double multiplyAdds = 0;  // multiply-adds of 32-bit floats in registers
};

// Returns the best of this many runs, after one warm-up run.
Ceilings measureCeilings(vk::Device& device, uint32_t runs);

// Appends two cells for a pass: the megabytes of the full images and buffers that it reads and writes
// (graph::PassTime), and these as a percentage of what the device could have copied in the same time. Both are empty if
// `trafficBytes` is 0.
void addCopyCells(std::vector<Cell>& row, const Ceilings& ceilings, uint64_t trafficBytes, double milliseconds);

std::string toText(const Ceilings& ceilings);
nlohmann::ordered_json toJson(const Ceilings& ceilings);

}  // namespace latelight::study
