#pragma once

#include <array>

#include "core/timed_solve.h"
#include "study/evaluation/evaluation.h"

// Which members stand in which columns of `verdicts` and `timings`, in the order of the table.

namespace lcpbench {

inline constexpr std::array kErrorColumns{&Errors::velocity_residual_m_per_s,
                                          &Errors::velocity_residual_relative,
                                          &Errors::natural_residual,
                                          &Errors::backward_componentwise,
                                          &Errors::backward_row_norm,
                                          &Errors::forward_velocity,
                                          &Errors::violation_m_per_s,
                                          &Errors::work_gain_j,
                                          &Errors::complementarity_j,
                                          &Errors::cone_violation,
                                          &Errors::min_z};

inline constexpr const char* kErrorColumnNames =
    "velocity_residual_m_per_s, velocity_residual_relative, natural_residual, backward_componentwise, "
    "backward_row_norm, forward_velocity, violation_m_per_s, work_gain_j, complementarity_j, cone_violation, min_z";

inline constexpr std::array kTimeColumns{&SolveTimes::setup_wall_s, &SolveTimes::setup_cpu_s, &SolveTimes::solve_wall_s,
                                         &SolveTimes::solve_cpu_s, &SolveTimes::transport_s};

inline constexpr const char* kTimeColumnNames =
    "setup_wall_s, setup_cpu_s, solve_wall_s, solve_cpu_s, transport_s, verify_s, repeats";

}  // namespace lcpbench
