// The factories of all formats. Each format is one file; format.cpp lists them.
#pragma once

#include <memory>

#include "data/format.h"

namespace latelight::data {

std::unique_ptr<Format> makeBop(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeBoxes(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeCoco(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeColmap(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeCorrespondence(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeCryptomatte(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeDepthPng(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeExr(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeFiles(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeFlow(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeHdf5(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeKitti(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeLidar(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeNpz(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makePly(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeScannet(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeTransforms(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeVideo(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeVoc(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeWebDataset(const nlohmann::ordered_json& options);
std::unique_ptr<Format> makeYolo(const nlohmann::ordered_json& options);

}  // namespace latelight::data
