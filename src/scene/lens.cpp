// Projection and distortion models of calibrated lenses, in double precision. Distortion is inverted by bisection and
// Newton's method, within the range where its polynomial is monotonic.
#include "scene/lens.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <iterator>
#include <limits>
#include <span>
#include <vector>

#include "base/error.h"
#include "base/text.h"
#include "scene/lens_range.h"

namespace latelight::scene {

namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kNoTurningPoint = std::numeric_limits<double>::infinity();
constexpr double kPi = glm::pi<double>();

constexpr LensModelInfo kModels[] = {
    {LensModel::Pinhole, "pinhole", 0, true},  {LensModel::OpenCv, "opencv", 8, true},
    {LensModel::Fisheye, "fisheye", 4, true},  {LensModel::Equirectangular, "equirectangular", 0, false},
    {LensModel::CubeMap, "cubemap", 0, false}, {LensModel::FTheta, "ftheta", 6, true},
};

// --- polynomials ----------------------------------------------------------------------------------------------------

// Polynomials are stored as coefficients, the lowest power first.
double valueOf(std::span<const double> p, double x) {
  double sum = 0;
  for (size_t i = p.size(); i-- > 0;) sum = sum * x + p[i];
  return sum;
}

double slopeOf(std::span<const double> p, double x) {
  double sum = 0;
  for (size_t i = p.size(); i-- > 1;) sum = sum * x + static_cast<double>(i) * p[i];
  return sum;
}

std::vector<double> derivativeOf(std::span<const double> p) {
  std::vector<double> d;
  for (size_t i = 1; i < p.size(); ++i) d.push_back(static_cast<double>(i) * p[i]);
  return d;
}

std::vector<double> product(std::span<const double> a, std::span<const double> b) {
  std::vector<double> p(a.size() + b.size() - 1);
  for (size_t i = 0; i < a.size(); ++i)
    for (size_t j = 0; j < b.size(); ++j) p[i + j] += a[i] * b[j];
  return p;
}

// Returns the point where a function that increases from `low` to `high` crosses zero, by bisection.
template <typename F>
double solveBetween(const F& excess, double low, double high) {
  for (double middle = 0.5 * (low + high); low < middle && middle < high; middle = 0.5 * (low + high))
    (excess(middle) > 0 ? high : low) = middle;
  return high;
}

// Returns the positive roots in ascending order. Between the roots of its derivative, a polynomial is monotonic.
std::vector<double> positiveRoots(std::vector<double> p) {
  while (!p.empty() && p.back() == 0) p.pop_back();
  if (p.size() < 2) return {};
  double bound = 0;  // Cauchy's bound
  for (const double c : p) bound = std::max(bound, std::abs(c / p.back()));
  std::vector<double> turns = positiveRoots(derivativeOf(p)), roots;
  turns.push_back(1 + bound);
  double low = 0;
  for (const double high : turns) {
    const double sign = valueOf(p, high) > 0 ? 1 : -1;
    if (valueOf(p, low) * sign < 0)
      roots.push_back(solveBetween([&](double x) { return sign * valueOf(p, x); }, low, high));
    low = high;
  }
  return roots;
}

double firstPositiveRoot(std::span<const double> p) {
  const std::vector<double> roots = positiveRoots({p.begin(), p.end()});
  return roots.empty() ? kNoTurningPoint : roots.front();
}

// --- distortion -----------------------------------------------------------------------------------------------------

// OpenCV's radial distortion as a function of r^2 at 1 m: (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6
// r^6).
struct Radial {
  std::array<double, 4> above, below;
  explicit Radial(const Lens& lens)
      : above{1, lens.distortion[0], lens.distortion[1], lens.distortion[4]},
        below{1, lens.distortion[5], lens.distortion[6], lens.distortion[7]} {}
  double at(double r2) const { return valueOf(above, r2) / valueOf(below, r2); }
  // Returns the distorted radius, which may rise to infinity at the first pole. It is infinite beyond a pole, because
  // turn() is rounded up, and r^2 may be past it.
  double radius(double r) const { return valueOf(below, r * r) > 0 ? r * at(r * r) : kNoTurningPoint; }
  double slope(double r2) const {
    const double b = valueOf(below, r2);
    return (slopeOf(above, r2) * b - valueOf(above, r2) * slopeOf(below, r2)) / (b * b);
  }
  // Returns the maximum r^2 up to which r times the distortion increases. The derivative's numerator is above below + 2
  // r^2 (above' below - above below').
  double turn() const {
    std::vector<double> sum = product(above, below);
    const std::vector<double> rises = product(derivativeOf(above), below), falls = product(above, derivativeOf(below));
    for (size_t i = 0; i < rises.size(); ++i) sum[i + 1] += 2 * (rises[i] - falls[i]);
    return std::min(firstPositiveRoot(sum), firstPositiveRoot(below));
  }
};

// Fisheye distortion (Kannala and Brandt 2006, A Generic Camera Model and Calibration Method for Conventional,
// Wide-Angle, and Fish-Eye Lenses, PAMI 28(8)) as in OpenCV: theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4
// theta^8).
std::array<double, 5> fisheyeOf(const Lens& lens) {
  const std::array<double, 8>& d = lens.distortion;
  return {1, d[0], d[1], d[2], d[3]};
}
double bent(const Lens& lens, double theta) {
  return theta * valueOf(fisheyeOf(lens), theta * theta);
}

double fisheyeTurn(const Lens& lens) {
  std::array<double, 5> slope = fisheyeOf(lens);
  for (size_t i = 0; i < slope.size(); ++i) slope[i] *= static_cast<double>(2 * i + 1);
  return std::min(kPi, std::sqrt(firstPositiveRoot(slope)));
}

// The f-theta polynomial as NVIDIA's DRIVE and Omniverse define it, from distance to angle: theta = k0 + k1 r + k2 r^2
// +
// ... + k5 r^5. fthetaTurn() returns the distance up to which the angle increases, and is at most 180 degrees.
double anglePolynomial(const Lens& lens, double r) {
  return valueOf(std::span(lens.distortion).first(6), r);
}

double fthetaTurn(const Lens& lens) {
  const std::vector<double> angle(lens.distortion.begin(), lens.distortion.begin() + 6);
  std::vector<double> beyond = angle;
  beyond[0] -= kPi;
  const double turn = firstPositiveRoot(derivativeOf(angle)), end = firstPositiveRoot(beyond);
  return angle[1] > 0 ? std::min(turn, end) : 0;
}

struct Distorted {
  dvec2 at;
  dvec2 byX, byY;  // partial derivatives with respect to x and y
  double determinant() const { return byX.x * byY.y - byX.y * byY.x; }
};

Distorted distorted(const Lens& lens, const Radial& radial, dvec2 p) {
  const double p1 = lens.distortion[2], p2 = lens.distortion[3];
  const double r2 = glm::dot(p, p), scale = radial.at(r2), slope = radial.slope(r2);
  Distorted d;
  d.at =
      p * scale + dvec2(2 * p1 * p.x * p.y + p2 * (r2 + 2 * p.x * p.x), p1 * (r2 + 2 * p.y * p.y) + 2 * p2 * p.x * p.y);
  const double mixed = 2 * slope * p.x * p.y + 2 * p1 * p.x + 2 * p2 * p.y;
  d.byX = {scale + 2 * slope * p.x * p.x + 2 * p1 * p.y + 6 * p2 * p.x, mixed};
  d.byY = {mixed, scale + 2 * slope * p.y * p.y + 6 * p1 * p.y + 2 * p2 * p.x};
  return d;
}

// Returns the undistorted radius of a point at this distance from the axis, without tangential distortion.
double undistortedRadius(const Radial& radial, double most, double target) {
  const double end = std::isfinite(most) ? std::sqrt(most) : kNoTurningPoint;
  if (std::isfinite(end) && !(radial.radius(end) > target)) return end;
  double high = std::min(end, std::max(target, 1e-6));
  while (high < end && radial.radius(high) < target && high < 1e9) high *= 2;
  high = std::min(high, end);
  double low = 0, r = std::min(target, 0.5 * end);
  for (int i = 0; i < 100 && low < high; ++i) {
    const double excess = radial.radius(r) - target;
    (excess > 0 ? high : low) = r;
    const double slope = radial.at(r * r) + 2 * r * r * radial.slope(r * r), next = r - excess / slope;
    const double stepped = next > low && next < high ? next : 0.5 * (low + high);
    // Close to a pole, Newton's method only doubles the distance to it: the first steps are tiny, far from the
    // solution.
    if (std::abs(stepped - r) <= 1e-15 * r && std::abs(excess) <= target) break;
    r = stepped;
  }
  return r;
}

// Refines the result of undistortedRadius() by Newton's method with step halving, including tangential distortion.
// Returns nullopt if it does not converge within the monotonic range.
std::optional<dvec2> undistorted(const Lens& lens, const Radial& radial, double most, dvec2 target) {
  const double length = glm::length(target);
  if (length == 0 && lens.distortion[2] == 0 && lens.distortion[3] == 0) return target;
  dvec2 p = length > 0 ? target * (undistortedRadius(radial, most, length) / length) : target;
  Distorted d = distorted(lens, radial, p);
  double remaining = std::numeric_limits<double>::infinity();  // length of the last full step
  for (int i = 0; i < 50; ++i) {
    const dvec2 miss = target - d.at;
    const double determinant = d.determinant();
    if (!(determinant > 0)) return std::nullopt;
    dvec2 step = dvec2(d.byY.y * miss.x - d.byY.x * miss.y, d.byX.x * miss.y - d.byX.y * miss.x) / determinant;
    remaining = glm::length(step);
    if (remaining <= 1e-15 * glm::length(p)) break;
    Distorted next = distorted(lens, radial, p + step);
    for (int half = 0; half < 40 && !(glm::length(target - next.at) < glm::length(miss)); ++half) {
      step *= 0.5;
      next = distorted(lens, radial, p + step);
    }
    if (!(glm::length(target - next.at) < glm::length(miss))) break;  // the limit of double precision
    p += step;
    d = next;
  }
  // Close to a pole, the distorted point of the best double may be far from the target.
  const bool arrived = glm::length(target - d.at) <= 1e-12 * (1 + length) || remaining <= 1e-12 * glm::length(p);
  if (!arrived || !(glm::dot(p, p) < most) || !(d.determinant() > 0)) return std::nullopt;
  return p;
}

std::optional<double> unbent(const Lens& lens, double most, double target) {
  if (target > bent(lens, most)) return std::nullopt;
  const std::array<double, 5> p = fisheyeOf(lens);
  double low = 0, high = most, theta = std::min(target, most);
  for (int i = 0; i < 60; ++i) {
    const double excess = bent(lens, theta) - target, t2 = theta * theta;
    (excess > 0 ? high : low) = theta;
    const double slope = valueOf(p, t2) + 2 * t2 * slopeOf(p, t2), next = theta - excess / slope;
    const double stepped = next > low && next < high ? next : 0.5 * (low + high);
    if (std::abs(stepped - theta) <= 1e-15 * theta) break;
    theta = stepped;
  }
  return theta;
}

// The distance at which the f-theta polynomial reaches an angle.
std::optional<double> distanceAt(const Lens& lens, double most, double theta) {
  const double end = std::isfinite(most) ? most : 1e9;
  if (theta < anglePolynomial(lens, 0) || theta > anglePolynomial(lens, end)) return std::nullopt;
  return solveBetween([&](double r) { return anglePolynomial(lens, r) - theta; }, 0, end);
}

// --- cube maps ------------------------------------------------------------------------------------------------------

// The right, down and forward axes of each face's image, relative to the camera. The side, top and bottom faces are a
// quarter turn from straight ahead; the last two are straight ahead and a half turn about the vertical.
constexpr dvec3 kFaces[6][3] = {
    {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}}, {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}}, {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
    {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},  {{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
};

double longest(dvec3 v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

// --- user input -----------------------------------------------------------------------------------------------------

const LensModelInfo& infoOf(LensModel model) {
  return kModels[static_cast<size_t>(model)];
}

const LensModelInfo* findLensModel(std::string_view name) {
  const auto* info = std::ranges::find_if(kModels, [&](const LensModelInfo& m) { return name == m.name; });
  return info == std::end(kModels) ? nullptr : info;
}

Lens parseLens(std::string_view option, std::string_view text, uint32_t width, uint32_t height) {
  const size_t colon = text.find(':');
  const std::string_view name = text.substr(0, colon);
  const LensModelInfo* info = findLensModel(name);
  if (!info)
    badUsage("{} takes pinhole, opencv, fisheye, ftheta, equirectangular or cubemap, not \"{}\"", option, name);
  Lens lens{.model = info->model, .width = double(width), .height = double(height)};
  std::vector<double> numbers;
  if (colon != std::string_view::npos) {
    for (const std::string_view part : splitAtCommas(text.substr(colon + 1))) {
      const std::optional<double> number = parseNumber<double>(part);
      if (!number) badUsage("{}: \"{}\" is not a number", option, part);
      numbers.push_back(*number);
    }
  }
  const size_t least = info->calibrated ? 4 : 0, most = least + info->coefficients;
  if (numbers.size() < least || numbers.size() > most) {
    if (!info->calibrated) badUsage("{}: {} takes no numbers", option, name);
    badUsage("{}: {} takes fx,fy,cx,cy{}, not {} numbers", option, name,
             most > least ? fmt::format(" and up to {} coefficients", info->coefficients) : "", numbers.size());
  }
  numbers.resize(12);
  if (info->calibrated) lens.fx = numbers[0], lens.fy = numbers[1], lens.cx = numbers[2], lens.cy = numbers[3];
  std::copy_n(numbers.begin() + 4, 8, lens.distortion.begin());
  checkLens(lens, width, height);
  return lens;
}

void checkLens(const Lens& lens, uint32_t width, uint32_t height) {
  const auto model = static_cast<size_t>(lens.model);
  if (model >= std::size(kModels)) badUsage("there is no lens model {}", model);
  const LensModelInfo& info = infoOf(lens.model);
  if (lens.model == LensModel::CubeMap && width != 6 * uint64_t{height})
    badUsage("a cube map is six squares side by side: its image must be six times as wide as high, not {}x{}", width,
             height);
  for (size_t i = info.coefficients; i < lens.distortion.size(); ++i)
    if (lens.distortion[i] != 0)
      badUsage("a lens of the model {} has {} distortion coefficients: number {} must be 0, not {}", info.name,
               info.coefficients == 0 ? "no" : std::to_string(info.coefficients), i + 1, lens.distortion[i]);
  if (!info.calibrated) return;
  if (!(lens.width > 0 && lens.height > 0 && std::isfinite(lens.width) && std::isfinite(lens.height)))
    badUsage("a lens of the model {} needs the image size of its calibration", info.name);
  const auto focal = [](double f) { return std::isfinite(f) && f > 0; };
  if (!focal(lens.fx) || !focal(lens.fy))
    badUsage("a lens's focal lengths must be above 0, not {:g} and {:g}", lens.fx, lens.fy);
  if (!std::isfinite(lens.cx) || !std::isfinite(lens.cy)) badUsage("a lens's principal point must be two numbers");
  for (const double k : lens.distortion)
    if (!std::isfinite(k)) badUsage("a lens's coefficients must be numbers");
  if (lens.model == LensModel::FTheta && !(lens.distortion[1] > 0))
    badUsage("an ftheta lens needs a coefficient k1 above 0, the angle per pixel at its center");
}

Lens scaledTo(const Lens& lens, uint32_t width, uint32_t height) {
  Lens scaled = lens;
  const double x = infoOf(lens.model).calibrated ? width / lens.width : 1;
  const double y = infoOf(lens.model).calibrated ? height / lens.height : 1;
  scaled.width = width, scaled.height = height;
  scaled.fx *= x, scaled.cx *= x;
  scaled.fy *= y, scaled.cy *= y;
  return scaled;
}

// --- projection between directions and pixels -----------------------------------------------------------------------

double turningPoint(const Lens& lens) {
  if (lens.model == LensModel::OpenCv) return Radial(lens).turn();
  if (lens.model == LensModel::Fisheye) return fisheyeTurn(lens);
  if (lens.model == LensModel::FTheta) return fthetaTurn(lens);
  return 0;
}

LensProjection::LensProjection(const Lens& lens) : lens_(lens), most_(turningPoint(lens)) {}

std::optional<dvec2> LensProjection::project(dvec3 v) const {
  const auto pixelAt = [&](dvec2 p) { return dvec2(lens_.fx * p.x + lens_.cx, lens_.fy * p.y + lens_.cy); };
  const double across = std::hypot(v.x, v.y);
  switch (lens_.model) {
    case LensModel::Pinhole:
      if (!(v.z > 0)) return std::nullopt;
      return pixelAt(dvec2(v) / v.z);
    case LensModel::OpenCv: {
      const dvec2 p = dvec2(v) / v.z;
      if (!(v.z > 0) || !(glm::dot(p, p) < most_)) return std::nullopt;
      const Distorted d = distorted(lens_, Radial(lens_), p);
      if (!(d.determinant() > 0)) return std::nullopt;
      return pixelAt(d.at);
    }
    case LensModel::Fisheye: {
      const double theta = std::atan2(across, v.z);
      if (!(theta <= most_)) return std::nullopt;
      return pixelAt(across > 0 ? dvec2(v) * (bent(lens_, theta) / across) : dvec2(0));
    }
    case LensModel::FTheta: {
      const std::optional<double> r = distanceAt(lens_, most_, std::atan2(across, v.z));
      if (!r) return std::nullopt;
      return pixelAt(across > 0 ? dvec2(v) * (*r / across) : dvec2(0));
    }
    case LensModel::Equirectangular:
      return dvec2((0.5 + std::atan2(v.x, v.z) / (2 * kPi)) * lens_.width,
                   (0.5 + std::atan2(v.y, std::hypot(v.x, v.z)) / kPi) * lens_.height);
    case LensModel::CubeMap:
      break;
  }
  int face = 0;
  while (glm::dot(kFaces[face][2], v) < longest(v)) ++face;
  const double away = glm::dot(kFaces[face][2], v);
  const dvec2 p(glm::dot(kFaces[face][0], v) / away, glm::dot(kFaces[face][1], v) / away);
  return dvec2((face + 0.5 + 0.5 * p.x) * lens_.width / 6, (0.5 + 0.5 * p.y) * lens_.height);
}

std::optional<dvec3> LensProjection::unproject(dvec2 pixel) const {
  const dvec2 p((pixel.x - lens_.cx) / lens_.fx, (pixel.y - lens_.cy) / lens_.fy);
  switch (lens_.model) {
    case LensModel::Pinhole:
      return glm::normalize(dvec3(p, 1));
    case LensModel::OpenCv: {
      const std::optional<dvec2> at = undistorted(lens_, Radial(lens_), most_, p);
      if (!at) return std::nullopt;
      return glm::normalize(dvec3(*at, 1));
    }
    case LensModel::Fisheye: {
      const double r = glm::length(p);
      const std::optional<double> theta = unbent(lens_, most_, r);
      if (!theta) return std::nullopt;
      return dvec3(r > 0 ? p * (std::sin(*theta) / r) : dvec2(0), std::cos(*theta));
    }
    case LensModel::FTheta: {
      const double r = glm::length(p), theta = anglePolynomial(lens_, r);
      if (!(r <= most_) || !(theta >= 0) || theta > kPi) return std::nullopt;
      // With k0 above 0 the principal point sees a cone. As in NVIDIA's implementations, its ray is the axis.
      if (r == 0) return dvec3(0, 0, 1);
      return dvec3(p * (std::sin(theta) / r), std::cos(theta));
    }
    case LensModel::Equirectangular: {
      const double longitude = (pixel.x / lens_.width - 0.5) * 2 * kPi, down = (pixel.y / lens_.height - 0.5) * kPi;
      return dvec3(std::cos(down) * std::sin(longitude), std::sin(down), std::cos(down) * std::cos(longitude));
    }
    case LensModel::CubeMap:
      break;
  }
  const double x = pixel.x / lens_.width * 6, face = std::clamp(std::floor(x), 0.0, 5.0);
  const auto& [right, down, away] = kFaces[static_cast<size_t>(face)];
  return glm::normalize(away + right * (2 * (x - face) - 1) + down * (2 * pixel.y / lens_.height - 1));
}

double LensProjection::depthOf(dvec3 direction) const {
  if (lens_.model == LensModel::Equirectangular) return 1;
  return lens_.model == LensModel::CubeMap ? longest(direction) : direction.z;
}

}  // namespace latelight::scene
