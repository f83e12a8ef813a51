// The weight of a fragment in order-independent sums (McGuire and Bavoil 2013, Weighted Blended Order-Independent
// Transparency, JCGT 2(2)).
// Equation 7, for depths between 0.1 and 500; here in metres.
float weightAt(float depth, float alpha) {
  float a = abs(depth) / 5.0, b = abs(depth) / 200.0;
  return alpha * clamp(10.0 / (1e-5 + a * a + pow(b, 6.0)), 1e-2, 3e3);
}
