find_package(Boost REQUIRED)  # headers only: rational numbers
find_package(Python3 REQUIRED COMPONENTS Interpreter)
set(check_certificates CHECK_CERTIFICATES="'${Python3_EXECUTABLE}' '${PROJECT_SOURCE_DIR}/study/check_certificates.py'")
lcpbench_room(certify
  LINK lcpbench_runner lcpbench_certificates lcpbench_certify lcpbench_report lcpbench_study lcpbench_evaluation
    lcpbench_generators lcpbench_solver_list nlohmann_json::nlohmann_json Boost::headers
  NEEDS lcpbench DEFINE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>" ${check_certificates})
lcpbench_test(certify)
lcpbench_test(convex_model)
lcpbench_test(compliance)
lcpbench_test(offset)
lcpbench_test(certify_rows)
lcpbench_test(certify_paper SLOW APART OPTIMIZED
  LINK lcpbench_certificates lcpbench_certify lcpbench_evaluation lcpbench_generators lcpbench_solver_list
  DEFINE ${check_certificates})

# Certificates as users and studies get them, and the checker that shares no code with what made them.
lcpbench_test(certificates)
lcpbench_test(certify_command)
lcpbench_test(friction_model)

add_test(NAME check_certificates
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/certify/check_certificates_test.py
                 ${PROJECT_SOURCE_DIR}/study/check_certificates.py $<TARGET_FILE:lcpbench>)
