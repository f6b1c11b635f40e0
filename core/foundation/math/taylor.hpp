#pragma once
#include <cmath>

namespace klang {

/// A value with its first and second derivative by time: the scalar that the oscillator puts into the formulas. Enough
/// operations for the formulas of this folder.
struct Taylor {
  double v = 0.0, d = 0.0, dd = 0.0;
  Taylor() = default;
  Taylor(double value) : v(value) {}  // NOLINT: a constant is a Taylor series
  Taylor(double value, double first, double second) : v(value), d(first), dd(second) {}
  /// f(this) with f's value and derivatives at v.
  Taylor chain(double f, double f1, double f2) const { return {f, f1 * d, f2 * d * d + f1 * dd}; }
};

inline Taylor operator+(const Taylor& a, const Taylor& b) { return {a.v + b.v, a.d + b.d, a.dd + b.dd}; }
inline Taylor operator-(const Taylor& a, const Taylor& b) { return {a.v - b.v, a.d - b.d, a.dd - b.dd}; }
inline Taylor operator-(const Taylor& a) { return {-a.v, -a.d, -a.dd}; }
inline Taylor operator*(const Taylor& a, const Taylor& b) {
  return {a.v * b.v, a.d * b.v + a.v * b.d, a.dd * b.v + 2.0 * a.d * b.d + a.v * b.dd};
}
inline Taylor operator/(const Taylor& a, const Taylor& b) {
  const double i = 1.0 / b.v;
  return a * b.chain(i, -i * i, 2.0 * i * i * i);
}
inline bool operator<(const Taylor& a, const Taylor& b) { return a.v < b.v; }
inline bool operator>(const Taylor& a, const Taylor& b) { return a.v > b.v; }

inline Taylor exp(const Taylor& a) {
  const double e = std::exp(a.v);
  return a.chain(e, e, e);
}
inline Taylor log(const Taylor& a) { return a.chain(std::log(a.v), 1.0 / a.v, -1.0 / (a.v * a.v)); }
inline Taylor sqrt(const Taylor& a) {
  const double s = std::sqrt(a.v);
  return a.chain(s, 0.5 / s, -0.25 / (s * a.v));
}
inline Taylor sin(const Taylor& a) {
  const double s = std::sin(a.v);
  return a.chain(s, std::cos(a.v), -s);
}
inline Taylor cos(const Taylor& a) {
  const double c = std::cos(a.v);
  return a.chain(c, -std::sin(a.v), -c);
}
inline Taylor atan(const Taylor& a) {
  const double i = 1.0 / (1.0 + a.v * a.v);
  return a.chain(std::atan(a.v), i, -2.0 * a.v * i * i);
}

}  // namespace klang
