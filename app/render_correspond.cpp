#include "app/render_correspond.h"

#include "app/parse.h"
#include "app/render_labels.h"
#include "base/error.h"
#include "base/lowercase.h"
#include "data/formats/correspondence_arrays.h"

namespace latelight::app {

namespace {

bool isExr(const std::string& pattern) {
  return lowercaseExtension(pattern) == ".exr";
}

bool hasOwnCamera(const RenderOptions& o) {
  return !o.toCamera.empty() || !o.toEye.empty();
}

void checkCorrespondFile(const std::string& pattern) {
  if (!isExr(pattern) && lowercaseExtension(pattern) != ".npz")
    badUsage("--correspond writes NPZ or EXR; give it a name that ends in .npz or .exr, not \"{}\"", pattern);
  checkFrameFile("--correspond", pattern);
}

void checkSecondCamera(const RenderOptions& o) {
  if (!o.toCamera.empty() && !o.toEye.empty())
    badUsage("--to-camera and --to-eye both set the camera of the second picture; use one of them");
  if (o.toEye.empty() != o.toTarget.empty()) badUsage("--to-eye and --to-target require each other");
  if (o.toEye.empty()) return;
  parseVector("--to-eye", o.toEye);
  parseVector("--to-target", o.toTarget);
}

// Two pictures of the scene at rest differ in their cameras only.
void checkSecondTime(const RenderOptions& o) {
  if (!o.to.empty() && o.toTime)
    badUsage("--to and --to-time both set the time of the second picture; use one of them");
  const bool isTimed = o.settings.time || !o.frames.empty();
  if (isTimed) return;
  if (!o.to.empty() || o.toTime)
    badUsage("--to and --to-time require the time of the first picture: --time or --frames");
  if (!hasOwnCamera(o))
    badUsage(
        "--correspond requires a second picture: give its camera with --to-camera or with --to-eye and --to-target, or "
        "the time of the first with --time or --frames");
}

}  // namespace

void checkCorrespond(const RenderOptions& o) {
  if (o.correspond.empty()) {
    if (!o.to.empty() || o.toTime || hasOwnCamera(o) || !o.toTarget.empty())
      badUsage(
          "--to, --to-time, --to-camera, --to-eye and --to-target describe the second picture of --correspond: give "
          "its file");
    return;
  }
  checkCorrespondFile(o.correspond);
  checkSecondCamera(o);
  stepToSecond(o);
  checkSecondTime(o);
}

int64_t stepToSecond(const RenderOptions& o) {
  if (!o.to.empty()) return parseStep(o.to);
  return hasOwnCamera(o) ? 0 : 1;
}

RenderOptions optionsOfSecond(const RenderOptions& o) {
  if (!hasOwnCamera(o)) return o;
  RenderOptions second = o;
  second.camera = o.toCamera;
  second.eye = o.toEye;
  second.target = o.toTarget;
  second.orbit.clear();
  if (second.eye.empty()) second.up.clear();
  return second;
}

std::filesystem::path writeCorrespondence(const std::string& pattern, const labels::Correspondence& match,
                                          const output::Metadata& metadata) {
  const std::vector<std::byte> bytes =
      isExr(pattern) ? data::encodeCorrespondenceExr(match, metadata) : data::encodeCorrespondenceNpz(match);
  return writeFrameFile(pattern, bytes, metadata).front();
}

}  // namespace latelight::app
