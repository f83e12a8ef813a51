// The format `lidar` in data sets: ranges, motion and intensity by formulas, and the same bytes by shards and after
// resumption. The scene is a wall at z = 0 that faces sensors at positive z.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "batch/sets.h"

namespace latelight::data {
namespace {

using app::Folder;
using app::latelight;
using app::Outcome;
using nlohmann::json;
using testing::HasSubstr;

constexpr double kWall = 5000;  // half of its width and height, meters

// `speed`: meters per second along +z from time 0 on. The default material of glTF is a white metal, so its reflectance
// is 1.
void writeWall(const Folder& folder, float speed = 0) {
  const auto w = static_cast<float>(kWall);
  const float values[] = {-w, -w, 0, w, -w, 0, w, w, 0, -w, w, 0, 0, 10, 0, 0, 0, 0, 0, 10 * speed};
  const uint16_t indices[] = {0, 1, 2, 0, 2, 3};
  std::string buffer(reinterpret_cast<const char*>(values), sizeof(values));
  buffer.append(reinterpret_cast<const char*>(indices), sizeof(indices));
  folder.write("wall.bin", std::string_view(buffer));
  folder.write("wall.gltf", std::string_view(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "wall", "mesh": 0}], "buffers": [{"uri": "wall.bin", "byteLength": 92}],
    "meshes": [{"name": "plate", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "animations": [{"samplers": [{"input": 2, "output": 3}],
      "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 80, "byteLength": 12},
      {"buffer": 0, "byteOffset": 48, "byteLength": 8}, {"buffer": 0, "byteOffset": 56, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-5000, -5000, 0],
      "max": [5000, 5000, 0]}, {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
      {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [10]},
      {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}]})"));
}

// A camera at this z that looks along -z, with its x axis along the scene's.
json poseAtZ(double z) {
  return json::array({{1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, z}, {0, 0, 0, 1}});
}

json standing(double z) {
  return {{"type", "list"}, {"cameras", {{{"name", "still"}, {"pose", poseAtZ(z)}}}}};
}

// From z = 30 to z = 20 within a second, with 10 frames per second.
json approaching() {
  return {{"type", "path"},
          {"fps", 10},
          {"keys", {{{"time", 0}, {"pose", poseAtZ(30)}}, {{"time", 1}, {"pose", poseAtZ(20)}}}}};
}

// Two rings without noise and limits.
const json kExact{{"type", "spinning"}, {"rings", 2}, {"elevations", {-5, 5}},
                  {"azimuth-step", 1},  {"rate", 10}, {"firing", 1e-6}};

struct Point {
  float x, y, z, intensity;
  double time;
  uint16_t ring;
  float range;
  uint8_t echo;
  uint32_t firing, id, part, material;
};

std::vector<Point> pointsIn(const std::string& ply) {
  constexpr std::string_view kEnd = "end_header\n";
  constexpr size_t kRecord = 47;
  const char* at = ply.data() + ply.find(kEnd) + kEnd.size();
  std::vector<Point> points;
  for (; at + kRecord <= ply.data() + ply.size(); at += kRecord) {
    Point& p = points.emplace_back();
    std::memcpy(&p.x, at, 16);
    std::memcpy(&p.time, at + 16, 8);
    std::memcpy(&p.ring, at + 24, 2);
    std::memcpy(&p.range, at + 26, 4);
    std::memcpy(&p.echo, at + 30, 1);
    std::memcpy(&p.firing, at + 31, 16);
  }
  return points;
}

Outcome scan(const Folder& folder, const json& cameras, const json& format, std::vector<std::string> more = {}) {
  json whole = format;
  whole["format"] = "lidar";
  folder.write("job.json", std::string_view(json{{"cameras", cameras}, {"formats", {whole}}}.dump()));
  std::vector<std::string> all{"job.json", "--scenes", "wall.gltf"};
  if (std::ranges::find(more, "-o") == more.end()) all.insert(all.end(), {"-o", "set"});
  all.insert(all.end(), more.begin(), more.end());
  return latelight(batch(folder, all));
}

TEST(Lidar, SeesAWallAsTheFormulaSays) {
  Folder folder;
  writeWall(folder);
  const Outcome outcome = scan(folder, standing(12), {{"sensor", kExact}});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const std::vector<Point> points = pointsIn(folder.read("set/lidar/000000.ply"));
  EXPECT_NEAR(double(points.size()), 2 * 179, 2);  // half of the circle
  for (const Point& p : points) {
    const double turn = (p.firing / 2 + p.firing % 2 * 1e-6 * 3600) * M_PI / 180, rise = p.ring == 0 ? -5 : 5;
    EXPECT_EQ(p.ring, p.firing % 2);
    EXPECT_NEAR(p.time, (p.firing / 2) * 0.1 / 360 + p.firing % 2 * 1e-6, 1e-12);
    const double ahead = std::cos(rise * M_PI / 180) * std::cos(turn), range = 12 / ahead;
    EXPECT_NEAR(p.range / range, 1, 1e-6);
    EXPECT_NEAR(p.x, 12, 12e-6);
    EXPECT_NEAR(p.y / range, -std::cos(rise * M_PI / 180) * std::sin(turn), 1e-6);  // clockwise: to the right first
    EXPECT_NEAR(p.z / range, std::sin(rise * M_PI / 180), 1e-6);
    EXPECT_NEAR(p.intensity, ahead, 2e-6);  // Lambert's law
    EXPECT_EQ(p.id, points.front().id);
  }
  const json scans = json::parse(folder.read("set/lidar/scans.json"));
  EXPECT_EQ(scans["scans"][0]["points"], points.size());
  EXPECT_EQ(scans["scans"][0]["objects"],
            json::array({{{"id", points[0].id}, {"node", "/wall"}, {"category", "plate"}}}));
  EXPECT_EQ(scans["scans"][0]["world_from_sensor"], json({{0, -1, 0, 0}, {0, 0, 1, 0}, {-1, 0, 0, 12}, {0, 0, 0, 1}}));
}

TEST(Lidar, MovesWithItsCamera) {
  Folder folder;
  writeWall(folder);
  const Outcome outcome = scan(folder, approaching(), {{"sensor", kExact}});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  for (int frame = 0; frame <= 10; ++frame) {  // the last one continues the motion
    const std::vector<Point> points = pointsIn(folder.read(fmt::format("set/lidar/{:06}.ply", frame)));
    ASSERT_GT(points.size(), 300u);
    double shortest = 1e9, longest = 0;
    for (const Point& p : points) {
      EXPECT_NEAR(p.x, 30 - frame - 10 * p.time, 30e-5);
      shortest = std::min(shortest, double{p.x}), longest = std::max(longest, double{p.x});
    }
    EXPECT_GT(longest - shortest, 0.9);
  }
  // In the world, the wall is flat.
  ASSERT_EQ(scan(folder, approaching(), {{"sensor", kExact}, {"frame", "world"}}, {"-o", "world"}).code, 0);
  for (const Point& p : pointsIn(folder.read("world/lidar/000003.ply"))) EXPECT_NEAR(p.z, 0, 30e-6);
  // Without times, the poses of a sequence are no motion.
  json poses = approaching();
  poses.erase("fps");
  poses["count"] = 11;
  for (json& key : poses["keys"]) key.erase("time");
  ASSERT_EQ(scan(folder, poses, {{"sensor", kExact}}, {"-o", "still"}).code, 0);
  for (const Point& p : pointsIn(folder.read("still/lidar/000003.ply"))) EXPECT_NEAR(p.x, 27, 30e-6);
}

TEST(Lidar, SeesTheSceneMoveInSlices) {
  Folder folder;
  writeWall(folder, 5);
  for (const int slices : {1, 4, 10}) {
    const json format{{"sensor", kExact}, {"slices", slices}};
    const std::string set = fmt::format("set{}", slices);
    const Outcome outcome = scan(folder, standing(30), format, {"-o", set, "--time", "2"});
    ASSERT_EQ(outcome.code, 0) << outcome.text();
    for (const Point& p : pointsIn(folder.read(set + "/lidar/000000.ply"))) {
      const double middle = (std::floor(p.time / 0.1 * slices) + 0.5) * 0.1 / slices;
      EXPECT_NEAR(p.x, 30 - 5 * (2 + middle), 3e-5) << slices << " " << p.time;
    }
  }
}

// The second laser fires 0.12 s after the first one, which is up to 0.12 s after the period of 0.1 s.
TEST(Lidar, FiringsAfterThePeriodHaveTheirOwnTimes) {
  Folder folder;
  json late = kExact;
  late["firing"] = {0, 0.12};
  writeWall(folder, 5);
  ASSERT_EQ(scan(folder, standing(30), {{"sensor", late}, {"slices", 4}}, {"--time", "2"}).code, 0);
  double last = 0;
  for (const Point& p : pointsIn(folder.read("set/lidar/000000.ply"))) {
    EXPECT_NEAR(p.x, 30 - 5 * (2 + (std::floor(p.time / 0.025) + 0.5) * 0.025), 3e-5) << p.time;
    last = std::max(last, p.time);
  }
  EXPECT_GT(last, 0.15);
  // The path turns back after the first period.
  writeWall(folder);
  const json path{{"type", "path"},
                  {"fps", 10},
                  {"keys",
                   {{{"time", 0}, {"pose", poseAtZ(30)}},
                    {{"time", 0.1}, {"pose", poseAtZ(29)}},
                    {{"time", 0.2}, {"pose", poseAtZ(38)}},
                    {{"time", 0.3}, {"pose", poseAtZ(38)}}}}};
  ASSERT_EQ(scan(folder, path, {{"sensor", late}}, {"-o", "moving"}).code, 0);
  for (const Point& p : pointsIn(folder.read("moving/lidar/000000.ply"))) {
    const double z = p.time < 0.1 ? 30 - 10 * p.time : p.time < 0.2 ? 29 + 90 * (p.time - 0.1) : 38;
    EXPECT_NEAR(p.x, z, 4e-4) << p.time;
  }
}

TEST(Lidar, IsMountedOnItsCamera) {
  Folder folder;
  writeWall(folder);
  json format{{"sensor", kExact}, {"mount", {{"translation", {0, -1, -2}}}}};
  ASSERT_EQ(scan(folder, standing(12), format).code, 0);  // behind the camera
  for (const Point& p : pointsIn(folder.read("set/lidar/000000.ply"))) EXPECT_NEAR(p.x, 14, 14e-6);
  // Turned to the left by 90 degrees: the wall is to the right.
  format["mount"] = {{"pose", {{0, 0, -1, 0}, {0, 1, 0, 0}, {1, 0, 0, 0}, {0, 0, 0, 1}}}};
  ASSERT_EQ(scan(folder, standing(12), format, {"-o", "turned"}).code, 0);
  for (const Point& p : pointsIn(folder.read("turned/lidar/000000.ply"))) EXPECT_NEAR(p.y, -12, 12e-6);
}

// KITTI's calibration is the sensor's mount: by hand, and by points that it maps to the wall. The camera looks along -Z
// at the wall at a distance of 12 m, at z = 0.
TEST(Lidar, KittisCalibrationIsItsMount) {
  const auto calibration = [](const json& formats) {
    Folder folder;
    writeWall(folder);
    folder.write("job.json", std::string_view(json{{"cameras", standing(12)}, {"formats", formats}}.dump()));
    const Outcome outcome = latelight(batch(folder, {"job.json", "--scenes", "wall.gltf", "-o", "set"}));
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    const std::string text = folder.read("set/calib/000000.txt");
    const size_t at = text.find("Tr_velo_to_cam:");
    std::istringstream in(text.substr(std::min(text.size(), at + 15)));
    std::array<double, 12> m{};
    for (double& value : m) in >> value;
    EXPECT_TRUE(in) << text;
    const std::string points = folder.read("set/velodyne/000000.bin");
    EXPECT_GT(points.size(), 1000u);
    for (size_t i = 0; i + 16 <= points.size(); i += 16) {
      std::array<float, 3> p;
      std::memcpy(p.data(), points.data() + i, sizeof(p));
      EXPECT_NEAR(m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11], 12, 12e-6);
    }
    return m;
  };
  const json lidar{
      {"format", "lidar"}, {"sensor", kExact}, {"as", "bin"}, {"file", "velodyne/{name}.bin"}, {"scans", "a.json"}};
  json shifted = lidar, turned = lidar, second = lidar;
  shifted["mount"] = {{"translation", {0.5, -1, -2}}};
  EXPECT_THAT(calibration({"kitti", shifted}), testing::ElementsAre(0, -1, 0, 0.5, 0, 0, -1, -1, 1, 0, 0, -2));
  // Turned to the left by 90 degrees: the sensor's X is the camera's -X.
  turned["mount"] = {{"pose", {{0, 0, -1, 0}, {0, 1, 0, 3}, {1, 0, 0, 0}, {0, 0, 0, 1}}}};
  second["file"] = "second/{name}.bin", second["scans"] = "b.json";
  EXPECT_THAT(calibration({turned, "kitti", second}), testing::ElementsAre(-1, 0, 0, 0, 0, 0, -1, 3, 0, -1, 0, 0));
}

TEST(Lidar, PositionsInTheWorldAreRelativeToTheOrigin) {
  Folder folder;
  writeWall(folder);
  const std::vector<std::string> origin{"--position-origin", "1,2,-3", "--normal-frame", "opencv"};
  const auto pointsOf = [&](const char* frame) {
    std::vector<std::string> options = origin;
    options.insert(options.end(), {"-o", frame});
    const Outcome outcome = scan(folder, standing(12), {{"sensor", kExact}, {"frame", frame}}, options);
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    return pointsIn(folder.read(std::string(frame) + "/lidar/000000.ply"));
  };
  const std::vector<Point> sensor = pointsOf("sensor"), world = pointsOf("world");
  ASSERT_EQ(sensor.size(), world.size());
  ASSERT_GT(world.size(), 300u);
  for (size_t i = 0; i < world.size(); ++i) {
    EXPECT_NEAR(sensor[i].x, 12, 12e-6);
    EXPECT_NEAR(world[i].x, -sensor[i].y - 1, 1e-6 * world[i].range);  // the sensor's Y axis points to the left
    EXPECT_NEAR(world[i].y, sensor[i].z - 2, 1e-6 * world[i].range);
    EXPECT_NEAR(world[i].z, 3, 12e-6);
  }
}

TEST(Lidar, ShardsAndResumedSetsAreTheSame) {
  Folder folder;
  writeWall(folder, 1);
  const json format{{"sensor", "vlp-16"}, {"samples", 3}, {"returns", "dual"}, {"as", "npz"}};
  const std::vector<std::string> seed{"--seed", "5", "--time", "0"};
  const auto run = [&](const json& cameras, std::vector<std::string> more) {
    more.insert(more.end(), seed.begin(), seed.end());
    const Outcome outcome = scan(folder, cameras, format, more);
    EXPECT_EQ(outcome.code, 0) << outcome.text();
  };
  run(approaching(), {"-o", "whole"});
  for (const char* shard : {"0/2", "1/2"}) run(approaching(), {"-o", "parts", "--shard", shard});
  expectSame(filesOf(folder, "parts"), filesOf(folder, "whole"));
  std::filesystem::remove(folder.at("parts/lidar/000004.npz"));
  run(approaching(), {"-o", "parts", "--resume"});
  expectSame(filesOf(folder, "parts"), filesOf(folder, "whole"));
  // A frame changes with the pose that its scan leads to.
  json moved = approaching();
  moved["keys"][1]["pose"] = poseAtZ(10);
  run(moved, {"-o", "parts", "--resume"});
  run(moved, {"-o", "moved"});
  expectSame(filesOf(folder, "parts"), filesOf(folder, "moved"));
}

// Formats of one sensor write the same points, and different sensors have independent noise.
TEST(Lidar, NoiseBelongsToTheSensor) {
  Folder folder;
  writeWall(folder);
  json sensor = kExact;
  sensor["range-noise"] = 0.1;
  const json moved{{"translation", {0, 0, 0.5}}};
  const auto lidar = [&](const std::string& name, const json& mount) {
    json format{
        {"format", "lidar"}, {"sensor", sensor}, {"file", name + "/{name}.ply"}, {"scans", name + "/scans.json"}};
    if (!mount.is_null()) format["mount"] = mount;
    return format;
  };
  const json job{{"cameras", standing(12)}, {"formats", {lidar("a", {}), lidar("b", {}), lidar("c", moved)}}};
  folder.write("job.json", std::string_view(job.dump()));
  const Outcome outcome = latelight(batch(folder, {"job.json", "--scenes", "wall.gltf", "-o", "set"}));
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_EQ(folder.read("set/a/000000.ply"), folder.read("set/b/000000.ply"));
  const std::vector<Point> first = pointsIn(folder.read("set/a/000000.ply")),
                           other = pointsIn(folder.read("set/c/000000.ply"));
  ASSERT_EQ(first.size(), other.size());
  double squares = 0, product = 0;
  for (size_t i = 0; i < first.size(); ++i) {
    const double ahead = first[i].x / first[i].range;
    const double a = first[i].range - 12 / ahead, b = other[i].range - 11.5 / ahead;
    squares += a * a;
    product += a * b;
  }
  const double count = double(first.size());
  EXPECT_NEAR(std::sqrt(squares / count), 0.1, 4 * 0.1 / std::sqrt(2 * count));
  EXPECT_NEAR(product / count, 0, 4 * 0.01 / std::sqrt(count));
}

TEST(Lidar, ARosetteDoesNotRepeat) {
  Folder folder;
  writeWall(folder);
  json still = approaching();
  still["keys"][1]["pose"] = poseAtZ(30);
  const json sensor{{"type", "mid-40"}, {"range-noise", 0}, {"range-resolution", 0}, {"rated-range", nullptr}};
  ASSERT_EQ(scan(folder, still, {{"sensor", sensor}}).code, 0);
  std::vector<std::vector<Point>> scans;
  for (int i = 0; i < 2; ++i) scans.push_back(pointsIn(folder.read(fmt::format("set/lidar/{:06}.ply", i))));
  for (const std::vector<Point>& points : scans) {
    ASSERT_EQ(points.size(), 10'000u);
    for (const Point& p : points) EXPECT_LT(std::acos(std::min(p.x / p.range, 1.f)) * 180 / M_PI, 19.21);
  }
  size_t apart = 0;
  for (size_t i = 0; i < scans[0].size(); ++i)
    apart += std::hypot(scans[0][i].y - scans[1][i].y, scans[0][i].z - scans[1][i].z) > 1;
  EXPECT_GT(apart, 8'000u);
}

TEST(Lidar, WrongValuesAreNamed) {
  Folder folder;
  writeWall(folder);
  const auto wrong = [&](const json& format) {
    const Outcome outcome = scan(folder, standing(12), format);
    EXPECT_EQ(outcome.code, 2) << format;
    EXPECT_FALSE(std::filesystem::exists(folder.at("set")));
    return outcome.err;
  };
  EXPECT_THAT(wrong({}), HasSubstr("the format lidar needs a \"sensor\""));
  EXPECT_THAT(wrong({{"sensor", 3}}), HasSubstr("sensor takes the name of a sensor, or an object"));
  EXPECT_THAT(wrong({{"sensor", "vlp-17"}}), HasSubstr("no sensor \"vlp-17\"; there are: vlp-16, hdl-32e"));
  EXPECT_THAT(wrong({{"sensor", {{"type", "vlp-16"}, {"ratee", 5}}}}), HasSubstr("sensor"));
  EXPECT_THAT(wrong({{"sensor", {{"type", "vlp-16"}, {"rate", 0}}}}), HasSubstr("sensor.rate must be a number from"));
  EXPECT_THAT(wrong({{"sensor", {{"type", "spinning"}, {"elevations", {1}}, {"rate", 10}}}}),
              HasSubstr("sensor needs one of \"azimuth-step\", \"columns\" and \"cycle\""));
  EXPECT_THAT(wrong({{"sensor", {{"type", "rosette"}, {"rate", 10}}}}), HasSubstr("sensor needs \"cone\""));
  EXPECT_THAT(wrong({{"sensor", {{"type", "spinning"}, {"elevations", {1}}, {"rate", 10}, {"cycle", 1e-9}}}}),
              HasSubstr("a scan has at most 10000000 firings"));
  EXPECT_THAT(wrong({{"sensor", kExact}, {"samples", 0}}), HasSubstr("samples of the format lidar takes a number"));
  EXPECT_THAT(wrong({{"sensor", kExact}, {"samples", 1.5}}), HasSubstr("takes a whole number, not 1.5"));
  EXPECT_THAT(wrong({{"sensor", kExact}, {"returns", "weakest"}}),
              HasSubstr("returns must be one of strongest, first"));
  EXPECT_THAT(wrong({{"sensor", kExact}, {"as", "las"}}), HasSubstr("one of ply, pcd, bin, npz"));
  EXPECT_THAT(wrong({{"sensor", kExact}, {"mount", {{"translation", {1, 2}}}}}), HasSubstr("mount.translation"));
  EXPECT_THAT(wrong({{"sensor", kExact}, {"sample", 3}}), HasSubstr("has no option \"sample\""));
}

}  // namespace
}  // namespace latelight::data
