find_package(Boost REQUIRED)  # headers only: integers of GMP

# Seeded nasty problems, their exact truth found independently, and everything that claims to know it under test.
add_library(lcpbench_attack STATIC
  attack/campaign.cpp attack/contact_problems.cpp attack/contacts.cpp attack/doubtful_problems.cpp
  attack/exact.cpp attack/judge.cpp attack/lcp_problems.cpp attack/problems.cpp attack/subjects.cpp attack/truth.cpp)
target_link_libraries(lcpbench_attack
  PUBLIC lcpbench_certify lcpbench_evaluation lcpbench_generators lcpbench_solver_list Boost::headers lcpbench_gmp)
lcpbench_use_precompiled(lcpbench_attack lcpbench_native_headers)

lcpbench_room(attack LINK lcpbench_attack)
lcpbench_test(attack)
lcpbench_test(inertia_claims)

add_executable(attack attack/main.cpp)
target_link_libraries(attack PRIVATE lcpbench_attack lcpbench_study CLI11::CLI11 nlohmann_json::nlohmann_json)
lcpbench_handles_text(attack)

# The fast share. results/validate/README.md has the long runs.
add_test(NAME attack_lcp COMMAND attack --kind lcp --problems 1700 --seed 15)
add_test(NAME attack_contact COMMAND attack --kind contact --problems 900 --seed 15)
add_test(NAME attack_soft COMMAND attack --kind soft --problems 700 --seed 15)
# Of nearly parallel contacts that yield one is pressed by less than nothing, to rounding: the velocity is that without it.
add_test(NAME attack_soft_velocity
         COMMAND attack --kind soft --seed 20261217 --first 6095 --problems 1 --solvers embedded:auto)
# A given G* with an entry of zero, where the root of G* leaves rounding in the velocity.
add_test(NAME attack_soft_given_inverse COMMAND attack --kind soft --seed 20270101 --first 74446 --problems 1)
# Velocities whose coordinates rest but for the rounding of a system in G.
add_test(NAME attack_soft_resting COMMAND attack --kind soft --seed 20270101 --first 82729 --problems 1)
add_test(NAME attack_contact_resting COMMAND attack --kind contact --seed 20261201 --first 93483 --problems 1)
# What a pressed contact that yields moves was taken for rounding; the velocity is not that of before the impact.
add_test(NAME attack_soft_light COMMAND attack --kind soft --seed 20270301 --first 16414 --problems 1)
# A cone without friction, in the convex model, where M_tt / M_nn is beyond the digits of a quad.
add_test(NAME attack_soft_scales COMMAND attack --kind soft --seed 20270301 --first 69183 --problems 1)
# No proof stays with an answer that is solved, nor holds one where the compliance times u underflows.
add_test(NAME attack_soft_underflow COMMAND attack --kind soft --seed 20270301 --first 82745 --problems 1)
# A G whose refinement in the evaluation does not converge, first seen at a diagonal entry of M.
add_test(NAME attack_soft_conditioned COMMAND attack --kind soft --seed 20261130 --first 485 --problems 1)
# Under sanitizers fewer: they take four times as long, and see the same code.
add_test(NAME attack_doubtful
         COMMAND attack --kind doubtful --problems $<IF:$<BOOL:${LCPBENCH_SANITIZE}>,250,800> --seed 15)
