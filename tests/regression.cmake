# Counts of a fixed study. Not under sanitizers: it is long there and would say the same.
lcpbench_test(regression LINK lcpbench_study nlohmann_json::nlohmann_json)
target_compile_definitions(regression_test PRIVATE
  LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>"
  LCPBENCH_PLAN="${CMAKE_CURRENT_SOURCE_DIR}/regression_plan.json"
  LCPBENCH_COUNTS="${CMAKE_CURRENT_SOURCE_DIR}/golden/regression.json")
add_dependencies(regression_test lcpbench)
set_tests_properties(regression PROPERTIES LABELS release-only)
