// Seeds of mesh files: each statement of OBJ and MTL, each encoding and property of PLY, and both encodings of STL.
#include <cstring>
#include <string>

#include "fuzz/seeds/seeds.h"

namespace latelight::fuzz {

namespace {

using namespace std::string_literals;

template <typename T>
void append(std::string& bytes, T value, bool bigEndian = false) {
  std::string raw(sizeof(T), '\0');
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes += bigEndian ? std::string(raw.rbegin(), raw.rend()) : raw;
}

std::string objWithMaterials() {
  return "mtllib m.mtl\no square\ng left right\ns 1\nusemtl red\n"
         "v 0 0 0 1 0.5 0\nv 1 0 0\nv 1 1 0\nv 0 1e0 -0.5\nvt 0 0\nvt 1 0 0\nvt 1 1\nvn 0 0 1\n"
         "f 1/1/1 2/2/1 3/3/1 4//1\nf -4 -3 \\\n-2\ns off\nusemtl glass\nf 1//1 2//1 3//1\np 1 2\nl 1 2 3\n"
         "\fnewmtl red\nKa 0 0 0\nKd 0.8 0.1 0.1\nKs 0.5 0.5 0.5\nKe 1 1 0\nNs 90\nNi 1.5\nd 0.5\nTr 0.5\nillum 2\n"
         "map_Kd -s 2 2 1 -o 0.1 0 0 -clamp on -bm 0.5 none.png\nbump none.png\nmap_d none.png\n"
         "newmtl glass\nPr 0.1\nPm 1\nPs 0.2\nPc 0.5\nPcr 0.1\nTf 1 0 0\nnorm none.png\nmap_Pr none.png\n"s;
}

std::string plyHeader(const char* format) {
  return "ply\nformat "s + format +
         " 1.0\ncomment seed\nelement vertex 3\nproperty float x\nproperty double y\nproperty float z\n"
         "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n"
         "property uchar blue\nproperty float s\nproperty float t\nelement face 1\n"
         "property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n";
}

std::string plyText() {
  return plyHeader("ascii") +
         "0 0 0 0 0 1 255 0 0 0 0\n1 0 0 0 0 1 0 255 0 1 0\n1 1 0 0 0 1 0 0 255 1 1\n3 0 1 2 6 0 0 1 0 1 1\n";
}

std::string plyBinary(bool bigEndian) {
  std::string bytes = plyHeader(bigEndian ? "binary_big_endian" : "binary_little_endian");
  for (int i = 0; i < 3; ++i) {
    append(bytes, i == 0 ? 0.0f : 1.0f, bigEndian);
    append(bytes, i == 2 ? 1.0 : 0.0, bigEndian);
    for (const float value : {0.0f, 0.0f, 0.0f, 1.0f}) append(bytes, value, bigEndian);
    bytes += "\x10\x20\x30";
    for (const float value : {0.5f, 0.25f}) append(bytes, value, bigEndian);
  }
  bytes += '\3';
  for (const int32_t index : {0, 1, 2}) append(bytes, index, bigEndian);
  bytes += '\6';
  for (int i = 0; i < 6; ++i) append(bytes, 0.5f, bigEndian);
  return bytes;
}

std::string stlBinary() {
  std::string bytes(80, 'x');
  append(bytes, uint32_t{1});
  for (const float value : {0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 1.0f, 1.0f, 0.0f})
    append(bytes, value);
  append(bytes, uint16_t{0x8123});
  return bytes;
}

}  // namespace

void addMeshFiles(Seeds& seeds) {
  seeds.add("mesh_file", "\0"s + objWithMaterials());
  seeds.add("mesh_file", "\1"s + plyText());
  seeds.add("mesh_file", "\1"s + plyBinary(false));
  seeds.add("mesh_file", "\1"s + plyBinary(true));
  seeds.add("mesh_file",
            "\1ply\nformat ascii 1.0\ncomment TextureFile none.png\nelement vertex 2\nproperty float x\n"
            "property float y\nproperty float z\nend_header\n0 0 0\n1 2 3\n"s);
  seeds.add("mesh_file", "\1"s + plyHeader("ascii").replace(0, 3, "ply\nelement tristrips 1\nproperty list int int v"));
  seeds.add("mesh_file",
            "\2solid name\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\n"
            "endfacet\nendsolid name\n"s);
  seeds.add("mesh_file", "\2"s + stlBinary());
}

}  // namespace latelight::fuzz
