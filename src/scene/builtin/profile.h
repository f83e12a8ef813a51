// Mouldings: a profile drawn in the plane, and swept along a line, a circle or an arch. Nearly all architecture is made
// of these.
//
// A profile's x points away from the axis or the wall, its y along the axis or up; the outside is to the right of its
// direction of travel, so a column's profile runs upwards.
#pragma once

#include <functional>
#include <vector>

#include "scene/builtin/mesh_plan.h"

namespace latelight::scene::builtin {

class Profile {
 public:
  Profile(double x, double y);

  // Straight to a point; it meets the previous element in a sharp edge, unless smooth() was called between.
  Profile& line(double x, double y);
  // A circular arc; `quarters` of a full turn it bends, positive to the left (a convex moulding), negative to the right
  // (a concave one).
  Profile& arc(double x, double y, double quarters, double segmentsAQuarter = 3);
  // A smooth curve (Catmull-Rom) through the points.
  Profile& curve(const std::vector<dvec2>& points, double segmentsEach = 2);
  // The next element continues the last one without an edge.
  Profile& smooth();
  Profile& segments(double normal, uint32_t least = 1);  // of the last element, at detail 1

  // Keeps all members at low detail: for thin shells, whose two sides would cross.
  Profile& whole();

  struct Point {
    dvec2 position, normal;
    double length = 0;  // metres along the profile from its start
  };
  // Points between two sharp edges.
  using Run = std::vector<Point>;
  // At low detail, finer mouldings are left out.
  std::vector<Run> sample(const Detail& detail) const;

  double meanX() const;

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

// The position of a profile along its path: position = origin + x X + y Y, and the path goes towards Y x X (cross
// product).
struct Frame {
  dvec3 origin, x, y;
  double length = 0;  // metres along the path, for uv
};

struct Path {
  uint32_t columns = 1;
  bool closed = false;
  double wholeTiles = 0;  // length of a closed path, metres, rounded to whole tiles so that textures meet
  std::function<Frame(double u)> frame;
};

// An axis, and the direction from it where the sweep begins; it rotates from `from` towards axis x from.
struct Axis {
  dvec3 origin{0}, axis{0, 1, 0}, from{1, 0, 0};
};
Path circle(const Axis& axis, uint32_t columns, double radius);
// Turns from first to last; `radius` scales its uv.
Path circleArc(const Axis& axis, double firstTurn, double lastTurn, uint32_t columns, double radius);
Path straight(dvec3 from, dvec3 to, dvec3 x, dvec3 y, uint32_t columns);

// `tile` is the side of the material's texture in metres.
std::vector<Patch> sweep(const Profile& profile, const Path& path, const Detail& detail, double tile = 1);

// Along the sides of a convex polygon around +Y (counter-clockwise seen from above), mitred at its corners; profile x
// is measured outwards from its sides. Open polygons leave out the side from the last corner to the first.
std::vector<Patch> sweepPolygon(const Profile& profile, const std::vector<dvec2>& cornersXZ, bool closed,
                                uint32_t columns, const Detail& detail, double tile = 1);

// The corners of a square around the origin, for sweepPolygon().
std::vector<dvec2> square(double half);

// A flat polygon with three or four corners as one patch: a b along u, a d along v, front towards ab x ad.
Patch quad(dvec3 a, dvec3 b, dvec3 c, dvec3 d, uint32_t columns, uint32_t rows, double tile = 1);

// All six sides of an upright box.
std::vector<Patch> box(dvec3 min, dvec3 max, uint32_t segments, double tile = 1);

}  // namespace latelight::scene::builtin
