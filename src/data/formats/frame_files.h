// What formats share in writing a frame's files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "data/format.h"

namespace latelight::data {

// Throws Error(Internal) where the frame lacks the output.
const output::AovImage& imageOf(const output::FrameOutput& picture, output::Aov aov);

// The frame's, with those ids alone that its pictures show: a scene's may be far more than a small picture takes.
output::Metadata metadataOf(const DataFrame& frame);

// A pattern with the frame's name for "{name}".
std::string frameFile(std::string_view pattern, const DataFrame& frame);

// Writes a file below the data set's folder, whole or not at all; folders are made.
void writeBelow(const std::filesystem::path& folder, const std::string& name, std::span<const std::byte> bytes);
// The same; the frame has it then.
void writeOf(FrameRecord& record, const std::filesystem::path& folder, const std::string& name,
             std::span<const std::byte> bytes);

// A file of JSON, on one line.
void writeJsonBelow(const std::filesystem::path& folder, const std::string& name, const nlohmann::ordered_json& json);

}  // namespace latelight::data
