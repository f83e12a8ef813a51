#include "output/debug_request.h"

#include <algorithm>

namespace latelight::output {

namespace {

// Returns the outputs of the sheet, which the help of --debug describes.
std::vector<Aov> aovsOfSheet(bool moving) {
  std::vector<Aov> all;
  for (const AovInfo& aov : aovs()) {
    if (aov.aov == Aov::Samples) continue;  // constant without multisampling
    if (aov.aov == Aov::Raw) continue;      // like the picture without a sensor
    if (tellsOfRaster(aov.aov)) continue;
    if (aov.aov != Aov::Motion || moving) all.push_back(aov.aov);
  }
  return all;
}

// Returns the images of one target at full size. targetPictures() appends depth, which is removed here.
Picture targetPicture(const RawGbuffer& gbuffer, const std::string& name) {
  RawGbuffer one = gbuffer;
  std::erase_if(one.targets, [&](const RawTarget& target) { return target.name != name; });
  std::vector<Labelled> pictures = targetPictures(one);
  pictures.pop_back();
  return contactSheet(pictures, 2, gbuffer.width);
}

}  // namespace

DebugRequest parseDebug(std::string_view text, bool moving) {
  constexpr std::string_view kTarget = "target:";
  if (text == "targets") return {.targets = true};
  if (text.starts_with(kTarget)) return {.targets = true, .target = std::string(text.substr(kTarget.size()))};
  if (text == "sheet") return {.aovs = aovsOfSheet(moving), .sheet = true};
  DebugRequest request{.aovs = parseAovs(text == "lights" ? "lights-tested,lights-used" : text)};
  request.sheet = request.aovs.size() > 1;
  return request;
}

std::string_view debugName(const DebugRequest& request) {
  if (request.targets) return request.target.empty() ? "targets" : std::string_view(request.target);
  return request.sheet ? "sheet" : info(request.aovs.front()).name;
}

Picture debugPicture(const DebugRequest& request, const FrameOutput& frame) {
  const auto ids = std::ranges::find(frame.aovs, Aov::Id, &AovImage::aov);
  std::vector<Labelled> pictures;
  for (const AovImage& aov : frame.aovs) {
    if (!contains(request.aovs, aov.aov)) continue;
    Picture picture = aov.aov == Aov::Color && !frame.display.empty()
                          ? Picture{frame.width, frame.height, frame.display}
                          : debugPicture(aov, ids == frame.aovs.end() ? nullptr : &*ids);
    pictures.push_back({std::string(info(aov.aov).name), std::move(picture)});
  }
  return request.sheet ? contactSheet(pictures) : std::move(pictures.front().picture);
}

Picture debugPicture(const DebugRequest& request, const RawGbuffer& gbuffer) {
  return request.target.empty() ? contactSheet(targetPictures(gbuffer)) : targetPicture(gbuffer, request.target);
}

}  // namespace latelight::output
