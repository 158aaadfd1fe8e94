#pragma once

#include <cstddef>

#include "native/kernels/engine_border.h"

#if !defined(LCPBENCH_LEVEL)
#error "LCPBENCH_LEVEL names the instruction-set level"
#endif

namespace lcpbench::lemke::LCPBENCH_LEVEL {

using Count = std::ptrdiff_t;

#if defined(__AVX512F__)
constexpr Count kPackBytes = 64;
#elif defined(__AVX2__)
constexpr Count kPackBytes = 32;
#else
constexpr Count kPackBytes = 16;
#endif

/// As many scalars as one register of this level holds, and what is done with them lane by lane. A lane is the place of
/// one scalar in the register.
template <class Scalar>
struct Packed {
  typedef Scalar Pack __attribute__((vector_size(kPackBytes)));
  static constexpr Count kWidth = kPackBytes / static_cast<Count>(sizeof(Scalar));

  static Pack load(const Scalar* from) {
    Pack pack;
    __builtin_memcpy(&pack, from, sizeof(pack));
    return pack;
  }
  static void store(Scalar* to, Pack pack) { __builtin_memcpy(to, &pack, sizeof(pack)); }
  static Pack broadcast(Scalar value) { return Pack{} + value; }
  static Pack min(Pack a, Pack b) { return a < b ? a : b; }
  static Pack max(Pack a, Pack b) { return a > b ? a : b; }

  /// Combines the lanes pairwise, in the same order at every call.
  template <class Combine>
  static Scalar reduce(Pack pack, Combine combine) {
    if constexpr (kWidth == 4) {  // in registers: what is stored by packs and loaded by lanes waits for the memory
      typedef Scalar Half __attribute__((vector_size(kPackBytes / 2)));
      const Half low = __builtin_shufflevector(pack, pack, 0, 1), high = __builtin_shufflevector(pack, pack, 2, 3);
      return combine(combine(low[0], high[0]), combine(low[1], high[1]));
    }
    Scalar lanes[static_cast<std::size_t>(kWidth)];
    store(lanes, pack);
    for (Count half = kWidth / 2; half > 0; half /= 2) {
      for (Count lane = 0; lane < half; ++lane) lanes[lane] = combine(lanes[lane], lanes[lane + half]);
    }
    return lanes[0];
  }
  static Scalar sum(Pack pack) {
    return reduce(pack, [](Scalar a, Scalar b) { return a + b; });
  }
  static Scalar min(Pack pack) {
    return reduce(pack, [](Scalar a, Scalar b) { return a < b ? a : b; });
  }
  static Scalar max(Pack pack) {
    return reduce(pack, [](Scalar a, Scalar b) { return a > b ? a : b; });
  }
  static Count padded(Count size) { return (size + kWidth - 1) / kWidth * kWidth; }
};

/// Aligned memory that only grows; its content is undefined after resize().
template <class T>
class Buffer {
 public:
  Buffer() = default;
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { free_aligned(data_); }

  void resize(Count size) {
    if (size <= capacity_) return;
    free_aligned(data_);
    data_ = nullptr;
    capacity_ = 0;
    data_ = static_cast<T*>(allocate_aligned(static_cast<std::size_t>(size) * sizeof(T)));
    capacity_ = size;
  }
  void fill(Count size, T value) {
    resize(size);
    for (Count i = 0; i < size; ++i) data_[i] = value;
  }
  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](Count i) { return data_[i]; }
  const T& operator[](Count i) const { return data_[i]; }

 private:
  T* data_ = nullptr;
  Count capacity_ = 0;
};

template <class T>
inline void swap(T& a, T& b) {
  const T kept = a;
  a = b;
  b = kept;
}

template <class Scalar>
constexpr Scalar kInfinity = static_cast<Scalar>(__builtin_inf());

template <class Scalar>
Scalar magnitude(Scalar x) {
  return x < 0 ? -x : x;
}
inline double magnitude(double x) { return __builtin_fabs(x); }

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
