// Draws the contact sheet: scaling, labels and layout.
#include <stb/stb_easy_font.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "output/debug.h"
#include "output/srgb.h"

namespace latelight::output {
namespace {

constexpr uint8_t kPaper[4] = {24, 24, 26, 255};
constexpr uint8_t kInk[4] = {236, 236, 232, 255};
constexpr uint32_t kGap = 12;
constexpr uint32_t kLetterScale = 2;                  // scale of the font's letters, which are 7 pixels high
constexpr uint32_t kLabelHeight = 12 * kLetterScale;  // height of a line of the font

// Linear, premultiplied color, as averaging requires.
struct Sum {
  double r = 0, g = 0, b = 0, a = 0;
};

void add(Sum& sum, const uint8_t* pixel, double weight) {
  const auto& linear = linearOfSrgb8();
  const double alpha = weight * pixel[3] / 255.0;
  sum.r += alpha * linear[pixel[0]];
  sum.g += alpha * linear[pixel[1]];
  sum.b += alpha * linear[pixel[2]];
  sum.a += alpha;
}

// Averages over [x0, x1) x [y0, y1); partially covered pixels are weighted by their covered share.
Sum average(const Picture& from, double x0, double x1, double y0, double y1) {
  Sum sum;
  for (auto y = static_cast<uint32_t>(y0); y < std::min<double>(std::ceil(y1), from.height); ++y) {
    const double wy = std::min(y1, y + 1.0) - std::max(y0, double{1} * y);
    for (auto x = static_cast<uint32_t>(x0); x < std::min<double>(std::ceil(x1), from.width); ++x) {
      const double wx = std::min(x1, x + 1.0) - std::max(x0, double{1} * x);
      add(sum, &from.rgba[(size_t{y} * from.width + x) * 4], wx * wy);
    }
  }
  const double area = (x1 - x0) * (y1 - y0);
  return {sum.r / area, sum.g / area, sum.b / area, sum.a / area};
}

uint32_t scaledTo(uint32_t size, double scale) {
  return std::max(1u, static_cast<uint32_t>(std::lround(size * scale)));
}

// Composites the image over the sheet's background, so that transparent areas look like the sheet.
void drawScaled(Picture& sheet, const Picture& from, uint32_t left, uint32_t top, double scale) {
  const uint32_t width = scaledTo(from.width, scale), height = scaledTo(from.height, scale);
  const double stepX = static_cast<double>(from.width) / width, stepY = static_cast<double>(from.height) / height;
  parallelFor(height, 16, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      uint8_t* out = &sheet.rgba[((top + y) * sheet.width + left) * 4];
      for (uint32_t x = 0; x < width; ++x, out += 4) {
        const Sum sum = average(from, x * stepX, (x + 1) * stepX, static_cast<double>(y) * stepY,
                                static_cast<double>(y + 1) * stepY);
        const double values[3] = {sum.r, sum.g, sum.b};
        for (size_t c = 0; c < 3; ++c) {
          out[c] = srgb8(static_cast<float>(values[c] + (1 - sum.a) * linearOfSrgb8()[kPaper[c]]));
        }
      }
    }
  });
}

struct Vertex {  // in the format that stb_easy_font writes
  float x, y, z;
  uint8_t color[4];
};

// The font consists of axis-aligned rectangles with integer corners, so integer scales do not blur it.
void drawText(Picture& sheet, std::string text, uint32_t left, uint32_t top, uint32_t widest) {
  std::vector<Vertex> vertices(text.size() * 32 + 64);
  const int quads = stb_easy_font_print(0, 0, text.data(), nullptr, vertices.data(),
                                        static_cast<int>(vertices.size() * sizeof(Vertex)));
  for (int quad = 0; quad < quads; ++quad) {
    const Vertex& from = vertices[static_cast<size_t>(quad) * 4];
    const Vertex& to = vertices[static_cast<size_t>(quad) * 4 + 2];
    const auto x1 = std::min(static_cast<uint32_t>(to.x) * kLetterScale, widest);
    for (auto y = static_cast<uint32_t>(from.y) * kLetterScale; y < static_cast<uint32_t>(to.y) * kLetterScale; ++y) {
      for (auto x = static_cast<uint32_t>(from.x) * kLetterScale; x < x1; ++x) {
        std::copy_n(kInk, 4, &sheet.rgba[((size_t{top} + y) * sheet.width + left + x) * 4]);
      }
    }
  }
}

// Breaks the text at spaces into lines no wider than `widest`.
std::vector<std::string> wrap(std::string text, uint32_t widest) {
  for (char& c : text) c = c < 0x20 || c > 0x7e ? '?' : c;  // the font has only these letters, and does not check
  const auto width = [](std::string line) {
    return static_cast<uint32_t>(stb_easy_font_width(line.data())) * kLetterScale;
  };
  std::vector<std::string> lines{""};
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::string longer = lines.back().empty() ? word : lines.back() + " " + word;
    if (lines.back().empty() || width(longer) <= widest)
      lines.back() = longer;
    else
      lines.push_back(word);
    begin = end + 1;
  }
  return lines;
}

}  // namespace

Picture contactSheet(std::span<const Labelled> pictures, uint32_t columns, uint32_t cellWidth) {
  if (pictures.empty()) badUsage("a contact sheet needs at least one image");
  assert(columns > 0 && cellWidth > 0);
  columns = std::min(columns, static_cast<uint32_t>(pictures.size()));
  const uint32_t rows = (static_cast<uint32_t>(pictures.size()) + columns - 1) / columns;
  uint32_t widest = 0, tallest = 0;
  const auto scaleOf = [&](const Picture& picture) { return std::min(1.0, double{1} * cellWidth / picture.width); };
  for (const Labelled& labelled : pictures) {
    const double scale = scaleOf(labelled.picture);
    widest = std::max(widest, scaledTo(labelled.picture.width, scale));
    tallest = std::max(tallest, scaledTo(labelled.picture.height, scale));
  }
  std::vector<std::vector<std::string>> labels;
  std::vector<uint32_t> tops(rows + 1, kGap);  // top of each row, then the end of the sheet
  for (uint32_t i = 0; i < pictures.size(); ++i) {
    labels.push_back(wrap(pictures[i].label, widest));
    uint32_t& next = tops[i / columns + 1];
    next = std::max(next, tops[i / columns] + tallest + kLabelHeight * static_cast<uint32_t>(labels[i].size()) + kGap);
  }
  Picture sheet{kGap + columns * (widest + kGap), tops.back(), {}};
  sheet.rgba.resize(size_t{sheet.width} * sheet.height * 4);
  for (size_t i = 0; i < sheet.rgba.size(); ++i) sheet.rgba[i] = kPaper[i % 4];
  for (uint32_t i = 0; i < pictures.size(); ++i) {
    const uint32_t left = kGap + i % columns * (widest + kGap), top = tops[i / columns];
    drawScaled(sheet, pictures[i].picture, left, top, scaleOf(pictures[i].picture));
    for (uint32_t line = 0; line < labels[i].size(); ++line)
      drawText(sheet, labels[i][line], left, top + tallest + kLabelHeight / 4 + line * kLabelHeight, widest);
  }
  return sheet;
}

}  // namespace latelight::output
