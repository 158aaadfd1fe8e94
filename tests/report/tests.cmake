lcpbench_room(report
  LINK lcpbench_inspect lcpbench_runner lcpbench_report lcpbench_statistics lcpbench_study lcpbench_solver_list
  NEEDS lcpbench
  DEFINE LCPBENCH_PROGRAM="$<TARGET_FILE:lcpbench>" HARD_PLAN="${PROJECT_SOURCE_DIR}/study/run/plans/hard.json")
foreach(test statistics compare summary damaged_store report report_text scenes_report paper_claims hard_report reliability
        coverage screen paper_tables)
  lcpbench_test(${test})
endforeach()
lcpbench_test(statistics_coverage RELEASE_ONLY)  # a simulation of what `statistics` tests
lcpbench_test(hard_study SLOW)

# The program of docs/howto/report.md, run on a report made for it.
add_test(NAME tables_page
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/report/tables_page_test.py $<TARGET_FILE:lcpbench>
                 ${CMAKE_SOURCE_DIR}/docs/howto/report.md)

# The report's page as people use it, in Chromium; skipped where that is missing.
add_executable(page_choices ${CMAKE_CURRENT_SOURCE_DIR}/report/page/choices.cpp)
target_link_libraries(page_choices PRIVATE lcpbench_report)
lcpbench_handles_text(page_choices)
add_test(NAME page
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/report/page/page_test.py $<TARGET_FILE:lcpbench>
                 $<TARGET_FILE:page_choices>)
set_tests_properties(page PROPERTIES SKIP_RETURN_CODE 77 LABELS release-only)

add_test(NAME page_scenes
         COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/report/page/scene_test.py $<TARGET_FILE:lcpbench>)
set_tests_properties(page_scenes PROPERTIES SKIP_RETURN_CODE 77 LABELS release-only)

# The committed page is what its sources make; skipped where npm's packages are missing.
add_test(NAME page_bundle WORKING_DIRECTORY ${CMAKE_SOURCE_DIR}/study/report/page
         COMMAND sh -c "test -d node_modules && command -v node || exit 77; node build.js --check")
set_tests_properties(page_bundle PROPERTIES SKIP_RETURN_CODE 77)
