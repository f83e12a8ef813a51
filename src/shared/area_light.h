// Area lights: rectangles, disks, spheres and tubes that emit uniform radiance.
//
// Light that a surface receives from a shape is the integral of a clamped cosine over the shape's directions, after a
// linear transform by which the cosine fits the lobe of the BRDF (Heitz, Dupuy, Hill and Neubelt 2016, Real-Time
// Polygonal-Light Shading with Linearly Transformed Cosines). A polygon stays a polygon and an ellipse an ellipse.
// Integrals of both are contour integrals (Lambert's formula): the sum over the contour of the angle of each arc,
// times the unit normal of the arc's plane, divided by 2 pi. Two horizons cut the contour exactly, also that of an
// ellipse: that of the cosine, and that of the surface, below which a fitted lobe is 0, too.
//
// A sphere is the disk by which its cone of tangents is bounded. A tube is a closed cylinder, seen as the convex
// polygon of its outline: both lateral edges, and half ellipses of the ends in steps.
#ifndef LATELIGHT_SHARED_AREA_LIGHT_H
#define LATELIGHT_SHARED_AREA_LIGHT_H

#include "shared/light.h"

SH_BEGIN

// The table of fits (scripts/fit_ltc.py): rows of perceptual roughness, columns of sqrt(1 - n.v).
SH_CONST uint kLtcSize = 32u;

// The inverse transform of a lobe, up to its scale: {{a, 0, b}, {0, 1, 0}, {c, 0, d}} by rows, to the frame of the
// cosine from the frame whose z axis is the mirrored direction to the eye, and whose x axis is in the plane of the
// normal.
struct LtcFit {
  float a;
  float b;
  float c;
  float d;
};

// A linear transform from world axes to those in which a lobe is a clamped cosine about z.
struct LobeAxes {
  vec3 x;  // the rows of the transform
  vec3 y;
  vec3 z;
  vec3 horizon;  // normal of the surface's horizon in the cosine's frame, of any length
  float tilted;  // 1: it is not z
  float scale;   // 1 / the part of the cosine's lobe above the surface's horizon
};

// A unit vector perpendicular to a unit vector (Duff et al. 2017, Building an Orthonormal Basis, Revisited).
SH_FUNC vec3 perpendicular(vec3 n) {
  float s = n.z >= 0.0f ? 1.0f : -1.0f;
  float a = -1.0f / (s + n.z);
  return vec3(1.0f + s * n.x * n.x * a, s * n.x * n.y * a, -s * n.x);
}

SH_FUNC LobeAxes cosineAxes(vec3 normal) {
  LobeAxes axes;
  axes.x = perpendicular(normal);
  axes.y = cross(normal, axes.x);
  axes.z = normal;
  axes.horizon = vec3(0.0f, 0.0f, 1.0f);
  axes.tilted = 0.0f;
  axes.scale = 1.0f;
  return axes;
}

SH_FUNC LobeAxes fittedAxes(vec3 normal, vec3 toEye, LtcFit fit) {
  float cosine = clamp(dot(normal, toEye), 1e-4f, 1.0f), sine = sqrt(max(1.0f - cosine * cosine, 0.0f));
  vec3 along = toEye - normal * dot(normal, toEye);
  float squared = dot(along, along);
  vec3 side = squared > 1e-10f ? along * inversesqrt(max(squared, 1e-10f)) : perpendicular(normal);
  vec3 x = side * cosine + normal * sine, mirrored = normal * cosine - side * sine;
  LobeAxes axes;
  axes.x = x * fit.a + mirrored * fit.b;
  axes.y = cross(normal, side);
  axes.z = x * fit.c + mirrored * fit.d;
  // The inverse's transpose transforms the normal. The form factor of the half space above a horizon is (1 + the cosine
  // of the angle between both normals) / 2.
  axes.horizon = vec3(fit.d * sine - fit.c * cosine, 0.0f, fit.a * cosine - fit.b * sine);
  axes.tilted = axes.horizon.x != 0.0f ? 1.0f : 0.0f;
  axes.scale = 2.0f / (1.0f + axes.horizon.z * inversesqrt(dot(axes.horizon, axes.horizon)));
  return axes;
}

SH_FUNC vec3 toLobe(LobeAxes axes, vec3 v) {
  return vec3(dot(axes.x, v), dot(axes.y, v), dot(axes.z, v));
}

// --- contours --------------------------------------------------------------------------------------------------------

// Arc from direction a to direction b, of any length: its angle times the unit normal of its plane.
SH_FUNC vec3 arcIntegral(vec3 a, vec3 b) {
  vec3 normal = cross(a, b - a);  // as cross(a, b), which loses precision for directions that are close
  float sine = length(normal);
  float angle = atan2(sine, dot(a, b));
  return normal * (sine > 0.0f ? angle / max(sine, 1e-37f) : 0.0f);
}

// Where a convex contour goes below a horizon, and where it comes up again.
struct Crossing {
  vec3 sinks;
  vec3 rises;
  float any;  // 1: it does
};

// The part of a convex contour above both horizons.
struct Contour {
  vec3 sum;  // arcs so far
  Crossing surface;
  Crossing cosine;
};
SH_FUNC Contour emptyContour() {
  Contour c;
  c.sum = vec3(0.0f, 0.0f, 0.0f);
  c.surface.sinks = c.sum;
  c.surface.rises = c.sum;
  c.surface.any = 0.0f;
  c.cosine = c.surface;
  return c;
}

// Clips an edge to the part above a horizon. Returns false if there is none.
SH_FUNC bool clipEdge(SH_INOUT(Crossing) crossing, vec3 up, SH_INOUT(vec3) a, SH_INOUT(vec3) b) {
  float heightA = dot(up, a), heightB = dot(up, b);
  if (heightA <= 0.0f && heightB <= 0.0f) return false;
  if (heightA > 0.0f && heightB > 0.0f) return true;
  vec3 cut = a + (b - a) * (heightA / (heightA - heightB));
  crossing.any = 1.0f;
  if (heightA > 0.0f) {
    b = cut;
    crossing.sinks = cut;
  } else {
    a = cut;
    crossing.rises = cut;
  }
  return true;
}
SH_FUNC void addAboveSurface(SH_INOUT(Contour) c, vec3 up, vec3 a, vec3 b) {
  if (clipEdge(c.cosine, up, a, b)) c.sum = c.sum + arcIntegral(a, b);
}
SH_FUNC void addEdge(SH_INOUT(Contour) c, LobeAxes axes, vec3 a, vec3 b) {
  if (axes.tilted > 0.0f && !clipEdge(c.surface, axes.horizon, a, b)) return;
  addAboveSurface(c, vec3(0.0f, 0.0f, 1.0f), a, b);
}
// Closes the contour along the horizons. `up`: the normal of the cosine's.
SH_FUNC vec3 contourIntegral(Contour c, vec3 up) {
  if (c.surface.any > 0.0f) addAboveSurface(c, up, c.surface.sinks, c.surface.rises);
  if (c.cosine.any > 0.0f) c.sum = c.sum + arcIntegral(c.cosine.sinks, c.cosine.rises);
  return c.sum * (0.5f * kInvPi);
}

// --- ellipses --------------------------------------------------------------------------------------------------------

// Three vectors, and the symmetric matrix that they diagonalize (Jacobi 1846).
struct EigenFrame {
  vec3 x;
  vec3 y;
  vec3 z;
  float xx;
  float yy;
  float zz;
  float xy;
  float xz;
  float yz;
};

// The rotation that eliminates the element `pq` between two diagonal elements, as (sine, tangent, cosine).
SH_FUNC vec3 jacobiRotation(float pp, float qq, float pq) {
  if (pq == 0.0f) return vec3(0.0f, 0.0f, 1.0f);
  float theta = (qq - pp) / (2.0f * pq);
  float t = (theta >= 0.0f ? 1.0f : -1.0f) / (abs(theta) + sqrt(1.0f + theta * theta));
  if (abs(theta) > 1e18f) t = 0.5f / theta;
  float c = inversesqrt(1.0f + t * t);
  return vec3(t * c, t, c);
}
SH_FUNC void jacobiSweep(SH_INOUT(EigenFrame) f) {
  vec3 r = jacobiRotation(f.xx, f.zz, f.xz), old = f.x;
  float other = f.xy;
  f.xx = f.xx - r.y * f.xz;
  f.zz = f.zz + r.y * f.xz;
  f.xz = 0.0f;
  f.xy = r.z * other - r.x * f.yz;
  f.yz = r.x * other + r.z * f.yz;
  f.x = old * r.z - f.z * r.x;
  f.z = old * r.x + f.z * r.z;

  r = jacobiRotation(f.yy, f.zz, f.yz);
  old = f.y;
  other = f.xy;
  f.yy = f.yy - r.y * f.yz;
  f.zz = f.zz + r.y * f.yz;
  f.yz = 0.0f;
  f.xy = r.z * other - r.x * f.xz;
  f.xz = r.x * other + r.z * f.xz;
  f.y = old * r.z - f.z * r.x;
  f.z = old * r.x + f.z * r.z;

  r = jacobiRotation(f.xx, f.yy, f.xy);
  old = f.x;
  other = f.xz;
  f.xx = f.xx - r.y * f.xy;
  f.yy = f.yy + r.y * f.xy;
  f.xy = 0.0f;
  f.xz = r.z * other - r.x * f.yz;
  f.yz = r.x * other + r.z * f.yz;
  f.x = old * r.z - f.y * r.x;
  f.y = old * r.x + f.y * r.z;
}

// The integral from 0 to u of 1 / (a + b u^2), for a > 0 and a + b u^2 > 0.
SH_FUNC float quadraticIntegral(float u, float a, float b) {
  float x = u * u * b / a;
  float y = sqrt(abs(x));
  float factor = 1.0f - x * (1.0f / 3.0f - x * (0.2f - x * (1.0f / 7.0f)));
  if (x > 0.03f) factor = atan2(y, 1.0f) / y;
  if (x < -0.03f) {
    y = min(y, 0.9999999f);
    factor = 0.34657359f * log2((1.0f + y) / (1.0f - y)) / y;  // atanh(y) / y
  }
  return u / a * factor;
}

// The cone over the ellipse q(t) = (l1 cos t, l2 sin t, 1) in the frame of its own axes.
struct EllipticCone {
  float l1;
  float l2;
};
SH_FUNC vec3 conePoint(EllipticCone cone, float t) {
  return vec3(cone.l1 * cos(t), cone.l2 * sin(t), 1.0f);
}

// The part of the ellipse above a horizon: the parameters within `halfArc` of `middle`.
struct VisibleArc {
  float middle;
  float halfArc;  // 0: none; more than pi: all
};
SH_FUNC VisibleArc visibleArc(EllipticCone cone, vec3 up) {
  float x = up.x * cone.l1, y = up.y * cone.l2, swing = sqrt(x * x + y * y);
  VisibleArc arc;
  arc.middle = swing > 0.0f ? atan2(y, x) : 0.0f;
  arc.halfArc = up.z >= swing ? 4.0f : 0.0f;
  if (abs(up.z) < swing) arc.halfArc = acos(clamp(-up.z / swing, -1.0f, 1.0f));
  return arc;
}

// The integral of q x q' / |q|^2 from t0 to t1 > t0, less than a turn apart. Its components are elementary.
SH_FUNC vec3 coneArc(EllipticCone cone, float t0, float t1) {
  float a1 = 1.0f + cone.l1 * cone.l1, a2 = 1.0f + cone.l2 * cone.l2, root = sqrt(a1) * sqrt(a2);
  float c0 = cos(t0), s0 = sin(t0), c1 = cos(t1), s1 = sin(t1);
  float turned = a1 * c0 * c1 + a2 * s0 * s1, sine = root * (c0 * s1 - s0 * c1);
  float angle = t1 - t0 < kPi ? max(atan2(sine, turned), 0.0f) : 2.0f * kPi - max(atan2(-sine, turned), 0.0f);
  return vec3(-cone.l2 * (quadraticIntegral(s1, a1, a2 - a1) - quadraticIntegral(s0, a1, a2 - a1)),
              cone.l1 * (quadraticIntegral(c1, a2, a1 - a2) - quadraticIntegral(c0, a2, a1 - a2)),
              cone.l1 * cone.l2 / root * angle);
}

// Adds the part of an arc from t0 to t1 that is within `cosine`.
SH_FUNC void addArc(SH_INOUT(Contour) c, EllipticCone cone, VisibleArc cosine, float t0, float t1) {
  float begin = t0, end = t1;
  if (cosine.halfArc <= kPi) {
    begin = max(t0, cosine.middle - cosine.halfArc);
    end = min(t1, cosine.middle + cosine.halfArc);
    if (begin >= end) return;
    if (begin > t0) {
      c.cosine.rises = conePoint(cone, begin);
      c.cosine.any = 1.0f;
    }
    if (end < t1) {
      c.cosine.sinks = conePoint(cone, end);
      c.cosine.any = 1.0f;
    }
  }
  c.sum = c.sum + coneArc(cone, begin, end);
}

// The contour's integral in the frame of the cone. `up` and `horizon`: the normals of the cosine's horizon and of the
// surface's, of any length.
SH_FUNC vec3 coneIntegral(EllipticCone cone, vec3 up, vec3 horizon, float tilted) {
  VisibleArc cosine = visibleArc(cone, up), surface = cosine;
  if (tilted > 0.0f) surface = visibleArc(cone, horizon);
  if (cosine.halfArc <= 0.0f || surface.halfArc <= 0.0f) return vec3(0.0f, 0.0f, 0.0f);
  float whole = cone.l1 * cone.l2 * inversesqrt(1.0f + cone.l1 * cone.l1) * inversesqrt(1.0f + cone.l2 * cone.l2);
  if (cosine.halfArc > kPi && surface.halfArc > kPi) return vec3(0.0f, 0.0f, whole);
  Contour contour = emptyContour();
  if (tilted <= 0.0f || surface.halfArc > kPi) {
    float t0 = cosine.middle - cosine.halfArc, t1 = cosine.middle + cosine.halfArc;
    contour.sum = coneArc(cone, t0, t1);
    contour.cosine.sinks = conePoint(cone, t1);
    contour.cosine.rises = conePoint(cone, t0);
    contour.cosine.any = 1.0f;
    return contourIntegral(contour, up);
  }
  float t0 = surface.middle - surface.halfArc, t1 = surface.middle + surface.halfArc;
  if (cosine.halfArc > kPi) {
    contour.sum = coneArc(cone, t0, t1);
  } else {
    for (uint i = 0u; i < 3u; ++i) {  // the cosine's arc, and the same a turn away
      VisibleArc turned = cosine;
      turned.middle = cosine.middle + (float(i) - 1.0f) * (2.0f * kPi);
      addArc(contour, cone, turned, t0, t1);
    }
  }
  contour.surface.sinks = conePoint(cone, t1);
  contour.surface.rises = conePoint(cone, t0);
  contour.surface.any = 1.0f;
  return contourIntegral(contour, up);
}

// The contour integral of the ellipse center + u cos t + v sin t in the cosine's frame.
SH_FUNC vec3 ellipseIntegral(LobeAxes axes, vec3 center, vec3 u, vec3 v) {
  float scale = max(max(dot(center, center), dot(u, u)), dot(v, v));
  if (!(scale > 0.0f)) return vec3(0.0f, 0.0f, 0.0f);
  scale = inversesqrt(scale);
  center = center * scale;
  u = u * scale;
  v = v * scale;
  float distance = length(center);
  // The cone's quadric, inverted: u u^T + v v^T - c c^T. In a frame about the center, its small eigenvalues are exact.
  EigenFrame f;
  f.z = distance > 1e-6f ? center * (1.0f / max(distance, 1e-6f)) : normalize(cross(u, v));
  f.x = perpendicular(f.z);
  f.y = cross(f.z, f.x);
  vec3 p = vec3(dot(u, f.x), dot(u, f.y), dot(u, f.z)), q = vec3(dot(v, f.x), dot(v, f.y), dot(v, f.z));
  f.xx = p.x * p.x + q.x * q.x;
  f.yy = p.y * p.y + q.y * q.y;
  f.zz = p.z * p.z + q.z * q.z - distance * distance;
  f.xy = p.x * p.y + q.x * q.y;
  f.xz = p.x * p.z + q.x * q.z;
  f.yz = p.y * p.z + q.y * q.z;
  for (uint i = 0u; i < 5u; ++i) jacobiSweep(f);
  // The axis of the cone is the vector of the only negative eigenvalue.
  vec3 axis = f.z, first = f.x, second = f.y;
  float negative = f.zz, along = f.xx, across = f.yy;
  if (f.xx < negative) {
    axis = f.x;
    first = f.y;
    second = f.z;
    negative = f.xx;
    along = f.yy;
    across = f.zz;
  }
  if (f.yy < negative) {
    axis = f.y;
    first = f.z;
    second = f.x;
    negative = f.yy;
    along = f.zz;
    across = f.xx;
  }
  if (!(negative < 0.0f)) return vec3(0.0f, 0.0f, 0.0f);
  if (dot(axis, center) < 0.0f) {
    axis = axis * -1.0f;
    second = second * -1.0f;
  }
  EllipticCone cone;
  cone.l1 = sqrt(max(along, 0.0f) / -negative);
  cone.l2 = sqrt(max(across, 0.0f) / -negative);
  vec3 horizon = vec3(dot(first, axes.horizon), dot(second, axes.horizon), dot(axis, axes.horizon));
  vec3 inside = coneIntegral(cone, vec3(first.z, second.z, axis.z), horizon, axes.tilted);
  return first * inside.x + second * inside.y + axis * inside.z;
}

// --- shapes ----------------------------------------------------------------------------------------------------------

// A position in the light's space, in which a sphere or tube has radius 1, and a tube extends from -1 to 1 along x.
SH_FUNC vec3 toShape(AreaLight light, vec3 offset) {
  vec3 yz = cross(light.y, light.z), zx = cross(light.z, light.x), xy = cross(light.x, light.y);
  return vec3(dot(yz, offset), dot(zx, offset), dot(xy, offset)) * (1.0f / dot(light.x, yz));
}
SH_FUNC vec3 fromShape(AreaLight light, vec3 p) {
  return light.x * p.x + light.y * p.y + light.z * p.z;
}

// True if the light's emitting side, or the outside of a sphere or tube, faces a position.
SH_FUNC bool emitsToward(AreaLight light, vec3 position) {
  vec3 offset = position - light.center;
  if (light.type == kLightRect || light.type == kLightDisk)
    return light.twoSided != 0u ? dot(light.z, offset) != 0.0f : dot(light.z, offset) > 0.0f;
  vec3 p = toShape(light, offset);
  if (light.type == kLightSphere) return dot(p, p) > 1.0f;
  return abs(p.x) > 1.0f || p.y * p.y + p.z * p.z > 1.0f;
}

// Steps of the polygon along the half circle at each end of a tube.
SH_CONST uint kTubeEndSteps = 6u;

// The outline of a light seen from a position: an ellipse center + u cos t + v sin t, or a polygon of outlinePoint().
// Vectors are relative to the position.
struct Outline {
  uint corners;  // of the polygon; 0: it is an ellipse, or nothing is visible
  float sign;    // 1, or -1 if the polygon turns the other way; 0: nothing is visible
  vec3 center;
  vec3 u;
  vec3 v;
  vec3 p;         // tubes: the position in the light's space
  vec2 to;        // tubes: direction from the axis to it
  float tangent;  // tubes: angle between this direction and the points where tangents touch
};

// Corner i of a polygon. A tube is bounded by the two points of each end at the angle `tangent` from the direction `to`
// p, and by the arc between them that faces p, or the other one at an end that p lies outside of.
SH_FUNC vec3 outlinePoint(AreaLight light, Outline o, uint i) {
  if (light.type == kLightRect)
    return o.center + o.u * (i == 0u || i == 3u ? 1.0f : -1.0f) + o.v * (i < 2u ? 1.0f : -1.0f);
  uint perEnd = kTubeEndSteps + 1u;
  float end = i < perEnd ? 1.0f : -1.0f;
  float step = float(i < perEnd ? i : i - perEnd) / float(kTubeEndSteps);
  float turn = end * o.p.x > 1.0f ? 2.0f * o.tangent - 2.0f * kPi : 2.0f * o.tangent;
  float angle = (turn * step - o.tangent) * end;
  // Points between the tangents lie outside of the circle, so that the polygon has the area of the arc.
  float stepAngle = abs(turn) / float(kTubeEndSteps), inner = float(kTubeEndSteps - 2u);
  float radius = (sqrt(1.0f + inner * float(kTubeEndSteps) * stepAngle / max(sin(stepAngle), 1e-6f)) - 1.0f) / inner;
  if (step == 0.0f || step == 1.0f || stepAngle < 1e-3f) radius = 1.0f;
  float c = cos(angle) * radius, s = sin(angle) * radius;
  return o.center + fromShape(light, vec3(end, o.to.x * c - o.to.y * s, o.to.y * c + o.to.x * s));
}

// A disk has its own outline. A sphere has that of the disk with the same cone of tangents.
SH_FUNC void addSphere(SH_INOUT(Outline) o, AreaLight light) {
  vec3 there = toShape(light, o.center);
  float squared = dot(there, there);
  vec3 way = there * inversesqrt(squared);
  float radius = inversesqrt(max(squared - 1.0f, 1e-12f));
  vec3 x = perpendicular(way);
  o.center = fromShape(light, way);
  o.u = fromShape(light, x) * radius;
  o.v = fromShape(light, cross(way, x)) * radius;
}

// From within its radius, only the near end of a tube is visible.
SH_FUNC void addTube(SH_INOUT(Outline) o, AreaLight light) {
  o.p = toShape(light, o.center * -1.0f);
  float radius2 = o.p.y * o.p.y + o.p.z * o.p.z;
  if (radius2 <= 1.0f) {
    o.center = o.center + light.x * sign(o.p.x);
    o.u = light.y;
    o.v = light.z;
    return;
  }
  float inverse = inversesqrt(radius2);
  o.to = vec2(o.p.y * inverse, o.p.z * inverse);
  o.tangent = acos(min(inverse, 1.0f));
  o.corners = 2u * (kTubeEndSteps + 1u);
  // Seen from outside in the light's space, corners are in the same order from everywhere. Axes that are left-handed
  // mirror it. Corners of small outlines are too close to compute their order from positions.
  o.sign = sign(dot(light.x, cross(light.y, light.z)));
}

SH_FUNC Outline outlineOf(AreaLight light, vec3 position) {
  Outline o;
  o.corners = 0u;
  o.sign = 1.0f;
  o.center = light.center - position;
  o.u = light.x;
  o.v = light.y;
  o.p = o.center;
  o.to = vec2(1.0f, 0.0f);
  o.tangent = 0.0f;
  if (light.type == kLightSphere) addSphere(o, light);
  if (light.type == kLightTube) addTube(o, light);
  if (light.type == kLightRect) {
    o.corners = 4u;
    o.sign = o.sign * sign(dot(cross(light.x, light.y), o.center));
  }
  if (!emitsToward(light, position)) o.sign = 0.0f;
  return o;
}

// Integral of the cosine of `axes` over a light's directions from a position, divided by pi, in the cosine's frame: its
// z component is the form factor, from 0 to 1, and its direction is the mean direction to the light.
SH_FUNC vec3 outlineIntegral(AreaLight light, Outline o, LobeAxes axes) {
  if (o.sign == 0.0f) return vec3(0.0f, 0.0f, 0.0f);
  if (o.corners == 0u) return ellipseIntegral(axes, toLobe(axes, o.center), toLobe(axes, o.u), toLobe(axes, o.v));
  Contour contour = emptyContour();
  vec3 last = toLobe(axes, outlinePoint(light, o, o.corners - 1u));
  for (uint i = 0u; i < o.corners; ++i) {
    vec3 next = toLobe(axes, outlinePoint(light, o, i));
    addEdge(contour, axes, last, next);
    last = next;
  }
  return contourIntegral(contour, vec3(0.0f, 0.0f, 1.0f)) * o.sign;
}
SH_FUNC vec3 areaIntegral(AreaLight light, vec3 position, LobeAxes axes) {
  return outlineIntegral(light, outlineOf(light, position), axes);
}

// The fraction of a lobe in a light's directions.
SH_FUNC float lobeShare(AreaLight light, vec3 position, LobeAxes axes) {
  return saturate(areaIntegral(light, position, axes).z * axes.scale);
}

SH_END

#endif
