#pragma once

#include "native/kernels/pack.h"

#if defined(LCPBENCH_QUAD)
#include "native/kernels/response.h"
#endif

namespace lcpbench::lemke::LCPBENCH_LEVEL {

// What is rounded to double where the solver prepares it: engines of more bits make it afresh from the data.

/// G* by columns, ngc x ngc.
template <class Scalar>
void load_inverse_inertia(const Input& input, Buffer<Scalar>& Ginv) {
  Ginv.resize(input.ngc * input.ngc + 1);  // of an offset the response writes one entry more
#if defined(LCPBENCH_QUAD)
  if (input.contacts != nullptr) {
    Response<Scalar> response;
    response.load(*input.contacts);
    Buffer<Scalar> unit;
    unit.fill(input.ngc, Scalar(0));
    for (Count j = 0; j < input.ngc; ++j) {
      unit[j] = 1;
      response.apply(unit.data(), Ginv.data() + j * input.ngc);
      unit[j] = 0;
    }
    return;
  }
#endif
  for (Count i = 0; i < input.ngc * input.ngc; ++i) Ginv[i] = static_cast<Scalar>(input.Ginv[i]);
}

/// n entries.
template <class Scalar>
void load_constants(const Input& input, Buffer<Scalar>& q) {
  q.resize(input.n);
  for (Count i = 0; i < input.n; ++i) q[i] = static_cast<Scalar>(input.q[i]);
#if defined(LCPBENCH_QUAD)
  for (Count i = 0; input.contacts != nullptr && i < input.dense; ++i) {
    q[i] = 0;
    for (Count g = 0; g < input.ngc; ++g) {
      q[i] += static_cast<Scalar>(input.J[g * input.dense + i]) * static_cast<Scalar>(input.contacts->v[g]);
    }
    for (Count g = input.ngc; i < input.contacts->nc && g < input.contacts->ngc; ++g) {
      q[i] += static_cast<Scalar>(input.contacts->N[i * (g + 1) + g]) * static_cast<Scalar>(input.contacts->v[g]);
    }
  }
#endif
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
