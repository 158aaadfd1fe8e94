find_package(Boost REQUIRED)  # headers only: rational numbers
lcpbench_test(certify LINK lcpbench_certify lcpbench_evaluation lcpbench_solver_list Boost::headers)
lcpbench_test(convex_model LINK lcpbench_certify lcpbench_evaluation lcpbench_solver_list)
lcpbench_test(compliance LINK lcpbench_certify lcpbench_evaluation lcpbench_generators lcpbench_solver_list Boost::headers)
lcpbench_test(offset LINK lcpbench_certify lcpbench_evaluation lcpbench_generators lcpbench_solver_list Boost::headers)
lcpbench_test(certify_paper SLOW OPTIMIZED
  LINK lcpbench_certify lcpbench_evaluation lcpbench_generators lcpbench_solver_list Boost::headers)

# Certificates as users and studies get them, and the checker that shares no code with what made them.
lcpbench_test(certificates LINK lcpbench_runner lcpbench_certificates lcpbench_study lcpbench_solver_list nlohmann_json::nlohmann_json)
lcpbench_test(certify_command LINK lcpbench_report lcpbench_study lcpbench_solver_list nlohmann_json::nlohmann_json)
target_compile_definitions(certify_command_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(certify_command_test lcpbench)

find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME check_certificates
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/certify/check_certificates_test.py
                 ${PROJECT_SOURCE_DIR}/study/check_certificates.py $<TARGET_FILE:lcpbench>)
