#include "data/format.h"

#include "data/formats/formats.h"

namespace latelight::data {

std::span<const FormatInfo> formats() {
  static constexpr FormatInfo kFormats[] = {
      {"files", "outputs as PNG, EXR or NPY files, named by one pattern", makeFiles},
      {"exr", "all outputs of a frame in one OpenEXR file, channels named by Latelight or as Blender does", makeExr},
      {"npz", "all outputs of a frame in one NPZ file, as numpy.load reads it", makeNpz},
      {"depth-png", "depth as PNG of 16 bits: millimetres, KITTI's 256 a metre, or any scale", makeDepthPng},
      {"flow", "optical flow to the next or the previous frame: .flo, or KITTI's PNG", makeFlow},
      {"coco", "COCO's instances: boxes, masks and categories of visible objects", makeCoco},
      {"boxes", "boxes of objects as JSON: visible and whole in the picture, oriented in space; the share visible",
       makeBoxes},
      {"bop", "BOP's layout: pictures, depth, masks, poses of objects and cameras", makeBop},
      {"transforms", "transforms.json of nerfstudio and instant-ngp: pictures, depth and their cameras",
       makeTransforms},
      {"cryptomatte", "Cryptomatte of objects and materials, in OpenEXR", makeCryptomatte},
      {"ply", "surfaces as points, binary PLY: position, normal, colour, id", makePly},
      {"video", "the frames as a film, mp4, where ffmpeg is installed", makeVideo},
  };
  return kFormats;
}

}  // namespace latelight::data
