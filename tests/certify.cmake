find_package(Boost REQUIRED)  # headers only: rational numbers
lcpbench_test(certify LINK lcpbench_certify lcpbench_evaluation lcpbench_solver_list Boost::headers)
lcpbench_test(certify_paper SLOW LINK lcpbench_certify lcpbench_evaluation lcpbench_generators lcpbench_solver_list Boost::headers)

add_executable(certify_times EXCLUDE_FROM_ALL ${CMAKE_CURRENT_SOURCE_DIR}/certify_times.cpp)
target_link_libraries(certify_times
  PRIVATE lcpbench_certify lcpbench_evaluation lcpbench_generators lcpbench_solver_list lcpbench_statistics)

add_executable(certify_agreement EXCLUDE_FROM_ALL ${CMAKE_CURRENT_SOURCE_DIR}/certify_agreement.cpp)
target_link_libraries(certify_agreement
  PRIVATE lcpbench_certify lcpbench_evaluation lcpbench_generators lcpbench_solver_list)
