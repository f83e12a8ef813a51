// Functions that formats share to write a frame's files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "data/format.h"

namespace latelight::data {

// Returns an output of a frame. Throws Error(Internal) if the frame lacks it.
const output::AovImage& imageOf(const output::FrameOutput& picture, output::Aov aov);

// Returns the frame's metadata with only the ids that are visible in its images, because a scene may have far more.
output::Metadata metadataOf(const DataFrame& frame);

// Returns the picture composited over black, without alpha: RGB, 8 bits, sRGB.
std::vector<uint8_t> rgbOverBlack(const output::FrameOutput& picture);

// Returns a pattern with "{name}" replaced by the frame's name.
std::string frameFile(std::string_view pattern, const DataFrame& frame);

// Writes a file below the data set's folder, whole or not at all. Creates missing folders.
void writeIn(const std::filesystem::path& folder, const std::string& name, std::span<const std::byte> bytes);
// Writes a file as writeIn() does, and adds it to the frame's record.
void writeOf(FrameRecord& record, const std::filesystem::path& folder, const std::string& name,
             std::span<const std::byte> bytes);

// Writes JSON on one line, as writeIn() does.
void writeJsonIn(const std::filesystem::path& folder, const std::string& name, const nlohmann::ordered_json& json);

}  // namespace latelight::data
