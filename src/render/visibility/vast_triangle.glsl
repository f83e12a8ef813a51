// Vast triangles: their corners lie far beyond the visible part, such as a ground plane that ends beyond the horizon.
// Rounding such a corner to floats moves it by more than the eye's distance from the plane. The plane and the
// barycentric coordinates on it are therefore computed in double-float arithmetic, as unevaluated sums of two floats
// (Dekker 1971, A Floating-Point Technique for Extending the Available Precision; Knuth 1997, The Art of Computer
// Programming 2, section 4.2.2). This needs no doubles, which many GPUs lack. Include after common.glsl.
#ifndef LATELIGHT_VAST_TRIANGLE_GLSL
#define LATELIGHT_VAST_TRIANGLE_GLSL

// Three double-float numbers hi + lo, with about 48 bits each.
struct Exact3 {
  vec3 hi, lo;
};

Exact3 exact(vec3 v) { return Exact3(v, vec3(0.0)); }

Exact3 exactSum(vec3 a, vec3 b) {
  precise vec3 sum = a + b, part = sum - a;
  precise vec3 lost = (a - (sum - part)) + (b - part);
  return Exact3(sum, lost);
}

Exact3 exactProduct(vec3 a, vec3 b) {
  const float kSplit = 4097.0;  // 2^12 + 1: halves of 12 bits, whose products are exact
  precise vec3 product = a * b, x = a * kSplit, y = b * kSplit;
  precise vec3 aHigh = x - (x - a), bHigh = y - (y - b);
  precise vec3 aLow = a - aHigh, bLow = b - bHigh;
  precise vec3 lost = ((aHigh * bHigh - product) + aHigh * bLow + aLow * bHigh) + aLow * bLow;
  return Exact3(product, lost);
}

Exact3 normalized(vec3 hi, vec3 lo) {
  precise vec3 sum = hi + lo;
  precise vec3 lost = lo - (sum - hi);
  return Exact3(sum, lost);
}

Exact3 add(Exact3 a, Exact3 b) {
  Exact3 s = exactSum(a.hi, b.hi);
  precise vec3 lost = s.lo + (a.lo + b.lo);
  return normalized(s.hi, lost);
}
Exact3 subtract(Exact3 a, Exact3 b) { return add(a, Exact3(-b.hi, -b.lo)); }

Exact3 multiply(Exact3 a, Exact3 b) {
  Exact3 p = exactProduct(a.hi, b.hi);
  precise vec3 lost = p.lo + (a.hi * b.lo + a.lo * b.hi);
  return normalized(p.hi, lost);
}

vec3 rounded(Exact3 a) { return a.hi + a.lo; }

// The sum of the three components, in all components.
Exact3 sumOf(Exact3 a) {
  Exact3 x = Exact3(vec3(a.hi.x), vec3(a.lo.x)), y = Exact3(vec3(a.hi.y), vec3(a.lo.y)), z = Exact3(vec3(a.hi.z), vec3(a.lo.z));
  return add(add(x, y), z);
}
Exact3 dotOf(Exact3 a, Exact3 b) { return sumOf(multiply(a, b)); }

Exact3 crossOf(Exact3 a, Exact3 b) {
  return subtract(multiply(Exact3(a.hi.yzx, a.lo.yzx), Exact3(b.hi.zxy, b.lo.zxy)),
                  multiply(Exact3(a.hi.zxy, a.lo.zxy), Exact3(b.hi.yzx, b.lo.yzx)));
}

// A matrix of floats times a double-float vector.
Exact3 transformed(mat3 m, Exact3 v) {
  Exact3 x = multiply(exact(m[0]), Exact3(vec3(v.hi.x), vec3(v.lo.x)));
  Exact3 y = multiply(exact(m[1]), Exact3(vec3(v.hi.y), vec3(v.lo.y)));
  Exact3 z = multiply(exact(m[2]), Exact3(vec3(v.hi.z), vec3(v.lo.z)));
  return add(add(x, y), z);
}

// Transforms a point from object space to view space.
Exact3 seenExactly(View view, Instance instance, vec3 position) {
  Exact3 offset = add(exactSum(instance.objectToWorld[3], -view.eye), exactSum(instance.translationLow, -view.eyeLow));
  Exact3 relative = add(transformed(mat3(instance.objectToWorld), exact(position)), offset);
  return transformed(mat3(view.worldToView), relative);
}

// The plane of a triangle in view space: the points p with dot(normal, p) = distance.
struct ViewPlane {
  vec3 normal;  // unit
  float distance;
};
ViewPlane planeOf(Exact3 a, Exact3 b, Exact3 c) {
  Exact3 ab = subtract(b, a), ac = subtract(c, a);
  // Scaled, so that the products stay within the range of floats.
  float scale = 1.0 / max(max(length(ab.hi), length(ac.hi)), 1e-37);
  Exact3 normal = crossOf(multiply(ab, exact(vec3(scale))), multiply(ac, exact(vec3(scale))));
  float inverse = inversesqrt(max(dot(normal.hi, normal.hi), 1e-37));
  return ViewPlane(rounded(normal) * inverse, rounded(dotOf(normal, a)).x * inverse);
}

// The barycentric coordinates of b and c at a point of the triangle's plane.
struct VastWeights {
  Exact3 b, c;  // each in all components
};
VastWeights vastWeights(Exact3 a, Exact3 b, Exact3 c, Exact3 point) {
  Exact3 ab = subtract(b, a), ac = subtract(c, a), ap = subtract(point, a);
  Exact3 scale = exact(vec3(1.0 / max(max(length(ab.hi), length(ac.hi)), 1e-37)));
  ab = multiply(ab, scale);
  ac = multiply(ac, scale);
  ap = multiply(ap, scale);
  Exact3 normal = crossOf(ab, ac), square = dotOf(normal, normal);
  Exact3 inverse = exact(1.0 / square.hi);  // refined by one step of Newton's method
  inverse = multiply(inverse, subtract(exact(vec3(2.0)), multiply(square, inverse)));
  return VastWeights(multiply(dotOf(crossOf(ap, ac), normal), inverse), multiply(dotOf(crossOf(ab, ap), normal), inverse));
}
// Interpolates an attribute from its values at the corners.
vec3 attributeOf(VastWeights w, vec3 a, vec3 b, vec3 c) {
  return rounded(add(exact(a), add(multiply(w.b, exactSum(b, -a)), multiply(w.c, exactSum(c, -a)))));
}

// --- clipping --------------------------------------------------------------------------------------------------------

const uint kMaxCorners = 9u;  // of a triangle clipped to six planes

struct VastPolygon {
  Exact3 corners[kMaxCorners];  // view space
  uint count;
};

// Returns the signed distance of a view-space point from a plane of the view volume, positive inside, in all
// components. The planes are near, far, left, right, bottom, top. The side planes lie slightly outside the image, so
// that each remaining corner is about as near as the visible points next to it and fits into floats.
Exact3 vastDistance(View view, Exact3 seen, uint plane) {
  const float kGuard = 1.0625;
  Projection p = view.projection;
  bool perspective = p.kind == kPerspective;
  vec3 n;
  float w = 0.0;
  switch (plane) {
    case 0u:
      n = vec3(0.0, perspective ? 1.0 - p.A : -p.A, 0.0);
      w = perspective ? -p.B : 1.0 - p.B;
      break;
    case 1u:
      n = vec3(0.0, p.A, 0.0);
      w = p.B;
      break;
    default:
      float side = (plane & 1u) == 0u ? -1.0 : 1.0;
      n = plane < 4u ? vec3(side * p.H, 0.0, 0.0) : vec3(0.0, 0.0, side * p.V);
      float offset = kGuard + side * (plane < 4u ? p.X : p.Z);
      if (perspective)
        n.y = offset;
      else
        w = offset;
  }
  return add(sumOf(multiply(exact(n), seen)), exact(vec3(w)));
}

Exact3 vastCrossing(Exact3 inside, Exact3 outside, Exact3 near, Exact3 far) {
  Exact3 over = subtract(near, far), inverse = exact(1.0 / over.hi);
  inverse = multiply(inverse, subtract(exact(vec3(2.0)), multiply(over, inverse)));
  return add(inside, multiply(subtract(outside, inside), multiply(near, inverse)));
}

VastPolygon clipVast(View view, VastPolygon p, uint plane) {
  VastPolygon kept;
  kept.count = 0u;
  for (uint i = 0u; i < p.count; ++i) {
    Exact3 from = p.corners[i], to = p.corners[i + 1u < p.count ? i + 1u : 0u];
    Exact3 fromDistance = vastDistance(view, from, plane), toDistance = vastDistance(view, to, plane);
    bool fromInside = fromDistance.hi.x >= 0.0, toInside = toDistance.hi.x >= 0.0;
    if (fromInside && kept.count < kMaxCorners) kept.corners[kept.count++] = from;
    if (fromInside != toInside && kept.count < kMaxCorners)
      kept.corners[kept.count++] = fromInside ? vastCrossing(from, to, fromDistance, toDistance)
                                              : vastCrossing(to, from, toDistance, fromDistance);
  }
  return kept;
}

VastPolygon clipVast(View view, Exact3 corners[3]) {
  VastPolygon p;
  for (uint i = 0u; i < 3u; ++i) p.corners[i] = corners[i];
  p.count = 3u;
  for (uint plane = 0u; plane < 6u; ++plane) p = clipVast(view, p, plane);
  return p;
}

#endif
