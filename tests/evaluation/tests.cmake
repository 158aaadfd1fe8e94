lcpbench_test(quad LINK lcpbench_evaluation)
lcpbench_test(refined_inertia LINK lcpbench_evaluation)
lcpbench_test(evaluation LINK lcpbench_evaluation)
lcpbench_test(island_evaluation LINK lcpbench_evaluation)
lcpbench_test(fastest_contact LINK lcpbench_evaluation)
lcpbench_test(backward_error LINK lcpbench_evaluation)
lcpbench_test(truth LINK lcpbench_evaluation)
lcpbench_test(friction_model LINK lcpbench_certificates)
lcpbench_test(verdict LINK lcpbench_study SQLite::SQLite3)
target_compile_definitions(verdict_test PRIVATE
  LCPBENCH_VERDICTS_PAGE="${PROJECT_SOURCE_DIR}/docs/explanation/verdicts.md"
  LCPBENCH_VERDICTS_TABLE="${PROJECT_SOURCE_DIR}/tests/golden/verdicts.md")
lcpbench_test(inspect LINK lcpbench_inspect lcpbench_generators nlohmann_json::nlohmann_json lcpbench_study)
target_compile_definitions(inspect_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>"
  LCPBENCH_INSPECT_PAGE="${PROJECT_SOURCE_DIR}/docs/reference/inspect.md"
  LCPBENCH_INSPECT_SOURCES="${PROJECT_SOURCE_DIR}/study/inspect")
add_dependencies(inspect_test lcpbench)
lcpbench_test(stability LINK lcpbench_stability lcpbench_study lcpbench_solver_list nlohmann_json::nlohmann_json)
target_compile_definitions(stability_test PRIVATE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>")
add_dependencies(stability_test lcpbench)

# A judge written from the page that defines verdicts agrees with the program.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME verdicts
  COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/evaluation/verdicts_test.py $<TARGET_FILE:lcpbench>)
add_test(NAME liars
  COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/evaluation/liars_test.py $<TARGET_FILE:lcpbench>)
