// A finished frame of a data set, the input of every format.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "data/cameras/exposure.h"
#include "data/keypoints.h"
#include "data/pairs.h"
#include "data/scans.h"
#include "labels/objects.h"
#include "output/files.h"
#include "output/metadata.h"

namespace latelight::data {

using labels::GeometryHashes;
using labels::Mask;
using labels::masksOf;
using labels::Object;
using labels::PixelBox;
using labels::Shape;

// The data of a frame that formats may require in addition to its outputs (extras.h).
struct Extras {
  bool boxes = false;   // objects, with their boxes
  bool alone = false;   // objects, also with their amodal masks
  bool order = false;   // objects, also with their masks and the order in which they occlude each other
  bool shapes = false;  // objects, also with their shapes
  std::vector<ObjectKeypoint> keypoints;  // keypoints of objects; empty: none
  std::vector<PairTarget> pairs;          // correspondence with these images; empty: none
  ScanRequests scans;                     // lidar scans; empty: none
  uint32_t samples = 0;                   // N: ids and materials at N x N samples per pixel; 0: none

  bool needsAny() const {
    return boxes || alone || order || shapes || !keypoints.empty() || !pairs.empty() || !scans.empty() || samples > 0;
  }
};

struct DataFrame {
  uint64_t index = 0;  // in the job's order, over all its shards
  std::string name;    // stem of the frame's files, as in "000017"; unique in the data set
  output::FrameOutput picture;
  // Camera, coordinate frames, settings, and the nodes and primitives that the ids identify.
  output::Metadata metadata;
  // The nodes of all variations of the scene, whichever of them this one shows; null: as in the metadata.
  std::shared_ptr<const output::IdManifest> idsOfAll{};
  uint32_t scene = 0;       // the scene's index in the job
  uint32_t variation = 0;   // the variation's index
  uint32_t camera = 0;      // the camera's index among those of the scene
  uint64_t state = 0;       // number of the scene and variation among all of the job
  CameraExposure exposure;  // of the camera, where it differs from the job's options
  // The camera at the times of the image's upper and lower edge if it moves while rows are read out; otherwise empty.
  std::vector<output::CameraMetadata> edges{};

  // The cameras of the frames that the outputs motion and scene-flow lead to; empty if there is none.
  std::optional<output::CameraMetadata> previousCamera{}, nextCamera{};

  std::vector<Object> objects;  // sorted by id
  KeypointsOfObjects keypoints;
  std::vector<FramePair> pairs;  // those that exist, in the order of Extras::pairs
  std::vector<FrameScan> scans;  // in the order of Extras::scans
  // Id and material of a picture N times as wide and high, an ordered grid of N x N samples per pixel.
  output::FrameOutput samples;
};

}  // namespace latelight::data
