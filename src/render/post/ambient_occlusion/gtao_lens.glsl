// Positions of GTAO through a lens that bends rays. Device depth is that of the distance along each pixel's ray. A
// slice is a plane through the eye, which the image shows as a curve: samples are directions in that plane, and the
// lens projects each one to the pixel whose depth it reads. Included by gtao.glsl.

// 1 / distance of a device depth.
float inverseDistance(View view, float depth) { return (depth - view.projection.A) / view.projection.B; }

// Where the surface continues in a direction of the image.
struct LensNeighbor {
  vec3 way;      // to its ray
  float change;  // of 1 / distance
  bool known;
};

LensNeighbor lensNeighbor(FrameConstants frame, View view, ivec3 place, float here, ivec2 offset) {
  LensNeighbor n = LensNeighbor(vec3(0.0), 0.0, false);
  ivec3 at = place + ivec3(offset, 0);
  if (any(lessThan(at.xy, ivec2(0))) || any(greaterThanEqual(at.xy, ivec2(view.size)))) return n;
  float depth = texelFetch(gbufferDepth, at, 0).r;
  n.way = lensRay(frame, view, at.xy).direction - lensRay(frame, view, place.xy).direction;
  n.change = inverseDistance(view, depth) - here;
  n.known = depth != 0.0;
  return n;
}

// Returns the neighbor that is nearer in depth, as in slopeAt(). Neighbors on another face of a cube map are ignored,
// because their rays are much farther apart.
LensNeighbor nearerNeighbor(LensNeighbor a, LensNeighbor b) {
  if (!a.known || !b.known) return a.known ? a : b;
  float lengthA = dot(a.way, a.way), lengthB = dot(b.way, b.way);
  if (lengthA > 4.0 * lengthB) return b;
  if (lengthB > 4.0 * lengthA) return a;
  return abs(a.change) < abs(b.change) ? a : b;
}

// Returns the plane through the pixel's surface point and its neighbors'. With the pixel's unit ray r and `here` = 1 /
// distance, the plane is here * r + u for a vector u across the ray, and each neighbor states a linear equation for u.
vec3 planeThrough(Center c, vec3 ray, float here, LensNeighbor x, LensNeighbor y) {
  if (!x.known || !y.known) return here * ray;
  vec2 a = vec2(dot(x.way, c.right), dot(x.way, c.down)), b = vec2(dot(y.way, c.right), dot(y.way, c.down));
  // Unit rays: dot(r, way) = -|way|^2 / 2.
  float atA = x.change + 0.5 * here * dot(x.way, x.way), atB = y.change + 0.5 * here * dot(y.way, y.way);
  float area = a.x * b.y - a.y * b.x;
  if (area == 0.0) return here * ray;
  return here * ray + (c.right * (atA * b.y - atB * a.y) + c.down * (atB * a.x - atA * b.x)) / area;
}

Center lensCenterAt(View view, ivec3 place, float depth) {
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  vec3 ray = lensRay(frame, view, place.xy).direction;
  float here = inverseDistance(view, depth);
  Center c;
  c.place = place;
  c.pixel = vec2(place.xy) + 0.5;
  c.depth = depth;
  c.slope = vec2(0.0);
  c.position = ray / here;
  c.toEye = -ray;
  c.right = normalize(cross(ray, abs(ray.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(0.0, 1.0, 0.0)));
  c.down = cross(ray, c.right);
  // The longer side: at the poles of an equirectangular image, pixels are narrow.
  c.pixelAngle = max(length(lensStep(frame, view, place.xy, ivec2(1, 0))),
                     length(lensStep(frame, view, place.xy, ivec2(0, 1))));
  c.plane = planeThrough(c, ray, here,
                         nearerNeighbor(lensNeighbor(frame, view, place, here, ivec2(-1, 0)),
                                        lensNeighbor(frame, view, place, here, ivec2(1, 0))),
                         nearerNeighbor(lensNeighbor(frame, view, place, here, ivec2(0, -1)),
                                        lensNeighbor(frame, view, place, here, ivec2(0, 1))));
  return c;
}

// Returns the direction from the lens's center to the point in focus on a ray from the view's point of the aperture.
vec3 fromLensCenter(LensCalibration lens, vec3 ray) {
  if (push.aperture == vec2(0.0)) return ray;
  vec3 from = vec3(push.aperture.x, 0.0, push.aperture.y);
  if (lens.model == kLensOpenCv) return from + ray * (push.focus / ray.y);
  float along = dot(from, ray);
  return from + ray * (sqrt(max(along * along + push.focus * push.focus - dot(from, from), 0.0)) - along);
}

// `offset`: in units of the pixel's size, on the plane across its ray.
bool lensSampleAt(View view, Center c, vec2 offset, out vec3 position) {
  position = vec3(0.0);
  vec3 ray = normalize(c.pixelAngle * (offset.x * c.right + offset.y * c.down) - c.toEye);
  LensCalibration lens = LensCalibrationRef(push.lens).v[0];
  LensPoint point = projectFromView(lens, fromLensCenter(lens, ray));
  vec2 exact = point.pixel - 0.5 * view.jitter * view.size * vec2(-1.0, 1.0);
  bool inside = point.known != 0u && all(greaterThanEqual(exact, vec2(0.0))) && all(lessThan(exact, view.size));
  ivec2 texel = ivec2(floor(exact));
  float depth = inside ? texelFetch(gbufferDepth, ivec3(texel, c.place.z), 0).r : 0.0;
  if (depth == 0.0) return false;
  // The sample is moved from the texel's ray to this one along the pixel's own plane, as in sampleAt().
  vec3 moved = ray - lensRay(frameOf(push.frame, gl_WorkGroupID.z), view, texel).direction;
  float inverse = inverseDistance(view, depth) + dot(c.plane, moved);
  position = ray / inverse;
  return inverse > 0.0;
}
