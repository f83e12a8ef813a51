// The weight of a fragment in weighted blended OIT (McGuire and Bavoil 2013, Weighted Blended Order-Independent
// Transparency, JCGT 2(2), equation 7). `depth` is the view depth in meters; the equation is meant for 0.1 to 500.
float weightAt(float depth, float alpha) {
  float a = abs(depth) / 5.0, b = abs(depth) / 200.0;
  return alpha * clamp(10.0 / (1e-5 + a * a + pow(b, 6.0)), 1e-2, 3e3);
}
