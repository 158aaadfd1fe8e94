lcpbench_room(evaluation LINK lcpbench_study lcpbench_evaluation SQLite::SQLite3
  DEFINE LCPBENCH_VERDICTS_PAGE="${PROJECT_SOURCE_DIR}/docs/explanation/verdicts.md"
    LCPBENCH_VERDICTS_TABLE="${PROJECT_SOURCE_DIR}/tests/golden/verdicts.md")
foreach(test quad refined_inertia evaluation island_evaluation contact_scale fastest_contact backward_error truth verdict)
  lcpbench_test(${test})
endforeach()

lcpbench_room(inspect
  LINK lcpbench_inspect lcpbench_stability lcpbench_study lcpbench_generators lcpbench_solver_list
    nlohmann_json::nlohmann_json
  NEEDS lcpbench DEFINE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>"
    LCPBENCH_INSPECT_PAGE="${PROJECT_SOURCE_DIR}/docs/reference/inspect.md"
    LCPBENCH_INSPECT_SOURCES="${PROJECT_SOURCE_DIR}/study/inspect")
lcpbench_test(inspect)
lcpbench_test(stability)

# A judge written from the page that defines verdicts agrees with the program.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME verdicts
  COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/evaluation/verdicts_test.py $<TARGET_FILE:lcpbench>)
add_test(NAME liars
  COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/evaluation/liars_test.py $<TARGET_FILE:lcpbench>)
