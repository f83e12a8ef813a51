// Molding profiles, their sweeps along paths and polygons, and their simplification at low detail.
#include "scene/builtin/profile.h"

#include <algorithm>
#include <memory>

namespace latelight::scene::builtin {
namespace {

constexpr double kTangentStep = 1e-5;

dvec2 derivative(const std::function<dvec2(double)>& at, double t) {
  const double a = std::max(0.0, t - kTangentStep), b = std::min(1.0, t + kTangentStep);
  return (at(b) - at(a)) / (b - a);
}

dvec2 catmullRom(dvec2 a, dvec2 b, dvec2 c, dvec2 d, double t) {
  return 0.5 * (2.0 * b + t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a))));
}

// Returns the unit vector to the right of the direction of travel.
dvec2 rightOf(dvec2 direction) {
  const double length = glm::length(direction);
  return length > 0 ? dvec2(direction.y, -direction.x) / length : dvec2(1, 0);
}

// Below a detail of kAllMembers, profiles lose their small members, up to kCoarsest meters deep.
constexpr double kAllMembers = 0.45, kCoarsest = 0.05;

double membersLost(const Detail& detail) {
  if (detail.scale >= kAllMembers) return 0;
  return std::min(kCoarsest, 0.011 * (kAllMembers / detail.scale - 1));
}

double distanceToChord(dvec2 p, dvec2 a, dvec2 b) {
  const dvec2 ab = b - a;
  const double squared = glm::dot(ab, ab);
  const double t = squared > 0 ? std::clamp(glm::dot(p - a, ab) / squared, 0.0, 1.0) : 0.0;
  return glm::length(p - a - ab * t);
}

// Marks the points to keep between `first` and `last` (Douglas and Peucker 1973, Algorithms for the reduction of the
// number of points required to represent a digitized line or its caricature).
void keepFarPoints(const std::vector<dvec2>& points, size_t first, size_t last, double tolerance,
                   std::vector<bool>& keep) {
  size_t farthest = first;
  double far = tolerance;
  for (size_t i = first + 1; i < last; ++i) {
    const double d = distanceToChord(points[i], points[first], points[last]);
    if (d > far) {
      far = d;
      farthest = i;
    }
  }
  if (farthest == first) return;
  keep[farthest] = true;
  keepFarPoints(points, first, farthest, tolerance, keep);
  keepFarPoints(points, farthest, last, tolerance, keep);
}

// Returns the simplified profile. Vertices with a bend of less than about 50 degrees become smooth.
std::vector<Profile::Run> simplified(const std::vector<Profile::Run>& runs, double tolerance) {
  std::vector<dvec2> points;
  for (const Profile::Run& run : runs)
    for (const Profile::Point& p : run)
      if (points.empty() || glm::length(p.position - points.back()) > 1e-9) points.push_back(p.position);
  dvec2 low = points.front(), high = low;
  for (const dvec2 p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  tolerance = std::min(tolerance, 0.3 * std::min(high.x - low.x, high.y - low.y));  // preserves slender profiles
  std::vector<bool> keep(points.size());
  keep.front() = keep.back() = true;
  keepFarPoints(points, 0, points.size() - 1, tolerance, keep);
  std::vector<dvec2> kept;
  for (size_t i = 0; i < points.size(); ++i)
    if (keep[i]) kept.push_back(points[i]);

  std::vector<Profile::Run> result(1);
  double length = 0;
  dvec2 before = rightOf(kept[1] - kept[0]);
  for (size_t i = 0; i < kept.size(); ++i) {
    if (i > 0) length += glm::length(kept[i] - kept[i - 1]);
    const dvec2 after = i + 1 < kept.size() ? rightOf(kept[i + 1] - kept[i]) : before;
    if (glm::dot(before, after) > 0.64) {
      result.back().push_back({kept[i], glm::normalize(before + after), length});
    } else {
      result.back().push_back({kept[i], before, length});
      result.push_back({{kept[i], after, length}});
    }
    before = after;
  }
  return result;
}

}  // namespace

Profile::Profile(double x, double y) : start_(x, y), end_(x, y) {}

void Profile::push(std::function<dvec2(double)> at, double segments, uint32_t least, dvec2 end) {
  elements_.push_back({std::move(at), segments, least, smoothNext_ && !elements_.empty()});
  smoothNext_ = false;
  end_ = end;
}

Profile& Profile::line(double x, double y) {
  const dvec2 a = end_, b(x, y);
  push([a, b](double t) { return t >= 1 ? b : a + (b - a) * t; }, 0.5, 1, b);
  return *this;
}

Profile& Profile::arc(double x, double y, double quarters, double segmentsPerQuarter) {
  const dvec2 a = end_, b(x, y);
  // The center lies on the chord's bisector, at a distance of half the chord over tan(half the angle).
  const double half = quarters * 0.5;
  const dvec2 chord = b - a, left(-chord.y, chord.x);
  const dvec2 center = (a + b) * 0.5 + left * (0.5 * cosQuarters(half) / sinQuarters(half));
  const dvec2 spoke = a - center;
  push(
      [=](double t) {
        if (t <= 0) return a;
        if (t >= 1) return b;
        const double c = cosQuarters(quarters * t), s = sinQuarters(quarters * t);
        return center + dvec2(spoke.x * c - spoke.y * s, spoke.x * s + spoke.y * c);
      },
      segmentsPerQuarter * std::abs(quarters), std::abs(quarters) > 1.2 ? 2 : 1, b);
  return *this;
}

Profile& Profile::curve(const std::vector<dvec2>& points, double segmentsEach) {
  auto all = std::make_shared<std::vector<dvec2>>();
  all->push_back(end_);
  all->insert(all->end(), points.begin(), points.end());
  const size_t spans = points.size();
  push(
      [all, spans](double t) {
        if (t >= 1) return all->back();
        const double s = t * double(spans);
        const size_t k = std::min(spans - 1, static_cast<size_t>(s));
        const auto& p = *all;
        const dvec2 before = k > 0 ? p[k - 1] : 2.0 * p[0] - p[1];
        const dvec2 after = k + 2 < p.size() ? p[k + 2] : 2.0 * p[k + 1] - p[k];
        return catmullRom(before, p[k], p[k + 1], after, s - double(k));
      },
      segmentsEach * double(spans), static_cast<uint32_t>((spans + 1) / 2), points.back());
  return *this;
}

Profile& Profile::smooth() {
  smoothNext_ = true;
  return *this;
}

Profile& Profile::whole() {
  whole_ = true;
  return *this;
}

Profile& Profile::segments(double normal, uint32_t least) {
  elements_.back().segments = normal;
  elements_.back().least = least;
  return *this;
}

std::vector<Profile::Run> Profile::sample(const Detail& detail) const {
  std::vector<Run> runs;
  double length = 0;
  dvec2 last = start_;
  for (const Element& element : elements_) {
    if (!element.smoothBefore) runs.emplace_back();
    Run& run = runs.back();
    const uint32_t n = detail.segments(element.segments, element.least);
    for (uint32_t i = element.smoothBefore ? 1 : 0; i <= n; ++i) {
      const double t = double(i) / n;
      const dvec2 p = element.at(t);
      length += glm::length(p - last);
      last = p;
      run.push_back({p, rightOf(derivative(element.at, t)), length});
    }
  }
  const double lost = whole_ ? 0 : membersLost(detail);
  return lost > 0 ? simplified(runs, lost) : runs;
}

Path circle(const Axis& axis, uint32_t columns, double radius) {
  Path path = circleArc(axis, 0, 1, columns, radius);
  path.closed = true;
  path.wholeTiles = kTau * radius;
  return path;
}

Path circleArc(const Axis& axis, double firstTurn, double lastTurn, uint32_t columns, double radius) {
  const dvec3 side = glm::cross(axis.axis, axis.from);
  Path path;
  path.columns = columns;
  path.frame = [=](double u) {
    const dvec2 cs = onCircle(firstTurn + (lastTurn - firstTurn) * u);
    return PathFrame{axis.origin, axis.from * cs.x + side * cs.y, axis.axis,
                     (lastTurn - firstTurn) * u * kTau * radius};
  };
  return path;
}

Path straight(dvec3 from, dvec3 to, dvec3 x, dvec3 y, uint32_t columns) {
  Path path;
  path.columns = columns;
  const double length = glm::length(to - from);
  path.frame = [=](double u) { return PathFrame{u >= 1 ? to : from + (to - from) * u, x, y, length * u}; };
  return path;
}

std::vector<Patch> sweep(const Profile& profile, const Path& path, const Detail& detail, double tile) {
  std::vector<Patch> patches;
  const double scale =
      path.wholeTiles > 0 ? std::max(1.0, std::floor(path.wholeTiles / tile + 0.5)) / path.wholeTiles : 1 / tile;
  for (Profile::Run& points : profile.sample(detail)) {
    auto run = std::make_shared<const Profile::Run>(std::move(points));
    Patch patch;
    patch.columns = path.columns;
    patch.rows = static_cast<uint32_t>(run->size() - 1);
    patch.closedU = path.closed;
    patch.pointV0 = path.closed && run->front().position.x == 0;
    patch.pointV1 = path.closed && run->back().position.x == 0;
    patch.surface = [run, frame = path.frame, scale, tile, rows = patch.rows](double u, double v) {
      const PathFrame f = frame(u);
      const Profile::Point& p = (*run)[static_cast<size_t>(v * rows + 0.5)];
      SurfacePoint point;
      point.position = f.origin + f.x * p.position.x + f.y * p.position.y;
      point.normal = glm::normalize(f.x * p.normal.x + f.y * p.normal.y);
      point.tangent = glm::cross(f.y, f.x);
      point.uv = {f.length * scale, -p.length / tile};
      return point;
    };
    patches.push_back(std::move(patch));
  }
  return patches;
}

std::vector<Patch> sweepPolygon(const Profile& profile, const std::vector<dvec2>& corners, bool closed,
                                uint32_t columns, const Detail& detail, double tile) {
  const size_t n = corners.size(), sides = closed ? n : n - 1;
  const auto outward = [&](size_t side) {  // side from corner `side` to the next; z points down, seen from above
    const dvec2 along = glm::normalize(corners[(side + 1) % n] - corners[side % n]);
    return dvec2(-along.y, along.x);
  };
  const auto mitre = [&](size_t corner) {  // miter vector: moves both sides at the corner outwards by 1
    if (!closed && corner == 0) return outward(0);
    if (!closed && corner == n - 1) return outward(n - 2);
    const dvec2 a = outward((corner + n - 1) % n), b = outward(corner);
    return (a + b) / (1 + glm::dot(a, b));
  };
  std::vector<Patch> patches;
  for (Profile::Run& points : profile.sample(detail)) {
    auto run = std::make_shared<const Profile::Run>(std::move(points));
    double start = 0;
    for (size_t side = 0; side < sides; ++side) {
      const dvec2 a = corners[side], b = corners[(side + 1) % n], ma = mitre(side), mb = mitre((side + 1) % n);
      const dvec2 normal = outward(side), along = glm::normalize(b - a);
      Patch patch;
      patch.columns = columns;
      patch.rows = static_cast<uint32_t>(run->size() - 1);
      patch.surface = [=, rows = patch.rows](double u, double v) {
        const Profile::Point& p = (*run)[static_cast<size_t>(v * rows + 0.5)];
        const dvec2 from = a + ma * p.position.x, to = b + mb * p.position.x;
        const dvec2 at = u >= 1 ? to : from + (to - from) * u;
        SurfacePoint point;
        point.position = {at.x, p.position.y, at.y};
        point.normal = glm::normalize(dvec3(normal.x * p.normal.x, p.normal.y, normal.y * p.normal.x));
        point.tangent = {along.x, 0, along.y};
        point.uv = {(start + glm::dot(at - a, along)) / tile, -p.length / tile};
        return point;
      };
      patches.push_back(std::move(patch));
      start += glm::length(b - a);
    }
  }
  return patches;
}

std::vector<dvec2> square(double half) {
  return {{half, half}, {half, -half}, {-half, -half}, {-half, half}};
}

Patch quad(dvec3 a, dvec3 b, dvec3 c, dvec3 d, uint32_t columns, uint32_t rows, double tile) {
  Patch patch;
  patch.columns = columns;
  patch.rows = rows;
  const dvec3 normal = glm::normalize(glm::cross(b - a, d - a)), across = glm::normalize(b - a);
  const dvec3 up = glm::cross(normal, across);
  patch.surface = [=](double u, double v) {
    SurfacePoint point;
    const dvec3 low = u >= 1 ? b : a + (b - a) * u, high = u >= 1 ? c : d + (c - d) * u;
    point.position = v >= 1 ? high : low + (high - low) * v;
    point.normal = normal;
    point.tangent = across;
    point.uv = {glm::dot(point.position, across) / tile, -glm::dot(point.position, up) / tile};
    return point;
  };
  return patch;
}

std::vector<Patch> box(dvec3 min, dvec3 max, uint32_t segments, double tile) {
  const auto corner = [=](int x, int y, int z) {
    return dvec3(x ? max.x : min.x, y ? max.y : min.y, z ? max.z : min.z);
  };
  const auto side = [&](dvec3 a, dvec3 b, dvec3 c, dvec3 d) { return quad(a, b, c, d, segments, segments, tile); };
  return {side(corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)),
          side(corner(1, 0, 0), corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0)),
          side(corner(1, 0, 1), corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1)),
          side(corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0)),
          side(corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0), corner(0, 1, 0)),
          side(corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1))};
}

}  // namespace latelight::scene::builtin
