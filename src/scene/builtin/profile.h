// Moldings: profiles drawn in a plane and swept along a line, a circle or an arch. Nearly all architecture of the
// built-in scenes consists of these.
//
// A profile's x points away from the axis or the wall, its y along the axis or up. The outside is to the right of its
// direction of travel, so a column's profile runs upwards.
#pragma once

#include <functional>
#include <vector>

#include "scene/builtin/mesh_plan.h"

namespace latelight::scene::builtin {

class Profile {
 public:
  Profile(double x, double y);

  // Appends a straight line to a point. It forms a sharp edge with the previous element, unless smooth() was called in
  // between.
  Profile& line(double x, double y);
  // Appends a circular arc that bends by `quarters` of a full turn: positive to the left (a convex molding), negative
  // to the right (a concave one).
  Profile& arc(double x, double y, double quarters, double segmentsPerQuarter = 3);
  // Appends a smooth curve (Catmull-Rom spline) through the points.
  Profile& curve(const std::vector<dvec2>& points, double segmentsEach = 2);
  // The next element continues the previous one without a sharp edge.
  Profile& smooth();
  Profile& segments(double normal, uint32_t least = 1);  // sets the last element's segments at detail 1

  // Preserves all members at low detail. Thin shells require this, because their two sides would otherwise cross.
  Profile& whole();

  struct Point {
    dvec2 position, normal;
    double length = 0;  // meters along the profile from its start
  };
  // The points between two sharp edges.
  using Run = std::vector<Point>;
  // Samples the profile. Finer moldings are omitted at low detail.
  std::vector<Run> sample(const Detail& detail) const;

 private:
  struct Element {
    std::function<dvec2(double)> at;  // t in [0, 1]
    double segments;
    uint32_t least;
    bool smoothBefore;
  };
  void push(std::function<dvec2(double)> at, double segments, uint32_t least, dvec2 end);
  std::vector<Element> elements_;
  dvec2 start_, end_;
  bool smoothNext_ = false, whole_ = false;
};

// The frame of a profile along its path: position = origin + x X + y Y. The path runs towards Y x X (cross product).
struct PathFrame {
  dvec3 origin, x, y;
  double length = 0;  // meters along the path, for uv
};

struct Path {
  uint32_t columns = 1;
  bool closed = false;
  double wholeTiles = 0;  // length of a closed path in meters, rounded to full tiles to match at the seam
  std::function<PathFrame(double u)> frame;
};

// An axis, and the direction from it at which the sweep begins. The sweep rotates from `from` towards cross(axis,
// from).
struct Axis {
  dvec3 origin{0}, axis{0, 1, 0}, from{1, 0, 0};
};
Path circle(const Axis& axis, uint32_t columns, double radius);
// An arc between two angles in turns; `radius` scales its uv.
Path circleArc(const Axis& axis, double firstTurn, double lastTurn, uint32_t columns, double radius);
Path straight(dvec3 from, dvec3 to, dvec3 x, dvec3 y, uint32_t columns);

// Sweeps the profile along the path. `tile` is the side of the material's texture in meters.
std::vector<Patch> sweep(const Profile& profile, const Path& path, const Detail& detail, double tile = 1);

// Sweeps the profile along the sides of a convex polygon around +Y (counter-clockwise as seen from above), with mitered
// corners. Profile x is measured outwards from the sides. Open polygons omit the side from the last corner to the
// first.
std::vector<Patch> sweepPolygon(const Profile& profile, const std::vector<dvec2>& cornersXZ, bool closed,
                                uint32_t columns, const Detail& detail, double tile = 1);

// Returns the corners of a square around the origin, for sweepPolygon().
std::vector<dvec2> square(double half);

// Returns a flat polygon with three or four corners as one patch: u runs from a to b, v from a to d, and the front is
// towards cross(ab, ad).
Patch quad(dvec3 a, dvec3 b, dvec3 c, dvec3 d, uint32_t columns, uint32_t rows, double tile = 1);

// Returns all six sides of an upright box.
std::vector<Patch> box(dvec3 min, dvec3 max, uint32_t segments, double tile = 1);

}  // namespace latelight::scene::builtin
