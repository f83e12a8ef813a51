// The format "files".
#pragma once

#include "data/format.h"

namespace latelight::data {

std::unique_ptr<Format> makeFiles(const nlohmann::ordered_json& options);

}  // namespace latelight::data
