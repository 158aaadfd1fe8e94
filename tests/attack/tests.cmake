find_package(Boost REQUIRED)  # headers only: integers of GMP

# Seeded nasty problems, their exact truth found independently, and everything that claims to know it under test.
add_library(lcpbench_attack STATIC
  attack/contact_problems.cpp attack/contacts.cpp attack/doubtful_problems.cpp
  attack/exact.cpp attack/forgers.cpp attack/judge.cpp attack/lcp_problems.cpp attack/limit_problems.cpp attack/problems.cpp attack/row_problems.cpp attack/subjects.cpp attack/truth.cpp)
target_link_libraries(lcpbench_attack
  PUBLIC lcpbench_certify lcpbench_evaluation lcpbench_generators lcpbench_solver_list Boost::headers lcpbench_gmp)
lcpbench_use_precompiled(lcpbench_attack lcpbench_native_headers)

lcpbench_room(attack LINK lcpbench_attack
              DEFINE RECORDED_PROBLEMS="${CMAKE_CURRENT_SOURCE_DIR}/attack/recorded.jsonl")
lcpbench_test(attack)
lcpbench_test(recorded)
lcpbench_test(solve_error)

add_executable(attack attack/main.cpp)
target_link_libraries(attack PRIVATE lcpbench_attack lcpbench_io CLI11::CLI11 Threads::Threads)

# The fast share. results/validate/README.md has the long runs.
add_test(NAME attack_lcp COMMAND attack --kind lcp --problems 1700 --seed 15)
add_test(NAME attack_mixed COMMAND attack --kind mixed --problems 850 --seed 15)
add_test(NAME attack_contact COMMAND attack --kind contact --problems 900 --seed 15)
add_test(NAME attack_soft COMMAND attack --kind soft --problems 700 --seed 15)
add_test(NAME attack_limits COMMAND attack --kind limits --problems 500 --seed 15)
add_test(NAME attack_rows COMMAND attack --kind rows --problems 600 --seed 15)
add_test(NAME attack_rank COMMAND attack --kind rank --problems 400 --seed 15)
# Under sanitizers fewer: they take four times as long, and see the same code.
add_test(NAME attack_doubtful
         COMMAND attack --kind doubtful --problems $<IF:$<BOOL:${LCPBENCH_SANITIZE}>,250,800> --seed 15)
