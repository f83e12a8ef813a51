#include "data/format.h"

#include "data/formats/formats.h"

namespace latelight::data {

FrameRecord Format::writeFrame(const DataFrame& frame, const std::filesystem::path& folder) const {
  check(frame);
  FrameRecord record;
  try {
    writeFiles(frame, folder, record);
  } catch (...) {
    removeFiles(folder, record.files);
    throw;
  }
  return record;
}

void removeFiles(const std::filesystem::path& folder, const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(folder / file, ignored)) std::filesystem::remove(folder / file, ignored);
  }
}

std::span<const FormatInfo> formats() {
  static constexpr FormatInfo kFormats[] = {
      {"files", "outputs as PNG, EXR or NPY files, named by one pattern", makeFiles},
      {"exr", "all outputs of a frame in one OpenEXR file, with Latelight's or Blender's channel names", makeExr},
      {"npz", "all outputs of a frame in one NPZ file for numpy.load", makeNpz},
      {"hdf5", "HDF5 files as BlenderProc writes them (requires the HDF5 library)", makeHdf5, "categories"},
      {"webdataset", "tar archives of frames for the library WebDataset", makeWebDataset},
      {"depth-png", "16-bit PNG depth: millimeters, KITTI's 256 steps per meter, or any scale", makeDepthPng},
      {"flow", "optical flow to the next or previous frame: .flo or KITTI's PNG", makeFlow},
      {"correspondence", "where the surfaces of a frame are in other frames, with scene flow and visibility",
       makeCorrespondence},
      {"coco", "COCO instances: boxes, masks and categories of visible objects", makeCoco, "categories"},
      {"yolo", "YOLO labels as Ultralytics reads them: boxes and classes of visible objects", makeYolo, "categories"},
      {"voc", "Pascal VOC annotations: an XML file per image with boxes of visible objects", makeVoc, "categories"},
      {"kitti", "KITTI's object benchmark: 2D and 3D boxes, occlusion and calibration", makeKitti, "categories"},
      {"boxes", "boxes of objects as JSON: visible and full 2D boxes, oriented 3D boxes, visible fraction", makeBoxes},
      {"bop", "BOP layout: images, depth, masks, poses of objects and cameras", makeBop, "models"},
      {"scannet", "ScanNet's folders: color, depth, poses, intrinsics, instances and labels", makeScannet,
       "categories"},
      {"transforms", "transforms.json of nerfstudio and instant-ngp: images, depth and cameras", makeTransforms},
      {"colmap", "COLMAP models with images, depth maps and points with tracks", makeColmap},
      {"cryptomatte", "Cryptomatte of objects and materials in OpenEXR", makeCryptomatte},
      {"ply", "point cloud as binary PLY: position, normal, color, id", makePly},
      {"lidar", "point clouds of a lidar sensor on each camera: PLY, PCD, KITTI's .bin or NPZ", makeLidar},
      {"video", "the frames as an mp4 video (requires ffmpeg)", makeVideo},
  };
  return kFormats;
}

}  // namespace latelight::data
