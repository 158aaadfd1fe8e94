#include <cmath>

#include <sys/random.h>

// What a wheel would take from glibc 2.35 and 2.36, where all else needs 2.34 (cmake/lcpbench_wheel.cmake).
extern "C" {

double __wrap_hypot(double a, double b);
unsigned __wrap_arc4random();

double __wrap_hypot(double a, double b) {
  return static_cast<double>(std::hypot(static_cast<long double>(a), static_cast<long double>(b)));
}

/// std::random_device calls it.
unsigned __wrap_arc4random() {
  unsigned bits = 0;
  while (getrandom(&bits, sizeof bits, 0) != sizeof bits) {
  }
  return bits;
}
}
