#include <algorithm>
#include <bit>
#include <initializer_list>
#include <spirv/unified1/spirv.hpp>
#include <sstream>
#include <string>

#include "base/files.h"
#include "fuzz/seeds/seeds.h"

namespace latelight::fuzz {

namespace {

using namespace std::string_literals;

void addJobs(Seeds& seeds) {
  seeds.add("job",
            "\1scenes: builtin:hall\noutput: hall\nname: \"{camera}\"\nformats:\n  - format: files\n"
            "    outputs: [color, depth, id]\noptions:\n  size: 320x240\n  sun: 30,40\n"s);
  seeds.add("job",
            "\1a: &x [1, 2.5, ~, true, 'text', \"quoted\\n\"]\nb: *x\nc: {d: !!str 7, e: 0x1F, f: .inf}\n"
            "g: |\n  lines\n  of text\n---\n"s);
  seeds.add("job",
            "\0{\"scenes\": [\"a.glb\"], \"output\": \"out\", \"seed\": 7, \"repeat\": 2, \"cameras\": [{\"type\": "
            "\"orbit\", \"count\": 3, \"azimuth\": [0, 90]}, {\"type\": \"tum\", \"file\": \"t.txt\", \"K\": "
            "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]}], \"variations\": {\"lights\": {\"scale\": [0.5, 2]}}, "
            "\"options\": {\"exposure\": 1.5, \"size\": \"64x48\"}}"s);
}

std::string word(uint64_t value, size_t bytes) {
  std::string out;
  for (size_t i = 0; i < bytes; ++i) out += char(value >> (8 * i));
  return out;
}

// COLMAP's binary files: one camera with the model PINHOLE, and one image without points.
std::string colmapBinary() {
  const auto number = [](double value) { return word(std::bit_cast<uint64_t>(value), 8); };
  const std::string cameras = word(1, 8) + word(1, 4) + word(1, 4) + word(64, 8) + word(48, 8) + number(50) +
                              number(50) + number(32) + number(24);
  const std::string images = word(1, 8) + word(1, 4) + number(1) + number(0) + number(0) + number(0) + number(1) +
                             number(2) + number(3) + word(1, 4) + "a.png"s + '\0' + word(0, 8);
  return cameras + '\xff' + images;
}

void addCameraFiles(Seeds& seeds) {
  seeds.add("camera_file",
            "\0# cameras\n1 PINHOLE 64 48 50 50 32 24\n2 OPENCV 64 48 50 50 32 24 0.1 0.01 0 0\n\xff"
            "1 1 0 0 0 1 2 3 1 a.png\n\n2 0.5 0.5 0.5 0.5 0 0 0 2 b.png\n1.5 2.5 -1\n"s);
  seeds.add("camera_file", "\0"s +
                               "1 SIMPLE_RADIAL 64 48 50 32 24 0.1\n2 FULL_OPENCV 9 9 5 5 4 4 0 0 0 0 0 0 0 0\n"
                               "3 OPENCV_FISHEYE 9 9 5 5 4 4 0 0 0 0\n\xff");
  seeds.add("camera_file", "\1"s + colmapBinary());
  seeds.add("camera_file",
            "\2# time tx ty tz qx qy qz qw\n1305031102.1758 1.34 0.63 1.66 0.66 0.62 -0.29 -0.31\n"
            "1305031102.2758 1 2 3 0 0 0 1\n"s);
  seeds.add("camera_file",
            "\3{\"0\": {\"cam_K\": [525, 0, 320, 0, 525, 240, 0, 0, 1], \"cam_R_w2c\": [1, 0, 0, 0, 1, 0, 0,"
            " 0, 1], \"cam_t_w2c\": [0, 0, 900], \"depth_scale\": 0.1}}"s);
  seeds.add("camera_file",
            "\4{\"camera_model\": \"OPENCV\", \"w\": 64, \"h\": 48, \"fl_x\": 50, \"cx\": 32, \"k1\": 0.1, "
            "\"frames\": [{\"file_path\": \"a.png\", \"transform_matrix\": [[1, 0, 0, 7], [0, 1, 0, 8], "
            "[0, 0, 1, 9], [0, 0, 0, 1]]}]}"s);
  seeds.add("camera_file",
            "\4{\"camera_angle_x\": 0.7, \"frames\": [{\"file_path\": \"r_0\", \"transform_matrix\": "
            "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]}]}"s);
}

// One seed per option, and some command lines.
void addCommandLines(Seeds& seeds) {
#define OPTION_FLAG(member, name, ...) seeds.add("command_line", name##s);
#define OPTION_NUMBER(Type, member, name, defaultValue, ...) seeds.add("command_line", name + "\0" #defaultValue ""s);
#define OPTION_ANGLE(member, name, ...) \
  seeds.add("command_line", name        \
            "\0"                        \
            "45"s);
#define OPTION_OPTIONAL(Type, member, name, ...) \
  seeds.add("command_line", name                 \
            "\0"                                 \
            "1"s);
#define OPTION_CHOICE(Enum, member, name, ...) seeds.add("command_line", name "\0none"s);
#define OPTION_NAME(value, name, ...) seeds.add("command_line", name##s);
#define OPTION_TEXT(Type, member, name, ...) \
  seeds.add("command_line", name             \
            "\0"                             \
            "1,0.5,0"s);
#define OPTION_SUN(member, name, ...) \
  seeds.add("command_line", name      \
            "\0"                      \
            "30,40,1000"s);
#define OPTION_EXPOSURE(member, name, ...) \
  seeds.add("command_line", name           \
            "\0"                           \
            "auto+0.5"s);
#include <latelight/options.def>
  seeds.add("command_line",
            "builtin:boxes\0-o\0out.png\0--size\0"
            "64x48\0--aa\0ssaa2\0--aov\0depth,normal"s);
  seeds.add("command_line", "a.glb\0--size=1920x1080\0--layout\0plain\0--technique=tiled\0--background\0#a0b0c0"s);
  // Other forms of values, values out of range, and options that exclude each other.
  for (const std::string options : {"--aa ss9",
                                    "--aa ss0",
                                    "--aa msaa3",
                                    "--aa msaa4,ss2",
                                    "--aa msaa4 --shadows rays",
                                    "--aa msaa4 --indirect one-bounce",
                                    "--aa msaa4 --lighting reference",
                                    "--aa msaa4 --ground studio",
                                    "--aa msaa8 --lighting forward",
                                    "--aa msaa8 --raster hardware",
                                    "--lighting forward --indirect one-bounce",
                                    "--lighting forward --shadows rays",
                                    "--layout visibility --lighting forward",
                                    "--layout visibility --raster hardware",
                                    "--aperture-blades 2",
                                    "--background 2,0,0",
                                    "--background #12",
                                    "--size 0x0",
                                    "--size 64",
                                    "--sun 30",
                                    "--sun 30,40,-1",
                                    "--sun 30,40,x",
                                    "--exposure 100",
                                    "--exposure auto+100",
                                    "--exposure bright",
                                    "--vignetting cos4",
                                    "--vignetting 20",
                                    "--vignetting 0.1,0.2,0.3",
                                    "--response gamma:2.2",
                                    "--response gamma:0",
                                    "--response 0,0.5,1",
                                    "--response 0.5,x",
                                    "--shadow-lights none",
                                    "--shadow-lights 4",
                                    "--shadow-lights sun,lamp",
                                    "--position-origin 1,2",
                                    "--position-origin 1,2,3",
                                    "--pick 3,4",
                                    "--light-position lamp=1,2,3"}) {
    std::string line = "builtin:boxes -o out.png " + options;
    std::ranges::replace(line, ' ', '\0');
    seeds.add("command_line", line);
  }
}

void addServe(Seeds& seeds) {
  const std::string token = "0123456789abcdef0123456789abcdef";
  for (const std::string& path : {"/" + token + "/", "/" + token + "/socket", "/"s})
    for (const char* const host : {"localhost:8765", "[::1]:8765", "render.example", "evil.example"})
      seeds.add("serve_request", "GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\nOrigin: http://" + host +
                                     "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\r\n");
  const auto message = [](bool isText, const std::string& text) {
    return word(isText, 1) + word(text.size(), 2) + text;
  };
  for (const char* text : {R"({"type":"shown","number":3})",
                           R"({"type":"screenshot","side":"right","serial":7})",
                           R"({"type":"resize","width":64,"height":48})",
                           R"({"type":"move","x":1.5,"y":2})",
                           R"({"type":"leave"})",
                           R"({"type":"button","button":"left","down":true,"shift":true})",
                           R"({"type":"wheel","steps":-1})",
                           R"({"type":"key","name":"P","down":true})",
                           R"({"type":"blur"})",
                           R"({"type":"option","name":"exposure","value":"2","side":"left"})",
                           R"({"type":"output","name":"depth"})",
                           R"({"type":"split","mode":"divider","at":0.5})",
                           R"({"type":"camera","name":"front"})",
                           R"({"type":"environment","name":"studio"})",
                           R"({"type":"navigation","mode":"fly"})",
                           R"({"type":"play","on":true})",
                           R"({"type":"variant","name":"a"})",
                           R"({"type":"lights","on":true})",
                           R"({"type":"moveLight","light":1,"position":[1,2,3]})",
                           R"({"type":"dragLight","light":1,"x":2,"y":3})",
                           R"({"type":"nudgeLight","light":1,"dx":2,"dy":3})",
                           R"({"type":"reload"})"})
    seeds.add("serve_message", message(true, text));
  seeds.add("serve_message", message(true, R"({"type":"file","name":"a.hdr","bytes":6})") + message(false, "abc") +
                                 message(false, "def") + message(true, R"({"type":"leave"})"));
  const std::string mask = "mask";
  seeds.add("serve_frames", "\x81\x84"s + mask + "\0\0\0\0"s);                                          // a text
  seeds.add("serve_frames", "\x02\x81"s + mask + "x" + "\x89\x80"s + mask + "\x80\x81"s + mask + "y");  // with a ping
  seeds.add("serve_frames", "\x82\xfe\0\x80"s + mask + std::string(128, 'x') + "\x88\x82"s + mask + "\x6e\x89");
  seeds.add("serve_frames", "\x82\xff\0\0\0\0\0\1\0\0"s + mask + std::string(64, 'x'));
}

// A module with each kind of specialization constant, each operation on them that is folded, a push constant block, and
// a function whose branches, phis and switch depend on them.
std::string specializedModule() {
  std::string words;
  const auto put = [&words](std::initializer_list<uint32_t> instruction) {
    auto operand = instruction.begin();
    words += word(uint32_t(instruction.size()) << spv::WordCountShift | *operand, 4);
    while (++operand != instruction.end()) words += word(*operand, 4);
  };
  for (const uint32_t header : {spv::MagicNumber, 0x10600u, 0u, 200u, 0u}) words += word(header, 4);
  put({spv::OpEntryPoint, spv::ExecutionModelGLCompute, 100, 0});
  put({spv::OpDecorate, 10, spv::DecorationSpecId, 0});
  put({spv::OpDecorate, 11, spv::DecorationSpecId, 1});
  put({spv::OpDecorate, 13, spv::DecorationSpecId, 1});
  put({spv::OpMemberDecorate, 20, 0, spv::DecorationOffset, 12});
  put({spv::OpTypeBool, 1});
  put({spv::OpTypeInt, 2, 32, 0});
  put({spv::OpTypeInt, 3, 64, 0});
  put({spv::OpSpecConstantTrue, 1, 10});
  put({spv::OpSpecConstant, 2, 11, 5});
  put({spv::OpConstant, 2, 12, 3});
  put({spv::OpSpecConstantFalse, 1, 13});
  put({spv::OpSpecConstantComposite, 2, 14, 11, 12});
  uint32_t id = 30;
  for (const uint32_t op : {spv::OpIAdd,
                            spv::OpISub,
                            spv::OpIMul,
                            spv::OpUDiv,
                            spv::OpSDiv,
                            spv::OpUMod,
                            spv::OpLogicalOr,
                            spv::OpLogicalAnd,
                            spv::OpLogicalEqual,
                            spv::OpLogicalNotEqual,
                            spv::OpIEqual,
                            spv::OpINotEqual,
                            spv::OpUGreaterThan,
                            spv::OpUGreaterThanEqual,
                            spv::OpULessThan,
                            spv::OpULessThanEqual,
                            spv::OpSGreaterThan,
                            spv::OpSGreaterThanEqual,
                            spv::OpSLessThan,
                            spv::OpSLessThanEqual,
                            spv::OpShiftLeftLogical,
                            spv::OpShiftRightLogical,
                            spv::OpShiftRightArithmetic,
                            spv::OpBitwiseAnd,
                            spv::OpBitwiseOr,
                            spv::OpBitwiseXor})
    put({spv::OpSpecConstantOp, 2, id++, op, 11, 12});
  put({spv::OpSpecConstantOp, 2, id++, spv::OpNot, 11});
  put({spv::OpSpecConstantOp, 3, id++, spv::OpUConvert, 11});
  put({spv::OpSpecConstantOp, 1, id++, spv::OpLogicalNot, 10});
  put({spv::OpSpecConstantOp, 2, id++, spv::OpSelect, 10, 11, 12});
  put({spv::OpTypeStruct, 20, 2});
  put({spv::OpTypePointer, 21, spv::StorageClassPushConstant, 20});
  put({spv::OpVariable, 21, 22, spv::StorageClassPushConstant});
  put({spv::OpFunction, 2, 100, 0, 101});
  put({spv::OpLabel, 102});
  put({spv::OpSelectionMerge, 104, 0});
  put({spv::OpBranchConditional, 10, 103, 104});
  put({spv::OpLabel, 103});
  put({spv::OpBranch, 104});
  put({spv::OpLabel, 104});
  put({spv::OpPhi, 2, 110, 11, 103, 12, 102});
  put({spv::OpIAdd, 2, 111, 110, 12});
  put({spv::OpSelectionMerge, 106, 0});
  put({spv::OpSwitch, 110, 106, 5, 105, 7, 105});
  put({spv::OpLabel, 105});
  put({spv::OpBranch, 106});
  put({spv::OpLabel, 106});
  put({spv::OpBranch, 107});
  put({spv::OpLabel, 107});  // a loop that does not repeat
  put({spv::OpPhi, 2, 112, 111, 106, 112, 108});
  put({spv::OpLoopMerge, 109, 108, 0});
  put({spv::OpBranchConditional, 13, 108, 109});
  put({spv::OpLabel, 108});
  put({spv::OpBranch, 107});
  put({spv::OpLabel, 109});
  put({spv::OpReturnValue, 112});
  put({spv::OpFunctionEnd});
  return words;
}

void addShaders(Seeds& seeds) {
  seeds.add("shader", specializedModule());
  std::istringstream files(LATELIGHT_SEED_SHADERS);
  for (std::string file; std::getline(files, file, ',');) seeds.add("shader", readFile(file));
}

}  // namespace

void addTexts(Seeds& seeds) {
  addJobs(seeds);
  addCameraFiles(seeds);
  addCommandLines(seeds);
  addServe(seeds);
  addShaders(seeds);
}

}  // namespace latelight::fuzz
